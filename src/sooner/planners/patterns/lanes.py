"""Parallel track and creeping line searches as planners [IAMSAR2019, vol. III, sec. 12]."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import shapely
from numpy.random import Generator

from sooner.decomposition.patterns import Tracks, creeping_line, parallel_track
from sooner.planners.leg_ground import leg_searchers
from sooner.planners.patterns.best_of import best_of
from sooner.planners.patterns.checked import check_overlap, check_positive
from sooner.planners.patterns.searched import Searched
from sooner.planners.planner import Ticks
from sooner.problem import SearchProblem

__all__ = ["CreepingLine", "ParallelTrack"]


@dataclass(frozen=True)
class ParallelTrack:
    """Legs parallel to the long side of the search area, one track spacing apart.

    Search areas are all of the free ground and rectangles about where the person may be; the search commences in any
    of four corners; the judge chooses.

    Parameters
    ----------
    spacing_m : float or None   between tracks; None: the swath's width less the overlap, or by sweep width
    overlap : float             share of the swath that neighbours see both
    """

    spacing_m: float | None = None
    overlap: float = 0.0

    def __post_init__(self) -> None:
        check_positive("spacing_m", self.spacing_m)
        check_overlap(self.overlap)

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs, any number of them."""
        return leg_searchers(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the best after every search area, spacing and corner."""
        return best_of(problem, lambda searched: _laned(searched, parallel_track, self.spacing_m, self.overlap))


@dataclass(frozen=True)
class CreepingLine:
    """Legs parallel to the short side of the search area, from one end of it to the other; else as `ParallelTrack`.

    Parameters
    ----------
    spacing_m : float or None   between tracks; None: the swath's width less the overlap, or by sweep width
    overlap : float             share of the swath that neighbours see both
    """

    spacing_m: float | None = None
    overlap: float = 0.0

    def __post_init__(self) -> None:
        check_positive("spacing_m", self.spacing_m)
        check_overlap(self.overlap)

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs, any number of them."""
        return leg_searchers(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the best after every search area, spacing and corner."""
        return best_of(problem, lambda searched: _laned(searched, creeping_line, self.spacing_m, self.overlap))


def _laned(
    searched: Searched, pattern: Callable[..., Tracks], spacing_m: float | None, overlap: float
) -> Iterator[Tracks]:
    for spacing in searched.spacings(spacing_m, overlap):
        for area in searched.areas(spacing):
            for corner in _corners(area):
                yield pattern(area, spacing, commence=corner)


def _corners(area: Any) -> list[tuple[float, float]]:
    """The corners of the smallest rectangle around."""
    return [(float(x), float(y)) for x, y in shapely.get_coordinates(shapely.oriented_envelope(area))[:4]]
