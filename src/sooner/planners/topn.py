"""TopN: visit the N best hills, spiralling into and out of each, all segments growing at the same time.

L. Lin, M. A. Goodrich, "Hierarchical heuristic search using a Gaussian mixture model for UAV coverage planning",
IEEE Transactions on Cybernetics 44 (2014), 2532-2544, section IV-D, Fig. 7 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, permutations
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.planners.hill_climb import Best, Cells, Field, Ground, directions, random_state
from sooner.planners.layers import in_parallel
from sooner.planners.mode_goodness import ModeGoodness
from sooner.planners.planner import single_cell_searcher
from sooner.problem import Incumbent, Plan, SearchProblem

__all__ = ["TopN"]

HIERARCHY = ((5, 5), (5, 4), (5, 3), (5, 2), (4, 4), (4, 3), (4, 2), (3, 3), (3, 2), (2, 2))


@dataclass(frozen=True)
class TopN:
    """Path planning over the top N of k Gaussians, in one layer or through the hierarchy; the best path is kept.

    Parameters
    ----------
    layers : tuple of (k, N)     Gaussians to fit, and hills to visit; a mixture is fitted afresh for each layer.
                                 ((5, 3),) is the paper's single layer
    goodness : ModeGoodness      ranks the hills
    kernel : int                 box that breaks ties while segments grow, in cells
    threads : int                layers planned at once; 0 for as many as there are processors

    Notes
    -----
    The paper's joins may turn a fixed wing straight back. Here it never turns back while segments grow, and where
    they join it drops the steps out and back; the steps won are climbed at the end. Distances are those of the
    problem's own graph, around obstacles.
    """

    layers: tuple[tuple[int, int], ...] = HIERARCHY
    goodness: ModeGoodness = ModeGoodness()
    kernel: int = 5
    threads: int = 0

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over cells."""
        return single_cell_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield after every layer, in each direction where there is an end."""
        best = Best(problem)
        work = [(field, k, n) for field in directions(problem) for k, n in self.layers]
        for plan in in_parallel(self._layer, work, rng, self.threads):
            yield best.take(plan)

    def _layer(self, work: tuple[Field, int, int], rng: Generator) -> Plan:
        """One layer; while the hills are too many for the time, the least good is left out."""
        field, k, n = work
        state = random_state(rng)
        hills = [int(cell) for cell in self.goodness.ranked(field, k, rng)[:n]]
        while hills:
            path = self._path(field, hills, state) if _tour_fits(field, hills) else None
            if path is not None:
                return field.plan(path, state)
            hills.pop()
        return field.plan(np.array([field.reach.start]), state)

    def _path(self, field: Field, hills: list[int], state: NDArray[np.int64]) -> Cells | None:
        """Fig. 8; None where the time is too short to begin all segments and join them."""
        ground, rest = field.ground(), list(hills)
        first = field.setting_out(ground, _take_nearest(rest, field.steps_from_start), state)
        left = field.budget - (len(first) - 1)
        last = None
        if field.reach.end >= 0:
            ground.look(field.reach.end)
            goal = _take_nearest(rest, field.steps_to_end) if rest else field.reach.end
            last = ground.straight(field.reach.end, goal, state)
            left -= len(last)
        grown = self._grow(field, ground, first, rest, last, left, state) if left >= 0 else None
        return None if grown is None else _join(ground, first, last, *grown, state)

    def _grow(
        self,
        field: Field,
        ground: Ground,
        first: Cells,
        rest: list[int],
        last: Cells | None,
        left: int,
        state: NDArray[np.int64],
    ) -> tuple[list[Cells], list[int]] | None:
        """All segments at once, each step where it pays most; the trails from their seeds, and the order of joining."""
        from sooner.planners._climb_kernels import grow

        seeds, befores = [int(first[-1])], [_before(first, field.reach.came_from)]
        for hill in rest:
            seeds, befores = [*seeds, hill, hill], [*befores, -1, -1]
        if last is not None:
            seeds, befores = [*seeds, int(last[-1])], [*befores, _before(last, -1)]
        kernel: Any = grow
        trails, sizes, order = kernel(
            field.reach.arrays,
            field.grid.step_coordinates,
            field.grid.obstacles is None,
            *ground.arrays,
            self.kernel,
            np.array(seeds, np.int64),
            np.array(befores, np.int64),
            last is not None,
            left,
            state,
        )
        if len(order) > len(rest):
            return None
        return [trail[:size] for trail, size in zip(trails, sizes, strict=True)], order.tolist()


def _tour_fits(field: Field, hills: list[int]) -> bool:
    """Whether some order of the hills can be flown through, from start to end, in the time."""
    between = {hill: field.grid.distances_from(hill) for hill in hills}
    return any(
        field.steps_from_start[order[0]]
        + sum(int(between[a][b]) for a, b in pairwise(order))
        + field.steps_to_end[order[-1]]
        <= field.budget
        for order in permutations(hills)
    )


def _take_nearest(hills: list[int], steps: NDArray[np.int32]) -> int:
    """Remove and return the hill that the fewest steps lead to."""
    nearest = min(hills, key=lambda hill: int(steps[hill]))
    hills.remove(nearest)
    return nearest


def _before(path: Cells, before: int) -> int:
    return int(path[-2]) if len(path) > 1 else before


def _join(
    ground: Ground, first: Cells, last: Cells | None, trails: list[Cells], order: list[int], state: NDArray[np.int64]
) -> Cells:
    """One path through all segments: into each by the end that the order names, and out by its other end."""
    pieces = [np.concatenate([first, trails[0][1:]])]
    for end in order:
        other = end + 1 if end % 2 else end - 1
        pieces.append(np.concatenate([trails[end][::-1], trails[other]]))
    if last is not None:
        pieces.append(np.concatenate([trails[-1][::-1], last[::-1][1:]]))
    path = pieces[0]
    for piece in pieces[1:]:
        link = ground.straight(int(path[-1]), int(piece[0]), state)
        path = np.concatenate([path, link[1:-1], piece])
    return path
