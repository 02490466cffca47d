"""Simulated annealing of whole walks: the default planner, good within a second and better with every further one.

The walk is annealed as it will be flown, by moves that rewrite a few steps at a time (Metropolis et al. 1953;
Kirkpatrick, Gelatt and Vecchi 1983). Small moves cannot carry a walk from one hill to another, so which hills
to visit is settled first, by many quick answers to a coarse question: pieces of good ground as the customers of an
orienteering problem (Golden, Levy and Vohra 1987). All starts are annealed a little, the better half goes on, and so
forth until one walk is left for each thread (successive halving; Jamieson and Talwalkar 2016).

S. Kirkpatrick, C. D. Gelatt, M. P. Vecchi, "Optimization by simulated annealing", Science 220 (1983), 671-680.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.planners import _anneal_kernels as kernels
from sooner.planners.greedy import Greedy
from sooner.planners.planner import Planner, Ticks, single_cell_searcher
from sooner.planners.rounds import FIRST_ROUND, Rounds
from sooner.problem import Incumbent, Plan, Reach, SearchProblem, evaluate

__all__ = ["Anneal"]

Walk = NDArray[np.int32]

LOOKS = 8  # gains are tabulated for this many looks at a cell; later ones are worked out
POLISH = 0.001  # a temperature at which nothing but improvement is accepted
FILL = -1e3  # price of a step where the walk must have all the steps of the budget
FILL_MOVES = 30  # for each step, to fill the first walk up
FOREVER = 2**31 - 1  # in `Reach`: a fixed wing that is never stuck
SHORT_TICK = 200  # moves of a tick on the smallest of problems; more with the square of the budget
ROUTE_MOVES = 200  # for each piece, of one answer to the coarse question; of at most a thousand pieces
SPARE_NODES = 8  # rows beyond the budget, in use in the middle of a move
MEMORY_CELLS, TICK_CELLS = 12_000_000, 400_000  # all starts, and those of one tick, times cells of the map


@dataclass(frozen=True)
class Anneal:
    """Anneal many walks, keep the better ones, end with one for each thread.

    Gains are scaled so that those collected by teleporting average one; temperatures are in that unit.

    Parameters
    ----------
    starts : int               walks at first (fewer on maps so large that they would not fit in memory)
    halvings : ((share, n))    from this share of the run on, only the best n walks go on
    hot, cold : float          temperature at the beginning and the end
    polish : float             share of the run, at its end, in which only improvements are accepted
    prices : (float, float)    of a step while some are left, at first and at last, in gains of the worst teleport look
    greed : float              added to a cell's gain where a move draws cells: small trusts the gains
    mix : (5,) floats          shares of the moves: rewrite a window, a pair of windows, a long shortcut, the tail;
                               reconnect (2-opt)
    moves : int                moves of each thread between two yields, at most
    patience : int             moves for each step of the flight after which a run starts again from new walks
    threads : int              walks annealed at the same time; a plan depends on their number, never on their speed
    seeds : planners           whose first plans are starts as well
    """

    starts: int = 40
    halvings: tuple[tuple[float, int], ...] = ((0.15, 14), (0.3, 5), (0.5, 2), (0.7, 1))
    hot: float = 0.3
    cold: float = 0.035
    polish: float = 0.03
    prices: tuple[float, float] = (0.7, 0.8)
    greed: float = 0.05
    mix: tuple[float, float, float, float, float] = (0.66, 0.22, 0.01, 0.015, 0.095)
    moves: int = 80_000
    patience: int = 40_000
    threads: int = 2
    seeds: tuple[Planner, ...] = field(default=())

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over cells, of any topology, gains and kind of aircraft."""
        return single_cell_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield a first plan at once, then anneal for as long as somebody asks."""
        ground = _Ground(problem)
        best = _Best(problem)
        for walk in self._given(ground, rng):
            best.offer(walk)
        share = yield best.incumbent
        if problem.teleport.value == 0.0:  # nothing can be found from here, so every plan is best
            return
        rounds = Rounds(self._longest_round(ground))
        with ThreadPoolExecutor(self.threads) as pool:
            while True:
                walks: list[_Walk] = []
                rounds = rounds.begun(share)
                while (now := rounds.now(share)) < 1.0:
                    self._start(walks, ground, best, now, rng, pool)
                    self._halve(walks, best, now)
                    self._anneal(walks, now, pool)
                    best.offer(max(walks, key=lambda walk: walk.rank).flown())
                    share = yield best.incumbent
                    rounds.tick += 1

    def _longest_round(self, ground: _Ground) -> int:
        """Ticks after which longer cooling pays less than starting again."""
        return max(FIRST_ROUND, self.patience * ground.limit // (self._moves(ground) * self.threads))

    def _moves(self, ground: _Ground) -> int:
        """Moves of each thread in one tick; fewer for short flights."""
        return min(self.moves, SHORT_TICK + ground.limit**2)

    def _given(self, ground: _Ground, rng: Generator) -> Iterator[Walk | None]:
        """First plans: of other planners, and one from the coarse question; legal ones, whatever the aircraft."""
        for planner in self.seeds:
            yield _first_plan(planner, ground.problem, rng)
        walk = _Walk(ground, _coarse_walk(ground, rng), rng)
        if ground.strict:
            walk.anneal(self, POLISH, FILL_MOVES * ground.limit, price=0.0)
        flown = walk.flown()
        yield flown
        if flown is None:  # dead ends: one that looks ahead, or says that there is no way at all
            yield _first_plan(Greedy(), ground.problem, rng)

    def _start(
        self, walks: list[_Walk], ground: _Ground, best: _Best, now: float, rng: Generator, pool: ThreadPoolExecutor
    ) -> None:
        """Add starts while there is time for them: the best plan so far, then coarse walks."""
        if walks and now >= self.halvings[0][0]:
            return
        if not walks:
            walks.append(_Walk(ground, best.walk, rng))
        cells = ground.problem.grid.n_cells
        missing = min(self.starts, max(MEMORY_CELLS // cells, 4)) - len(walks)
        batch = min(missing, max(self.threads, TICK_CELLS // cells))
        streams = rng.spawn(max(batch, 0))
        coarse = pool.map(lambda stream: _coarse_walk(ground, stream), streams)
        walks.extend(_Walk(ground, walk, rng) for walk in coarse)

    def _halve(self, walks: list[_Walk], best: _Best, now: float) -> None:
        """Let the better walks go on, and see what the best of them is worth polished."""
        keep = min((max(n, self.threads) for share, n in self.halvings if now >= share), default=len(walks))
        if keep < len(walks):
            walks.sort(key=lambda walk: walk.rank, reverse=True)
            del walks[keep:]
            copy = walks[0].copy()
            copy.anneal(self, POLISH, self.moves // 4, price=0.0)
            best.offer(copy.flown())

    def _anneal(self, walks: list[_Walk], now: float, pool: ThreadPoolExecutor) -> None:
        """One tick: every thread makes the same number of moves, shared among its walks."""
        polish = now >= 1.0 - self.polish
        temperature = POLISH if polish else self.hot * (self.cold / self.hot) ** now
        price = 0.0 if polish else self.prices[0] + (self.prices[1] - self.prices[0]) * now
        moves = self._moves(walks[0].ground)

        def run(own: list[_Walk]) -> None:
            for walk in own:
                walk.anneal(self, temperature, moves // len(own), price)

        shares = [walks[k :: self.threads] for k in range(min(self.threads, len(walks)))]
        list(pool.map(run, shares))


def _first_plan(planner: Planner, problem: SearchProblem, rng: Generator) -> Walk:
    return next(iter(planner.plans(problem, rng))).plan.actions[0].astype(np.int32)


class _Best:
    """The best plan so far, by the judge's word."""

    def __init__(self, problem: SearchProblem) -> None:
        self.problem = problem
        self.incumbent = Incumbent(Plan.of(), -np.inf)

    def offer(self, walk: Walk | None) -> None:
        if walk is None:
            return
        plan = Plan.of(walk)
        value = evaluate(self.problem, plan).value
        if value > self.incumbent.value:
            self.incumbent = Incumbent(plan, value)

    @property
    def walk(self) -> Walk:
        return self.incumbent.plan.actions[0].astype(np.int32)


