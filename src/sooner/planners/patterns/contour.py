"""The contour search as a planner [IAMSAR2019, vol. III, sec. 12]."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from sooner.decomposition.patterns import Tracks, contour_search
from sooner.errors import InvalidProblemError
from sooner.planners.patterns.searched import Searched
from sooner.planners.patterns.spaced import Spaced
from sooner.problem import SearchProblem
from sooner.problem.leg_moves import LegMoves

__all__ = ["Contour"]


@dataclass(frozen=True)
class Contour(Spaced):
    """Along contour lines from high to low, one track spacing apart over the ground in the mean.

    Over all of the free ground or over rectangles about where the person may be; the judge chooses.
    """

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs over ground whose elevation is known."""
        moves = problem.searchers[0].moves
        if isinstance(moves, LegMoves) and moves.pace.terrain is None:
            return "it follows contour lines, and no elevation came"
        return super().handles(problem)

    def drawn(self, searched: Searched) -> Iterator[Tracks]:
        """Over every search area, at every spacing."""
        terrain = searched.ground.moves[0].pace.terrain
        assert terrain is not None
        for spacing in searched.spacings(self.spacing_m, self.overlap):
            for area in searched.areas(spacing):
                try:
                    yield contour_search(area, terrain.heights, terrain.cell_m, spacing=spacing)
                except InvalidProblemError:  # level ground, or none whose height is known
                    continue
