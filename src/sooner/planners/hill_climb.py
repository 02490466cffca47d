"""Local hill climbing: the step that every planner of Lin & Goodrich takes, and the ground it takes it on.

L. Lin, M. A. Goodrich, "Hierarchical heuristic search using a Gaussian mixture model for UAV coverage planning",
IEEE Transactions on Cybernetics 44 (2014), 2532-2544.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.problem import Gains, Incumbent, Plan, Reach, SearchProblem, evaluate

__all__ = ["JOIN_KERNEL", "Best", "Cells", "Field", "Ground", "convolution_kernels", "directions", "random_state"]

Cells = NDArray[np.int64]
JOIN_KERNEL = 3  # box that breaks ties on straight paths and where segments are joined, in cells
SLACK = 48  # steps beyond the fewest that a fixed wing may need to arrive
Reachable = tuple[Any, ...]  # the leading arguments of the kernel `can_go_on`


@dataclass(frozen=True, eq=False)
class Ground:
    """What looks still pay while paths are being made; climbing changes `now` and `looks`.

    Parameters
    ----------
    table : (N, L) float       gain of the first L looks
    ratio : (N,) float         what each further look pays of the one before
    now : (N,) float           what the next look pays
    looks : (N,) int           looks so far
    grid : Grid
    """

    table: NDArray[np.float64]
    ratio: NDArray[np.float64]
    now: NDArray[np.float64]
    looks: NDArray[np.int64]
    grid: Grid

    @classmethod
    def fresh(cls, table: NDArray[np.float64], ratio: NDArray[np.float64], grid: Grid) -> Ground:
        """Ground that nobody has looked at."""
        return cls(table, ratio, table[:, 0].copy(), np.zeros(len(table), np.int64), grid)

    def copy(self) -> Ground:
        """Ground to climb on without changing this one."""
        return replace(self, now=self.now.copy(), looks=self.looks.copy())

    @property
    def arrays(self) -> tuple[Any, ...]:
        """What the kernels take: table, ratio, now, looks, width."""
        return self.table, self.ratio, self.now, self.looks, self.grid.shape[1]

    def look(self, cell: int) -> float:
        """Collect what the next look at a cell pays."""
        from sooner.planners._climb_kernels import look

        kernel: Any = look
        return float(kernel(*self.arrays[:4], cell))

    def climb(
        self, reach: Reachable, cell: int, before: int, steps: int, kernel: int, state: NDArray[np.int64]
    ) -> tuple[Cells, float]:
        """LHC: `steps` steps, each to the open cell that pays most; ties by the box of `kernel` cells around it.

        Returns the path with `cell`, which has been looked at already, first; and what it collected.
        """
        from sooner.planners._climb_kernels import climb

        function: Any = climb
        path, gained = function(reach, *self.arrays, kernel, cell, before, steps, state)
        return path, float(gained)

    def straight(self, cell: int, goal: int, state: NDArray[np.int64]) -> Cells:
        """A shortest path from `cell` to `goal`, climbing where there is a choice."""
        steps = self.grid.distances_from(goal)
        return self.climb(_walk(self.grid, steps), cell, -1, int(steps[cell]), JOIN_KERNEL, state)[0]


def _walk(grid: Grid, to_goal: NDArray[np.int32]) -> Reachable:
    """The reach of a searcher that may stop and turn at will and has to arrive, as `Reach.arrays` gives it."""
    return grid.neighbours, False, True, to_goal, np.zeros(0, np.int32), np.zeros(0, np.int64), np.zeros(0, np.int32)


@dataclass(frozen=True, eq=False)
class Field:
    """One searcher's problem, flown as posed or from its end to its start.

    Parameters
    ----------
    problem : SearchProblem    the problem as flown in this direction
    asked : SearchProblem      the problem as posed
    asked_reach : Reach        its reach
    """

    problem: SearchProblem
    asked: SearchProblem
    asked_reach: Reach

    @property
    def grid(self) -> Grid:
        """The grid."""
        return self.problem.grid

    @property
    def budget(self) -> int:
        """Steps T."""
        return self.problem.searcher.steps

    @cached_property
    def reach(self) -> Reach:
        """What the searcher can still do from wherever it is, in this direction."""
        if self.problem is self.asked:
            return self.asked_reach
        return Reach(self.grid, self.problem.searcher)

    @cached_property
    def steps_from_start(self) -> NDArray[np.int32]:
        """(N,) int: fewest steps from the start, -1 where there is no way."""
        return self.grid.distances_from(self.reach.start)

    @cached_property
    def steps_to_end(self) -> NDArray[np.int32]:
        """(N,) int: fewest steps to the end; zero everywhere where there is none."""
        if self.reach.end < 0:
            return np.zeros(self.grid.n_cells, np.int32)
        return self.grid.distances_from(self.reach.end)

    @cached_property
    def within(self) -> NDArray[np.bool_]:
        """(N,) bool: cells that can be visited in time, and the end still be reached."""
        there, back = self.steps_from_start, self.steps_to_end
        inside: NDArray[np.bool_] = (there >= 0) & (back >= 0) & (there + back <= self.budget)
        return inside

    @cached_property
    def gains(self) -> Gains:
        """The problem's gains, zero where no flight comes in time."""
        gains = self.problem.gains
        return gains if self.within.all() else Gains(np.where(self.within[:, None], gains.table, 0.0), gains.ratio)

    @cached_property
    def surface(self) -> NDArray[np.float64]:
        """(H, W) float: G', what the first look at each cell pays."""
        return self.gains.first.reshape(self.grid.shape)

    def ground(self) -> Ground:
        """The ground after the look at the start."""
        ground = Ground.fresh(self.gains.table, self.gains.ratio, self.grid)
        ground.look(self.reach.start)
        return ground

    def goal(self, cell: int) -> Reach:
        """The reach of the same aircraft, had it to arrive at `cell`."""
        return Reach(self.grid, replace(self.problem.searcher, end=self.grid.cell(cell)))

    def setting_out(self, ground: Ground, goal: int, state: NDArray[np.int64]) -> Cells:
        """A shortest path from the start; a fixed wing that is already in flight does not begin by turning back."""
        start, before = self.reach.start, self.reach.came_from
        steps = int(self.steps_from_start[goal])
        if self.reach.fixed_wing and before >= 0 and steps > 0:
            reach = self.goal(goal)
            for longer in range(steps, min(steps + SLACK, self.budget) + 1):
                if reach.can_go_on(start, before, longer):
                    return ground.climb(reach.arrays, start, before, longer, JOIN_KERNEL, state)[0]
        return ground.straight(start, goal, state)

    def plan(self, wanted: Cells, state: NDArray[np.int64]) -> Plan:
        """The legal plan of all T steps that follows `wanted` for as long as it can, then climbs.

        A path made from parts may break a rule where they join (a fixed wing turning back) or end early; this is
        where that is put right. `wanted` runs in this direction; the plan runs as the problem was asked.
        """
        from sooner.planners._climb_kernels import fly

        kernel: Any = fly
        reach = self.asked_reach
        cells = np.array(wanted if self.problem is self.asked else wanted[::-1], np.int64)
        if reach.fixed_wing:
            cells = _without_turning_back(cells)
        if cells[0] != reach.start:  # there was no path to turn round
            cells = np.array([reach.start], np.int64)
        ground = Ground.fresh(self.gains.table, self.gains.ratio, self.grid)
        return Plan.of(kernel(reach.arrays, *ground.arrays, JOIN_KERNEL, cells, reach.came_from, self.budget, state))


