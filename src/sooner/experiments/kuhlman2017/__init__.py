"""M. J. Kuhlman, M. W. Otte, D. Sofge, S. K. Gupta, "Multipass target search in natural environments", Sensors 17
(2017), 2514: their environments, their planners, every number they print.
"""

__all__: list[str] = []
