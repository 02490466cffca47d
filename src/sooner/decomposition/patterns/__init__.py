"""The classic search patterns, cut to any ground, and tracks that leave no gap."""

from sooner.decomposition.patterns.contour_lines import contour_lines
from sooner.decomposition.patterns.contour_search import contour_search
from sooner.decomposition.patterns.covering import Covering, covering
from sooner.decomposition.patterns.creeping_line import creeping_line
from sooner.decomposition.patterns.expanding_square import expanding_square
from sooner.decomposition.patterns.gaps import gaps
from sooner.decomposition.patterns.lanes import narrowest
from sooner.decomposition.patterns.legs import Tracks, clipped, joined
from sooner.decomposition.patterns.parallel_track import parallel_track
from sooner.decomposition.patterns.sector_search import sector_search

__all__ = [
    "Covering",
    "Tracks",
    "clipped",
    "contour_lines",
    "contour_search",
    "covering",
    "creeping_line",
    "expanding_square",
    "gaps",
    "joined",
    "narrowest",
    "parallel_track",
    "sector_search",
]
