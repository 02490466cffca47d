"""How ground is cut into regions, how each is swept, and the modes of a surface."""

from sooner.decomposition.boustrophedon import boustrophedon
from sooner.decomposition.modes import modes
from sooner.decomposition.plow import SWEEP_ORDERS, SweepOrder, coverage_path, coverage_paths, plow_lines
from sooner.decomposition.regions import Regions

__all__ = [
    "SWEEP_ORDERS",
    "Regions",
    "SweepOrder",
    "boustrophedon",
    "coverage_path",
    "coverage_paths",
    "modes",
    "plow_lines",
]
