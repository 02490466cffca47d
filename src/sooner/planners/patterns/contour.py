"""The contour search as a planner [IAMSAR2019, vol. III, sec. 12]."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from numpy.random import Generator

from sooner.decomposition.patterns import Tracks, contour_search
from sooner.errors import InvalidProblemError
from sooner.planners.leg_ground import leg_searchers
from sooner.planners.patterns.best_of import best_of
from sooner.planners.patterns.checked import check_overlap, check_positive
from sooner.planners.patterns.searched import Searched
from sooner.planners.planner import Ticks
from sooner.problem import SearchProblem
from sooner.problem.leg_moves import LegMoves

__all__ = ["Contour"]


@dataclass(frozen=True)
class Contour:
    """Along contour lines from high to low, one track spacing apart over the ground in the mean.

    Over all of the free ground or over rectangles about where the person may be; the judge chooses.

    Parameters
    ----------
    spacing_m : float or None   between lines; None: the swath's width less the overlap, or by sweep width
    overlap : float             share of the swath that neighbours see both
    """

    spacing_m: float | None = None
    overlap: float = 0.0

    def __post_init__(self) -> None:
        check_positive("spacing_m", self.spacing_m)
        check_overlap(self.overlap)

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs over ground whose elevation is known."""
        moves = problem.searchers[0].moves
        if isinstance(moves, LegMoves) and moves.pace.terrain is None:
            return "it follows contour lines, and no elevation came"
        return leg_searchers(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the best after every search area and spacing."""
        return best_of(problem, self._drawn)

    def _drawn(self, searched: Searched) -> Iterator[Tracks]:
        terrain = searched.ground.moves[0].pace.terrain
        assert terrain is not None
        for spacing in searched.spacings(self.spacing_m, self.overlap):
            for area in searched.areas(spacing):
                try:
                    yield contour_search(area, terrain.heights, terrain.cell_m, spacing=spacing)
                except InvalidProblemError:  # level ground, or none whose height is known
                    continue