def _without_turning_back(cells: Cells) -> Cells:
    """The same walk without its hovers, and without the steps that it takes only to undo them at once."""
    kept = [int(cells[0])]
    for cell in cells[1:].tolist():
        if cell == kept[-1]:
            continue
        if len(kept) > 1 and cell == kept[-2]:
            kept.pop()
        else:
            kept.append(cell)
    return np.array(kept, np.int64)


def directions(problem: SearchProblem) -> list[Field]:
    """The problem as asked; where it has an end, also from there to the start: the better path is kept.

    Raises
    ------
    InfeasibleProblemError    where no flight of T steps keeps every rule
    """
    reach = Reach(problem.grid, problem.searcher)
    reach.check()
    fields = [Field(problem, problem, reach)]
    searcher = problem.searcher
    if searcher.end is not None and searcher.end != searcher.start:
        back = replace(searcher, start=searcher.end, end=searcher.start, came_from=None)
        fields.append(Field(replace(problem, searchers=(back,)), problem, reach))
    return fields


class Best:
    """The best plan so far, as an incumbent, and what the last one was worth."""

    def __init__(self, problem: SearchProblem) -> None:
        self.problem = problem
        self.last = -np.inf
        self.incumbent: Incumbent | None = None

    def take(self, plan: Plan) -> Incumbent:
        """The better of what was known and `plan`."""
        self.last = evaluate(self.problem, plan).value
        if self.incumbent is None or self.last > self.incumbent.value:
            self.incumbent = Incumbent(plan, self.last)
        return self.incumbent


def random_state(rng: Generator) -> NDArray[np.int64]:
    """(1,) int: the random state of the kernels."""
    return rng.integers(1, 2**31 - 1, 1)


def convolution_kernels(grid: Grid, count: int) -> list[int]:
    """Sizes of the box that breaks ties: 5, then every third (`count`-th) of the map's larger side, made odd."""
    side = max(grid.shape)
    return [size - 1 + size % 2 for size in range(5, side, max(side // count, 1))] or [5]
