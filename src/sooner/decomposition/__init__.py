"""How ground is cut into regions, how each is swept, and the modes of a surface."""

from sooner.decomposition.aware import gain_classes, regions_for, spacing_for
from sooner.decomposition.boustrophedon import boustrophedon
from sooner.decomposition.chunks import chunked
from sooner.decomposition.modes import modes
from sooner.decomposition.plow import SWEEP_ORDERS, SweepOrder, coverage_path, coverage_paths, plow_lines
from sooner.decomposition.regions import Regions
from sooner.decomposition.voronoi import voronoi

__all__ = [
    "SWEEP_ORDERS",
    "Regions",
    "SweepOrder",
    "boustrophedon",
    "chunked",
    "coverage_path",
    "coverage_paths",
    "gain_classes",
    "modes",
    "plow_lines",
    "regions_for",
    "spacing_for",
    "voronoi",
]
