"""Coverage without gaps as a planner, for those who must say that ground was searched."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

from numpy.random import Generator

from sooner.decomposition.patterns import Tracks, covering
from sooner.errors import InvalidProblemError
from sooner.planners.leg_ground import leg_searchers
from sooner.planners.patterns.best_of import best_of
from sooner.planners.patterns.checked import check_overlap
from sooner.planners.patterns.searched import Searched
from sooner.planners.planner import Ticks
from sooner.problem import SearchProblem

__all__ = ["NoGap"]

_KEPT = 0.02  # metres: places are kept to the centimetre


@dataclass(frozen=True)
class NoGap:
    """Tracks from which every cell that pays and can be seen is in view, flown from either end.

    Where all sorties together are too short for it, they end early, and the rest is not seen.

    Parameters
    ----------
    overlap : float             share of the swath that neighbouring lanes see both
    """

    overlap: float = 0.1

    def __post_init__(self) -> None:
        check_overlap(self.overlap)

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs, any number of them."""
        return leg_searchers(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the best after either way round."""
        return best_of(problem, self._drawn)

    def _drawn(self, searched: Searched) -> Iterator[Tracks]:
        pace = searched.ground.moves[0].pace
        turn_m = pace.speed_mps**2 / pace.accel_mps2 if isfinite(pace.accel_mps2) else 0.0
        radius = searched.radius_m - min(_KEPT, searched.radius_m / 100)
        try:
            found = covering(searched.polygon, radius, self.overlap, searched.free, turn_m=turn_m)
        except InvalidProblemError:  # nothing that pays can be seen from here
            return
        yield found.tracks
        yield tuple(track[::-1] for track in found.tracks[::-1])