class _Ground:
    """The problem as the kernels want it.

    gains : (N, K) float       of the first K looks, in mean gains of the teleport reference
    where : (N, 2) int32       coordinates in which distances without obstacles are simple
    unit : float               one of those gains in the problem's own
    worst : float              the last and least gain that teleporting collects: what a step is worth
    strict : bool              a fixed wing could be stuck, or late at its end: keep every walk at its full length
    """

    def __init__(self, problem: SearchProblem) -> None:
        grid, curve = problem.grid, problem.teleport.curve
        reach = Reach(grid, problem.searcher)
        self.problem = problem
        self.neighbours, self.where = grid.neighbours, grid.step_coordinates
        self.start, self.end, self.previous = reach.start, reach.end, reach.came_from
        self.limit = problem.searcher.steps + 1
        self.wing, self.pinned = reach.fixed_wing, reach.end >= 0
        self.strict = self.wing and (self.pinned or bool((reach.arrays[-1] < FOREVER).any()))
        self.to_end = grid.distances_from(self.end) if self.pinned else np.zeros(grid.n_cells, np.int32)
        scale = len(curve) / curve[-1] if len(curve) and curve[-1] > 0 else 1.0
        looks = max(LOOKS, problem.gains.table.shape[1])
        self.unit = 1.0 / scale
        self.gains = scale * problem.gains.of(np.arange(grid.n_cells)[:, None], np.arange(looks))
        self.ratio = problem.gains.ratio
        self.worst = scale * float(np.diff(curve[-2:], prepend=0.0)[-1]) if len(curve) else 0.0
        there = grid.distances_from(self.start)
        self.near = (there >= 0) & (self.to_end >= 0) & (there + self.to_end < self.limit)


