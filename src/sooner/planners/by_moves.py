"""One name for several planners: one over cells, one over regions, one along legs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from numpy.random import Generator

from sooner.errors import UnsupportedProblemError
from sooner.planners.planner import Planner
from sooner.problem import Incumbent, SearchProblem
from sooner.problem.leg_moves import LegMoves
from sooner.problem.regions import RegionMoves

__all__ = ["ByMoves", "moves_of"]


@dataclass(frozen=True)
class ByMoves:
    """Plans with the planner that is made for the problem's moves.

    Parameters
    ----------
    cells : Planner
    regions, legs : Planner or None     None: it does not plan these
    """

    cells: Planner
    regions: Planner | None = None
    legs: Planner | None = None

    def chosen(self, problem: SearchProblem) -> Planner | None:
        """The planner for this problem."""
        planner: Planner | None = getattr(self, moves_of(problem))
        return planner

    def handles(self, problem: SearchProblem) -> str | None:
        """What the chosen planner handles."""
        planner = self.chosen(problem)
        return f"it does not plan moves over {moves_of(problem)}" if planner is None else planner.handles(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """The plans of the chosen planner."""
        planner = self.chosen(problem)
        if planner is None:
            raise UnsupportedProblemError(str(self.handles(problem)))
        return planner.plans(problem, rng)


def moves_of(problem: SearchProblem) -> str:
    """`regions` or `legs` where a searcher moves so, else `cells`."""
    kinds = {type(each.moves) for each in problem.searchers}
    return "regions" if RegionMoves in kinds else "legs" if LegMoves in kinds else "cells"
