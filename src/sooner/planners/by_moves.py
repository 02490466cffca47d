"""One name for two planners: over cells one, over regions the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from numpy.random import Generator

from sooner.planners.planner import Planner
from sooner.problem import Incumbent, SearchProblem
from sooner.problem.regions import RegionMoves

__all__ = ["ByMoves", "moves_of"]


@dataclass(frozen=True)
class ByMoves:
    """Plans with the planner that is made for the problem's moves.

    Parameters
    ----------
    cells, regions : Planner
    """

    cells: Planner
    regions: Planner

    def chosen(self, problem: SearchProblem) -> Planner:
        """The planner for this problem."""
        return self.regions if moves_of(problem) == "regions" else self.cells

    def handles(self, problem: SearchProblem) -> str | None:
        """What the chosen planner handles."""
        return self.chosen(problem).handles(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """The plans of the chosen planner."""
        return self.chosen(problem).plans(problem, rng)


def moves_of(problem: SearchProblem) -> str:
    """`regions` where a searcher moves over regions, else `cells`."""
    return "regions" if any(isinstance(each.moves, RegionMoves) for each in problem.searchers) else "cells"
