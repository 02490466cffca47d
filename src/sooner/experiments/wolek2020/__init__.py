"""A. Wolek, S. Cheng, D. Goswami, D. A. Paley, "Cooperative mapping and target search over an unknown occupancy graph
using mutual information", IEEE Robotics and Automation Letters 5 (2020): their maps, their cases, what they print.
"""

__all__: list[str] = []
