"""Top2: climb from each of the two best hills to a point between them, and share the time out as pays best.

L. Lin, M. A. Goodrich, "Hierarchical heuristic search using a Gaussian mixture model for UAV coverage planning",
IEEE Transactions on Cybernetics 44 (2014), 2532-2544, section IV-C, Fig. 5 and 6.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.planners.hill_climb import (
    Best,
    Cells,
    Field,
    Ground,
    convolution_kernels,
    directions,
    random_state,
)
from sooner.planners.layers import in_parallel
from sooner.planners.mode_goodness import ModeGoodness
from sooner.planners.planner import single_cell_searcher
from sooner.problem import Incumbent, Plan, Reach, SearchProblem

__all__ = ["Top2"]


@dataclass(frozen=True)
class Top2:
    """Path planning over the top 2 of k Gaussians, in one layer or through the hierarchy; the best path is kept.

    Parameters
    ----------
    layers : tuple of int        Gaussians to fit; (5,) is the paper's single layer
    goodness : ModeGoodness      ranks the hills
    levels : int                 of sharing the time, coarse to fine
    parts : int                  parts into which a level cuts the time
    kernels : int                sizes of the box that breaks ties, as in `GlobalWarming`
    threads : int                layers planned at once; 0 for as many as there are processors
    """

    layers: tuple[int, ...] = (5, 4, 3, 2)
    goodness: ModeGoodness = ModeGoodness()
    levels: int = 6
    parts: int = 4
    kernels: int = 3
    threads: int = 0

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over cells."""
        return single_cell_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield after every layer, in each direction where there is an end."""
        best = Best(problem)
        work = [(field, k) for field in directions(problem) for k in self.layers]
        for plan in in_parallel(self._layer, work, rng, self.threads):
            yield best.take(plan)

    def _layer(self, work: tuple[Field, int], rng: Generator) -> Plan:
        field, k = work
        state = random_state(rng)
        hills = [int(cell) for cell in self.goodness.ranked(field, k, rng)[:2]]
        path = self._path(field, hills, state) if len(hills) == 2 else None
        if path is None and hills:
            path = field.setting_out(field.ground(), hills[0], state)
        return field.plan(np.array([field.reach.start]) if path is None else path, state)

    def _path(self, field: Field, hills: list[int], state: NDArray[np.int64]) -> Cells | None:
        """Fig. 6; None where the time is too short to visit both hills."""
        near, far = sorted(hills, key=lambda hill: int(field.steps_from_start[hill]))
        ground = field.ground()
        path1 = field.setting_out(ground, near, state)
        path4 = np.array([far])
        if field.reach.end >= 0:
            ground.look(field.reach.end)
            path4 = ground.straight(field.reach.end, far, state)
        left = field.budget - (len(path1) - 1) - (len(path4) - 1)
        kernels = convolution_kernels(field.grid, self.kernels)
        halves = _Halves(field, ground, field.goal(_centre(field, near, far)), path1, path4, kernels, state)
        return self._shared(halves, left)

    def _shared(self, halves: _Halves, left: int) -> Cells | None:
        """The best way to share the time that is left between the halves, coarse to fine."""
        least, spare = halves.least2, left - halves.least2 - halves.least3
        if spare < 0:
            return None
        tried: dict[int, tuple[float, Cells]] = {}
        step = spare / self.parts
        wanted = [least + step * n for n in range(self.parts + 1)]
        for _ in range(self.levels):
            for t2 in dict.fromkeys(round(t) for t in wanted):
                if t2 not in tried and least <= t2 <= least + spare:
                    tried[t2] = halves.climbed(t2, left - t2)
            at = max(tried, key=lambda t: tried[t][0])
            step = max(step / self.parts, 1.0)
            wanted = [at + step * n for n in range(1 - self.parts, self.parts)]
        return tried[at][1]


@dataclass(frozen=True, eq=False)
class _Halves:
    """Two climbs that meet: from the nearer hill and from the farther, both to the centre between them."""

    field: Field
    ground: Ground  # after the straight paths
    centre: Reach
    path1: Cells  # from the start to the nearer hill
    path4: Cells  # from the end to the farther hill; that hill alone where there is no end
    kernels: list[int]
    state: NDArray[np.int64]

    @property
    def least2(self) -> int:
        """Fewest steps from the nearer hill to the centre."""
        return int(self.centre.arrays[3][self.path1[-1]])

    @property
    def least3(self) -> int:
        """Fewest steps from the farther hill to the centre."""
        return int(self.centre.arrays[3][self.path4[-1]])

    def climbed(self, t2: int, t3: int) -> tuple[float, Cells]:
        """What both halves collect with so much time each, and the whole path."""
        ground = self.ground.copy()
        path2, gained2 = self._half(ground, self.path1, self.field.reach.came_from, t2)
        if len(self.path4) == 1:
            ground.look(int(self.path4[0]))
        path3, gained3 = self._half(ground, self.path4, -1, t3)
        return gained2 + gained3, np.concatenate([self.path1, path2[1:], path3[::-1][1:], self.path4[::-1][1:]])

    def _half(self, ground: Ground, arriving: Cells, came_from: int, steps: int) -> tuple[Cells, float]:
        """The best climb over the kernels from the last cell of `arriving`; `ground` is left as after it.

        Where a fixed wing cannot be at the centre after so many steps, it takes one fewer, or flies straight.
        """
        cell = int(arriving[-1])
        before = int(arriving[-2]) if len(arriving) > 1 else came_from
        possible = [t for t in (steps, steps - 1) if t >= 0 and self.centre.can_go_on(cell, before, t)]
        if not possible:
            return ground.straight(cell, self.centre.end, self.state), 0.0
        best, path, after = -1.0, arriving, ground
        for kernel in self.kernels:
            trial = ground.copy()
            found, gained = trial.climb(self.centre.arrays, cell, before, possible[0], kernel, self.state)
            if gained > best:
                best, path, after = gained, found, trial
        ground.now[:], ground.looks[:] = after.now, after.looks
        return path, best


def _centre(field: Field, near: int, far: int) -> int:
    """The cell halfway between two hills; halfway along a shortest path where that cannot be reached."""
    (row1, col1), (row2, col2) = field.grid.cell(near), field.grid.cell(far)
    cell = field.grid.index(((row1 + row2) // 2, (col1 + col2) // 2))
    if field.within[cell]:
        return cell
    from_near, from_far = field.grid.distances_from(near), field.grid.distances_from(far)
    half = int(from_near[far]) // 2
    return int(np.flatnonzero((from_near == half) & (from_far == from_near[far] - half))[0])