class _Walk:
    """One walk being annealed, as the linked list of the kernels; `value` is in the units of `_Ground.gains`."""

    def __init__(self, ground: _Ground, walk: Walk, rng: Generator) -> None:
        cells, slots = ground.neighbours.shape
        self.ground = ground
        self.nodes = np.zeros((ground.limit + SPARE_NODES, 3), np.int32)
        self.looks = np.zeros((cells, 2), np.int32)
        self.pays = np.zeros(cells)
        self.state = np.array([*rng.integers(1, 2**32, 2), 0, 0], np.int64)
        self.scratch = np.zeros(slots + 1), np.zeros(256, np.int32)
        self.value = kernels.load(walk, self.nodes, self.looks, self.pays, self.state, ground.gains, ground.ratio)

    @property
    def rank(self) -> tuple[bool, float]:
        """The better walk has the larger one; where all steps must be flown, those that do come first."""
        return not self.ground.strict or self.state[kernels.SIZE] == self.ground.limit, self.value

    def copy(self) -> _Walk:
        twin = object.__new__(_Walk)
        twin.ground, twin.value = self.ground, self.value
        twin.nodes, twin.looks, twin.pays = self.nodes.copy(), self.looks.copy(), self.pays.copy()
        twin.state, twin.scratch = self.state.copy(), self.scratch  # the twin never runs beside its original
        return twin

    def anneal(self, planner: Anneal, temperature: float, moves: int, price: float) -> None:
        """`price` is in gains of the worst teleport look; a strict walk is paid for steps instead."""
        g = self.ground
        self.value += kernels.anneal(
            self.nodes, self.looks, self.pays, self.state, g.gains, g.ratio, g.neighbours, g.where, g.limit, g.pinned,
            g.wing, g.previous, moves, temperature, FILL if g.strict else price * g.worst, planner.greed,
            np.cumsum(planner.mix), *self.scratch,
        )  # fmt: skip

    def flown(self) -> Walk | None:
        """The walk with all the steps of the budget, or None where it cannot be flown so."""
        g = self.ground
        walk = np.zeros(g.limit, np.int32)
        length = kernels.unload(
            self.nodes, self.looks, self.pays, g.gains, g.ratio, g.neighbours, g.pinned, g.wing, g.previous, walk
        )
        finished = length == g.limit and (not g.pinned or walk[-1] == g.end)
        return walk if finished else None


def _coarse_walk(ground: _Ground, rng: Generator) -> Walk:
    """A start: which pieces of good ground to visit and in what order, joined by the best of the shortest ways.

    A piece is what deserves a look (gain above a drawn threshold) in a block of 4 to 10 cells square. A visit costs
    the way to its middle and a drawn time per cell; what time is left over is worth half the worst teleport look.
    """
    anchors, prize, size = _pieces(ground, rng)
    order, scratch = np.zeros((2, len(anchors)), np.int32)
    n = kernels.route(
        ground.where, ground.neighbours.shape[1], anchors, prize, size * rng.uniform(0.45, 0.8), ground.start,
        ground.end, float(ground.limit - 1), 0.5 * ground.worst, rng.integers(1, 2**32, 2),
        ROUTE_MOVES * min(len(anchors), 1000), 10.0, 0.2, np.zeros(len(anchors), np.int32), scratch, order,
    )  # fmt: skip
    cells = len(ground.gains)
    walk = np.zeros(ground.limit, np.int32)
    length = kernels.join(
        ground.neighbours, ground.where, ground.gains, anchors[order[:n]], ground.start, ground.end, ground.to_end,
        ground.wing, ground.previous, np.zeros(cells, np.int32), np.full(cells, -1, np.int32), np.zeros(cells),
        np.zeros(cells, np.int32), walk,
    )  # fmt: skip
    return walk[:length].copy()


def _pieces(ground: _Ground, rng: Generator) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
    """Pieces of good ground: their middle cell, the gain of their first looks, their number of cells."""
    side = int(rng.integers(4, 11))
    shift = rng.integers(0, side, 2)
    first = ground.gains[:, 0]
    good = np.flatnonzero(ground.near & (first >= rng.uniform(0.75, 1.1) * ground.worst) & (first > 0))
    place = ground.where[good] - ground.where.min(axis=0)
    block = (place + shift) // side
    _, piece = np.unique(block[:, 0] * (block[:, 1].max(initial=0) + 1) + block[:, 1], return_inverse=True)
    size = np.bincount(piece).astype(np.float64)
    middle = np.stack([np.bincount(piece, place[:, axis]) / np.maximum(size, 1) for axis in (0, 1)], axis=1)
    off = ((place - middle[piece]) ** 2).sum(axis=1) if len(good) else np.zeros(0)
    nearest = np.lexsort((off, piece))
    firsts = np.cumsum(np.append(0, size[:-1])).astype(np.int64) if len(good) else np.zeros(0, np.int64)
    return good[nearest[firsts]].astype(np.int32), np.bincount(piece, first[good]).astype(np.float64), size
