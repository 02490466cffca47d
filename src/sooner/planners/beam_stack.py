"""Beam-stack search over regions: branch and bound in little memory."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, nan

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.planners.branch_and_bound import Searched, arrays, best_walks, check_shares, numbers_of, quickest
from sooner.problem import Incumbent, SearchProblem
from sooner.problem.region_ground import RegionGround, single_region_searcher

__all__ = ["BeamStack"]

LAST = (inf, -1)  # before every child, by hope and key


@dataclass(frozen=True)
class BeamStack:
    """Branch and bound by layers of equally many actions, the best few of each; then back for what was left out.

    Beam-stack search of Zhou and Hansen (2005), which section 8 of [Kuhlman2017] asks for. A layer keeps the `width`
    best children of the layer before, by R + alpha (g - R) [Kuhlman2017, eq. (5)], ties by the key of their actions.
    When no layer follows, the deepest one that left children out makes room for the next best of them, until none
    is left: so it finds a complete walk after one pass, and by the end has left out only what g cannot do better
    than (1 + eta) B, as `BranchAndBound`. B is no part of the order, which must stay the same for as long as a layer
    may come back to it.

    Memory: width nodes for each layer, 4 bytes an action each, whatever the length of the run; and the children of
    one layer, once.

    Parameters
    ----------
    width : int               nodes of a layer; a pass takes width times the number of actions in a plan
    alpha, eta : float        as in `BranchAndBound`; a beam does better with more trust in what is to come
    iterations : float        nodes expanded at most, those come back to included; a layer once begun is finished.
                              inf: until nothing is left out
    apart : bool              as in `BranchAndBound`
    """

    width: int = 16
    alpha: float = 0.9
    eta: float = 0.005
    iterations: float = 6000
    apart: bool = False

    def __post_init__(self) -> None:
        if self.width < 1 or not self.iterations >= 1:
            raise InvalidProblemError(
                f"a width of {self.width} and {self.iterations} iterations came; expected at least 1 of each"
            )
        check_shares(self.alpha, self.eta)

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over regions."""
        return single_region_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield at every record of `searched`."""
        return best_walks(problem, self.searched(problem, rng))

    def searched(self, problem: SearchProblem, rng: Generator) -> Iterator[Searched]:
        """Yield after every layer.

        `iterations` and `expanded` are the same here, and `stored` is the most that was in memory at one time.
        """
        return _Stack(RegionGround.of(problem), self).searched()


@dataclass(frozen=True, eq=False)
class _Layer:
    """Nodes of equally many actions; see `next_layer` for what they hold."""

    links: NDArray[np.int32]
    keys: NDArray[np.int64]
    counts: NDArray[np.int32]
    worst: tuple[float, int] | None = None  # hope and key of the last one kept, where others were left out

    def __len__(self) -> int:
        return len(self.keys)


class _Stack:
    """Layers from the start to the deepest."""

    def __init__(self, ground: RegionGround, planner: BeamStack) -> None:
        self.ground, self.planner = ground, planner
        self.arrays, self.numbers = arrays(ground), numbers_of(ground)
        start = np.array([[-1, -1, ground.first]], np.int32)
        self.layers = [_Layer(start, np.zeros(1, np.int64), np.zeros((1, ground.n_actions), np.int32))]
        self.state, self.best, self.solved = np.zeros(8, np.int64), np.array([-inf]), np.zeros(2, np.int64)
        self.walk: tuple[int, ...] = (quickest(ground),)
        self.paid, self.stored = -inf, 1

    def searched(self) -> Iterator[Searched]:
        """Go deeper while there is something to keep, then back to the deepest layer that left something out."""
        from sooner.planners._branch_kernels import EXPANDED, SOLVED

        began = time.perf_counter()
        first_s, first_value = nan, nan
        after = LAST
        while self.layers and self.state[EXPANDED] < self.planner.iterations:
            layer = self._below(after)
            after = LAST
            if len(layer):
                self.layers.append(layer)
            else:
                after = self._back()
            now = time.perf_counter() - began
            if self.state[SOLVED] and first_s != first_s:
                first_s, first_value = now, float(self.best[0])
            yield self._record(now, first_s, first_value)

    def _below(self, after: tuple[float, int]) -> _Layer:
        """The best children of the deepest layer that come after `after`; none where nothing is left."""
        from sooner.planners._branch_kernels import SOLVED, next_layer

        parents, planner = self.layers[-1], self.planner
        most = len(parents) * int(np.diff(self.ground.way_starts).max())
        links, hopes, keys = np.empty((most, 3), np.int32), np.empty((most, 2)), np.empty(most, np.int64)
        solutions = int(self.state[SOLVED])
        count = next_layer(
            self.arrays, self.numbers, parents.counts, parents.links[:, 2], parents.keys, self.ground.limit_s,
            self.ground.leg_value, *after, self.best, planner.alpha, planner.eta, planner.apart,
            np.zeros(1 << (2 * most).bit_length(), np.int64), self.state, links, hopes, keys, self.solved,
        )  # fmt: skip
        if self.state[SOLVED] > solutions:
            self._take(float(self.best[0]), *self.solved.tolist())
        kept = np.lexsort((keys[:count], -hopes[:count, 0]))[: planner.width]
        if len(kept):
            highest = int(kept[np.argmax(hopes[kept, 1])])
            self._take(float(hopes[highest, 1]), int(links[highest, 0]), int(links[highest, 1]))
        counts = parents.counts[links[kept, 0]]
        counts[np.arange(len(kept)), links[kept, 1]] += 1
        worst = (float(hopes[kept[-1], 0]), int(keys[kept[-1]])) if count > len(kept) else None
        return _Layer(links[kept], keys[kept], counts, worst)

    def _back(self) -> tuple[float, int]:
        """Drop layers down to the parents of the deepest that left children out; answers what came last there."""
        while self.layers:
            worst = self.layers.pop().worst
            if worst is not None:
                return worst
        return LAST

    def _take(self, paid: float, node: int, action: int) -> None:
        """Keep the walk of a node of the deepest layer, and one action, where it has paid most so far."""
        if paid < self.paid:
            return
        self.paid, actions = paid, [action]
        for layer in self.layers[:0:-1]:
            node, action, _ = layer.links[node].tolist()
            actions.append(action)
        self.walk = tuple(reversed(actions))

    def _record(self, seconds: float, first_s: float, first_value: float) -> Searched:
        from sooner.planners._branch_kernels import EXPANDED, GENERATED, SEEN, SOLVED

        self.stored = max(self.stored, sum(map(len, self.layers)))
        expanded, generated, seen, solved = self.state[[EXPANDED, GENERATED, SEEN, SOLVED]].tolist()
        return Searched(
            expanded, expanded, generated, seen, self.stored, solved, seconds, first_s, first_value,
            float(self.best[0]), self.walk, not self.layers,
        )  # fmt: skip
