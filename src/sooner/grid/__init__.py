"""Where things are: cells, neighbours, distances, ways around obstacles."""

from sooner.grid.grid import Connectivity, Grid
from sooner.grid.paths import (
    centres_of,
    distances_m,
    geodesic,
    line_is_clear,
    pruned,
    rows_and_cols,
    shortest_path,
    string_pulled,
    turns_rad,
    way,
)

__all__ = [
    "Connectivity",
    "Grid",
    "centres_of",
    "distances_m",
    "geodesic",
    "line_is_clear",
    "pruned",
    "rows_and_cols",
    "shortest_path",
    "string_pulled",
    "turns_rad",
    "way",
]
