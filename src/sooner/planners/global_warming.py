"""LHC-GW-CONV: local hill climbing over an ocean that rises, ties broken by convolution.

L. Lin, M. A. Goodrich, "UAV intelligent path planning for wilderness search and rescue", IROS 2009, 709-714;
reviewed as the paper's reference [8] in [Lin2014, section IV-A].
"""

from __future__ import annotations

from collections.abc import Generator as Ticks
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.planners.hill_climb import Best, Field, Ground, convolution_kernels, directions, random_state
from sooner.planners.layers import in_parallel
from sooner.planners.planner import single_cell_searcher
from sooner.problem import Gains, Incumbent, Plan, SearchProblem

Climbs = Ticks[Incumbent, None, float]

__all__ = ["GlobalWarming"]

HEIGHT = 255.0  # of the highest hill, as in the authors' maps


@dataclass(frozen=True)
class GlobalWarming:
    """Climb on the map as it is, and on islands that stand out of an ocean at many heights; keep the best path.

    p'_i = max(p_i - n C, 0)                                                   [Lin2014, eq. (10)]

    Heights are searched coarse to fine: C is a quarter of the highest hill, then a quarter of that; each level
    tries three rises and three falls around the best height so far. A side whose far end lies beyond the hills
    is left out. A fall adds C to every cell, to drowned ones too, as in the authors' program.

    Parameters
    ----------
    levels : int        of height, coarse to fine
    parts : int         parts into which a level cuts the height
    kernels : int       sizes of the box that breaks ties, from 5 cells to most of the map
    threads : int       kernels climbed with at once; 0 for as many as there are processors

    Notes
    -----
    The ocean drowns what a cell holds, not what one look takes: for independent looks that is p. For any other
    gains it is the total that looks at the cell can ever pay; their shares of it stay as they are.

    Over drowned ground every step is a comparison of boxes. Two boxes that hold the same ground are equal, however
    their sums were rounded, and the choice is random: NewYork108 at T = 600 then has 52.53 to 53.14 %, in the mean
    the printed 52.88. The highest hill is 255 high and gains below 2^-150 are nothing, as in the authors' single
    precision: without it the drone that waits on an island's last two cells leaves them later (HikerPaul at
    T = 900: 53.13 instead of 55.18 %).
    """

    levels: int = 3
    parts: int = 4
    kernels: int = 3
    threads: int = 0

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over cells."""
        return single_cell_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield after every climb."""
        best = Best(problem)
        for field in directions(problem):
            hills = _Hills.of(field.gains, field.budget)
            sea, rise = _Sea(hills.heights, 0.0), HEIGHT / self.parts
            value = yield from self._climbs(field, hills, sea, best, rng)
            for _ in range(self.levels):
                for other in sea.around(rise, self.parts - 1):
                    reached = yield from self._climbs(field, hills, other, best, rng)
                    if reached > value:
                        sea, value = other, reached
                rise /= self.parts

    def _climbs(self, field: Field, hills: _Hills, sea: _Sea, best: Best, rng: Generator) -> Climbs:
        """One path per kernel on the islands; returns what the best is worth on the map as it is."""
        table = hills.table(sea.islands)

        def climb(kernel: int, stream: Generator) -> Plan:
            state, searcher = random_state(stream), field.reach
            ground = Ground.fresh(table, hills.ratio, field.grid)
            ground.look(searcher.start)
            begin = searcher.start, searcher.came_from, field.budget
            return field.plan(ground.climb(searcher.arrays, *begin, kernel, state)[0], state)

        value = -np.inf
        for plan in in_parallel(climb, convolution_kernels(field.grid, self.kernels), rng, self.threads):
            yield best.take(plan)
            value = max(value, best.last)
        return value


@dataclass(frozen=True, eq=False)
class _Hills:
    """What each cell holds, and how looks share it: gain of look k = height x share of look k."""

    heights: NDArray[np.float64]  # (N,), the highest 255
    shares: NDArray[np.float64]  # (N, L)
    ratio: NDArray[np.float64]  # (N,)

    @classmethod
    def of(cls, gains: Gains, budget: int) -> _Hills:
        """Heights are totals over all looks there could be; for independent looks p, with shares g (1 - g)^k."""
        table, ratio = gains.table, gains.ratio
        tail = np.where(ratio < 1, ratio / np.where(ratio < 1, 1 - ratio, 1.0), budget)
        total = table.sum(axis=1) + table[:, -1] * tail
        alone = (1 - ratio)[:, None] * ratio[:, None] ** np.arange(table.shape[1])
        shares = np.where(total[:, None] > 0, table / np.where(total > 0, total, 1.0)[:, None], alone)
        shares = np.where(np.isclose(shares, alone, rtol=1e-9, atol=0.0), alone, shares)  # equal shares stay equal
        peak = total.max()
        return cls(total * (HEIGHT / peak if peak > 0 else 0.0), shares, ratio)

    def table(self, heights: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, L): gains over these heights."""
        scaled: NDArray[np.float64] = heights[:, None] * self.shares
        return scaled


@dataclass(frozen=True, eq=False)
class _Sea:
    """What stands out of the ocean, and how high the ocean stands."""

    islands: NDArray[np.float64]
    water: float

    def around(self, rise: float, each: int) -> list[_Sea]:
        """`each` falls and `each` rises from here, a side left out where its far end lies beyond the hills."""
        seas = []
        for step, far in ((-rise, self.water - each * rise), (rise, self.water + each * rise)):
            sea = self
            for _ in range(each if 0 <= far < HEIGHT else 0):
                sea = _Sea(np.maximum(sea.islands - step, 0.0), sea.water + step)
                seas.append(sea)
        return seas
