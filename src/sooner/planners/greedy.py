"""One-step greedy: always to the cell within one step whose next look pays most.

F. Bourgault, T. Furukawa, H. F. Durrant-Whyte, "Optimal search for a lost target in a Bayesian world", Springer
Tracts in Advanced Robotics 24 (2006), 209-222: the baseline that [Lin2014] calls BA.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from numpy.random import Generator

from sooner.planners.hill_climb import Best, directions, random_state
from sooner.planners.planner import single_cell_searcher
from sooner.problem import Incumbent, Plan, SearchProblem

__all__ = ["Greedy", "first_flight"]

NO_BOX = 0  # ties are broken at random straight away


@dataclass(frozen=True)
class Greedy:
    """One-step lookahead on the posterior; ties are broken at random.

    After k misses a cell keeps p (1 - g)^k, so the most probable detection is the largest next gain.
    """

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over cells."""
        return single_cell_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield once."""
        field, state = directions(problem)[0], random_state(rng)
        begin = field.reach.start, field.reach.came_from, field.budget
        path, _ = field.ground().climb(field.reach.arrays, *begin, NO_BOX, state)
        yield Best(problem).take(Plan.of(path))


def first_flight(problem: SearchProblem, rng: Generator) -> Plan:
    """A legal plan at once: the start alone, or a greedy flight where it has to end somewhere."""
    if problem.searcher.end is None:
        return Plan.of([problem.grid.index(problem.searcher.start)])
    return next(Greedy().plans(problem, rng)).plan
