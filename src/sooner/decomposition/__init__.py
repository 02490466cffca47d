"""How ground is cut into regions: the modes of a surface."""

from sooner.decomposition.modes import modes

__all__ = ["modes"]
