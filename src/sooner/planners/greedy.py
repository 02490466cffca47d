"""One-step greedy: always to the cell within one step whose next look pays most.

F. Bourgault, T. Furukawa, H. F. Durrant-Whyte, "Optimal search for a lost target in a Bayesian world", Springer
Tracts in Advanced Robotics 24 (2006), 209-222: the baseline that [Lin2014] calls BA.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from sooner.planners.planner import single_cell_searcher
from sooner.problem import Incumbent, Plan, Reach, SearchProblem, evaluate

__all__ = ["Greedy"]


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
        reach = Reach(problem.grid, problem.searcher)
        reach.check()
        path, came_from = [reach.start], reach.came_from
        looks = np.zeros(problem.grid.n_cells, np.int64)
        for steps_left in range(problem.searcher.budget - 1, -1, -1):
            here = path[-1]
            looks[here] += 1
            open_cells = np.array(_open_cells(reach, here, came_from, steps_left))
            pay = problem.gains.of(open_cells, looks[open_cells])
            path.append(int(rng.choice(open_cells[pay == pay.max()])))
            came_from = here
        plan = Plan.of(path)
        yield Incumbent(plan, evaluate(problem, plan).value)


def _open_cells(reach: Reach, here: int, came_from: int, steps_left: int) -> list[int]:
    around = [int(cell) for cell in reach.grid.neighbours[here] if cell >= 0]
    if reach.fixed_wing:
        around = [cell for cell in around if cell != came_from]
    else:
        around.append(here)
    return [cell for cell in around if reach.can_go_on(cell, here, steps_left)]
