"""Where things are: cells, neighbours, distances."""

from sooner.grid.grid import Connectivity, Grid

__all__ = ["Connectivity", "Grid"]
