"""The connected-subgraph bound: a flight sees a connected piece of the map, and must be somewhere all the time.

The bound holds for any multipliers, so none of the heuristics that choose them can make it wrong.

**Derivation.** A walk c_0, ..., c_n with n <= T collects gamma(v, k) from the k-th look at v. Take mu >= 0 and any
potential lam over cells, and price the step u -> v at w(u, v) = mu - lam(v) + lam(u). The prices telescope:

    sum of w over the walk = mu n + lam(c_0) - lam(c_n) <= mu T + lam(start) - lam(c_n),                         (1)

so value <= mu T + lam(start) - min over end cells of lam + sum over looks of (gain - price of the step there). The
start is looked at without a step. The steps that first enter each visited cell form an arborescence rooted at the
start; any later entry of v costs at least w(v) = min of w(u, v) over its neighbours u, and over u = v for a copter,
whose hover costs mu. With R(v) = sum over k >= 1 of (gamma(v, k) - w(v))+, at most T terms,

    value <= mu T + lam(start) - min lam + gamma(start, 0) + R(start)
             + max over arborescences A of sum over arcs (u, v) in A of [gamma(v, 0) + R(v) - w(u, v)].          (2)

lam = 0 is the plain bound; lam makes branching cost and dead ends pay. The last maximum is relaxed once more. Let S
be a set of cells without the start and t in S: if A visits t, then an arc of A enters S, so adding
y (arcs of A into S - [A visits t]) for y >= 0 takes nothing away. What remains splits into cells: with Y(v) the sum of
the y charged to v, and w'(u, v) = w(u, v) - sum of the y of the sets that the arc enters,

    max over A <= sum over v of ( gamma(v, 0) + R(v) - Y(v) - min over u of w'(u, v) )+.                         (3)

Each bracket before ( )+ is moved onto the arcs where it is negative, and each cheapest arc into its prize; then all
reduced costs c and prizes rho are >= 0, the bound is rest + sum of rho, and Wong's dual ascent may raise more sets.
An arborescence that visits v loses at least the distance from the start to v over reduced costs, so a cell whose
distance exceeds bound - lower lies on no plan worth more than `lower`, and max(lower, bound without the cell) holds.

Several searchers: one root for each start, mu times the sum of their steps, their potentials added. An end cell takes
its own lam in place of the minimum. A fixed wing may do less than a copter, so both bounds hold for it; hovering is
then left out of w(v). mu >= 0 covers flights that stop early.

**Multipliers.** mu alone first, each dual ascent afresh. Then lam, mu and y descend together: (3) is convex in all of
them, its maxima are smoothed (tau) for Adam; every few dozen iterations the dual ascent goes on from where they stand,
which finds sets that are missing, and minimum cuts of the mean flow find sets that it enters too little.

References
----------
.. [Wong1984] R. T. Wong, "A dual ascent approach for Steiner tree problems on a directed graph", Math. Prog. 28, 1984.
.. [Held1971] M. Held and R. M. Karp, "The traveling-salesman problem and minimum spanning trees: part II", 1971.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.bounds import _kernels
from sooner.bounds.bound import Bound, Known, known_value
from sooner.errors import UnsupportedProblemError
from sooner.problem import CellMoves, SearchProblem

__all__ = ["ConnectedSubgraph"]

Floats = NDArray[np.float64]

GUARD = 1e-9  # rounding of sums over a flight stays orders below this share of a mean look
SCANS = 15_000_000  # of cells and arcs in one tick, about a tenth of a second
ASSUMES = "each look covers one cell, and gains do not depend on when a cell is looked at"


@dataclass(frozen=True)
class ConnectedSubgraph:
    """Bound every plan over cells by connected sets of cells, ever tighter.

    Parameters
    ----------
    balance : bool            use the potential lam; without it the bound is the plain one
    patience : float          how far a set may outgrow the next in the dual ascent's queue
    rate : float              first step of the joint descent, in mean looks; tau is five times the step
    decay : float             of the step, each round
    least_rate : float        of the step
    iterations : int          of the descent between two dual ascents
    separate_every : int      rounds between two searches for violated cuts
    smallest_cut : float      price below which a raise is not kept as a cut, in mean looks
    """

    balance: bool = True
    patience: float = 3.0
    rate: float = 0.003
    decay: float = 0.985
    least_rate: float = 1e-4
    iterations: int = 40
    separate_every: int = 3
    smallest_cut: float = 0.005

    def bounds(self, problem: SearchProblem, known: Known = -inf) -> Iterator[Bound]:
        """Yield bounds that never rise, several a second; `known` is the value of the best plan so far.

        Raises
        ------
        UnsupportedProblemError    where the person moves, or moves are not over cells
        """
        network = _Network.of(problem)
        unit, proof = network.unit, "connected subgraph"
        if unit <= 0.0:
            yield Bound(0.0, proof, ASSUMES)
            return
        dual = _Dual(network, self, lambda: known_value(known) / unit)
        for _ in dual.plain():
            yield Bound(dual.proved * unit, proof, ASSUMES)
        if self.balance:
            for _ in dual.balanced():
                yield Bound(dual.proved * unit, proof + " with balance", ASSUMES)


@dataclass(frozen=True, eq=False)
class _Network:
    """The cells that some searcher can visit in time, gains in units of the mean teleport look."""

    neighbours: NDArray[np.int32]  # (N, D)
    reverse: NDArray[np.int8]  # (N, D)
    table: Floats  # (N, L)
    ratio: Floats  # (N,)
    free: NDArray[np.int64]  # (N,) searchers that start here
    ends: NDArray[np.int64]  # (N,) searchers that must end here
    n_open: int  # searchers that may end anywhere
    steps: int  # of all searchers
    hover: bool
    price: float  # the smallest look that teleport takes
    unit: float

    @classmethod
    def of(cls, problem: SearchProblem) -> _Network:
        moves = [searcher.moves for searcher in problem.searchers]
        if problem.drift is not None or not all(isinstance(each, CellMoves) for each in moves):
            raise UnsupportedProblemError("the connected-subgraph bound needs moves over cells and a person who stays")
        grid, curve = problem.grid, problem.teleport.curve
        free, ends = np.zeros(grid.n_cells, np.int64), np.zeros(grid.n_cells, np.int64)
        within = np.zeros(grid.n_cells, bool)
        for searcher in problem.searchers:
            there = grid.distances_from(grid.index(searcher.start))
            free[grid.index(searcher.start)] += 1
            back = np.zeros_like(there)
            if searcher.end is not None:
                back = grid.distances_from(grid.index(searcher.end))
                ends[grid.index(searcher.end)] += 1
            within |= (there >= 0) & (back >= 0) & (there + back <= searcher.steps)
        table = problem.gains.table[within]
        unit = float(curve[-1]) / len(curve) if len(curve) else 0.0
        neighbours = _renumbered(grid.neighbours, within)
        return cls(
            neighbours=neighbours,
            reverse=_kernels.reverse_slots(neighbours),
            table=table / unit if unit > 0 else table,
            ratio=problem.gains.ratio[within],
            free=free[within],
            ends=ends[within],
            n_open=sum(searcher.end is None for searcher in problem.searchers),
            steps=sum(searcher.steps for searcher in problem.searchers),
            hover=any(isinstance(each, CellMoves) and each.kind == "copter" for each in moves),
            price=float(curve[-1] - (curve[-2] if len(curve) > 1 else 0.0)) / unit if unit > 0 else 0.0,
            unit=unit,
        )

    def without(self, kept: NDArray[np.bool_]) -> _Network:
        """The same with some cells taken off the map."""
        neighbours = _renumbered(self.neighbours, kept)
        rows = {name: getattr(self, name)[kept] for name in ("table", "ratio", "free", "ends")}
        return replace(self, neighbours=neighbours, reverse=_kernels.reverse_slots(neighbours), **rows)

    @property
    def n_cells(self) -> int:
        return len(self.neighbours)


@dataclass(eq=False)
class _Cuts:
    """Sets of cells by the arcs that enter them, each with its price."""

    pointers: NDArray[np.int64]
    arcs: NDArray[np.int32]
    cells: NDArray[np.int32]
    prices: Floats
    moments: Floats  # (2, cuts) of the descent
    count: int = 0

    @classmethod
    def room_for(cls, network: _Network) -> _Cuts:
        most = 20_000 + 2 * network.n_cells
        arcs = min(4_000_000 + 10 * network.n_cells, 20_000_000)
        return cls(
            np.zeros(most + 1, np.int64), np.zeros(arcs, np.int32), np.zeros(most, np.int32), np.zeros(most),
            np.zeros((2, most)),
        )  # fmt: skip

    def keep(self, kept: NDArray[np.bool_]) -> None:
        """Drop the cuts that are not kept."""
        self._select(kept, np.repeat(kept, np.diff(self.pointers[: self.count + 1])))

    def renumber(self, old: _Network, kept: NDArray[np.bool_]) -> None:
        """Follow the network without some cells: arcs of those cells go, and cuts charged to them."""
        degree = old.neighbours.shape[1]
        number = np.cumsum(kept) - 1
        arcs = self.arcs[: self.pointers[self.count]]
        into, slot = np.divmod(arcs, degree)
        alive = kept[into] & kept[old.neighbours[into, slot]]
        charged = kept[self.cells[: self.count]]
        self.arcs[: len(arcs)] = number[into] * degree + slot
        self.cells[: self.count] = number[self.cells[: self.count]]
        self._select(charged, alive & np.repeat(charged, np.diff(self.pointers[: self.count + 1])))

    def _select(self, cuts: NDArray[np.bool_], arcs: NDArray[np.bool_]) -> None:
        lengths = np.add.reduceat(np.append(arcs, False).astype(np.int64), self.pointers[: self.count])
        lengths[np.diff(self.pointers[: self.count + 1]) == 0] = 0
        left, count = self.arcs[: len(arcs)][arcs], int(cuts.sum())
        self.arcs[: len(left)] = left
        self.pointers[1 : count + 1] = np.cumsum(lengths[cuts])
        self.cells[:count] = self.cells[: self.count][cuts]
        self.prices[:count] = self.prices[: self.count][cuts]
        self.moments[:, :count] = self.moments[:, : self.count][:, cuts]
        self.count = count


@dataclass(eq=False)
class _Dual:
    """The multipliers and what they have proved; each generator's yield is one tick of work."""

    network: _Network
    settings: ConnectedSubgraph
    known: Any  # () -> float, best plan so far in units
    proved: float = inf
    mu: float = 0.0
    floor: float = -inf  # plans worth no more than this may have been taken off the map
    at: float = inf  # bound where the multipliers stand
    lam: Floats = field(init=False)
    cuts: _Cuts = field(init=False)

    def __post_init__(self) -> None:
        self.lam = np.zeros(self.network.n_cells)
        self.cuts = _Cuts.room_for(self.network)
        self.mu = self.network.price
        self._allocate()

    def _allocate(self) -> None:
        n, degree = self.network.neighbours.shape
        self.cost, self.prize = np.empty((n, degree)), np.empty(n)
        self.state = np.zeros(3, np.int64)
        reached, key, item, mark = np.empty(n, np.bool_), np.empty(n), np.empty(n, np.int32), np.zeros(n, np.int32)
        self.queue: tuple[Any, ...] = (reached, key, item, mark, np.empty(n, np.int32))
        self.arcs = np.empty(n * degree, np.int64)

    # --- one evaluation -------------------------------------------------------------------------------------------
    def evaluate(self, mu: float, lam: Floats, keep_cuts: bool = False) -> Generator[None, None, float]:
        """Bound at these multipliers (and the cuts' prices), in ticks."""
        net, cuts = self.network, self.cuts
        pool = (cuts.pointers, cuts.arcs, cuts.cells, cuts.prices)
        rest = _kernels.price_arcs(
            net.neighbours, net.table, net.ratio, net.free, net.steps, net.hover, mu, lam, *pool, cuts.count,
            self.cost, self.prize,
        )  # fmt: skip
        rest -= float(net.ends @ lam) + (net.n_open * float(lam.min()) if net.n_open else 0.0)
        smallest = self.settings.smallest_cut if keep_cuts else inf
        start: Any = _kernels.start_ascent
        ascend: Any = _kernels.ascend
        start(net.neighbours, net.reverse, net.free, self.cost, self.prize, self.state, *self.queue)
        while True:
            before = cuts.count
            cuts.count = ascend(
                net.neighbours, net.reverse, self.cost, self.prize, self.settings.patience, SCANS, self.state,
                *self.queue, self.arcs, *pool, cuts.count, smallest,
            )  # fmt: skip
            cuts.moments[:, before : cuts.count] = 0.0
            self._prove(rest + float(self.prize.sum()), lam)
            if self.state[0] == 0:
                break
            yield
        self.at = rest + float(self.prize.sum())
        return self.at

    def _prove(self, bound: float, lam: Floats) -> None:
        guard = GUARD * (self.network.steps + 1) * (1.0 + float(np.abs(lam).max()))
        self.proved = min(self.proved, max(bound, self.floor) + guard)

    # --- mu alone: the plain bound --------------------------------------------------------------------------------
    def plain(self) -> Iterator[None]:
        """Lower or raise mu while that helps."""
        best = yield from self.evaluate(self.mu, self.lam)
        yield
        for factor in (0.93, 1.07, 0.98, 1.02):
            while True:
                bound = yield from self.evaluate(self.mu * factor, self.lam)
                if bound >= best:
                    break
                best, self.mu = bound, self.mu * factor
                yield
        self.at = best
        yield

    # --- mu and lam, then cuts as well -----------------------------------------------------------------------------
    def balanced(self) -> Iterator[None]:
        """Descend in lam, mu and the cuts' prices together, until the plan is proved or nothing moves."""
        own, rate, idle, rounds = self.settings, self.settings.rate, 0, 0
        price, moments = np.array([self.mu, 0.0, 0.0, 0.0]), np.zeros((2, self.network.n_cells))
        flow, visited = np.zeros(self.network.neighbours.shape), np.zeros(self.network.n_cells)
        cuts = self.cuts
        while idle < 200 and not self.finished:
            before, rate, rounds = self.proved, max(own.least_rate, rate * own.decay), rounds + 1
            yield from self.evaluate(float(price[0]), self.lam, keep_cuts=True)
            if rounds % 5 == 1:
                kept = self._worth_keeping()
                if kept is not None:
                    moments = np.ascontiguousarray(moments[:, kept])
                    flow, visited = self._on_rest(flow, kept), visited[kept]
                    self._take_off(kept)
            yield
            if rounds % own.separate_every == 0:
                self._separate(flow, visited, rounds)
                yield
            net, left = self.network, own.iterations
            size = net.neighbours.size * 10 + int(cuts.pointers[cuts.count])
            while left > 0:
                share = min(left, max(1, 25_000_000 // size))
                left -= share
                bound = _kernels.descend(
                    net.neighbours, net.table, net.ratio, net.free, net.ends, net.n_open, net.steps, net.hover,
                    price, self.lam, moments, cuts.pointers, cuts.arcs, cuts.cells, cuts.prices, cuts.moments,
                    cuts.count, 5.0 * rate, rate, share, flow, visited,
                )  # fmt: skip
                self._prove(bound, self.lam)
                yield
            alive = cuts.prices[: cuts.count] > 1e-6
            if cuts.count and alive.mean() < 0.8:
                cuts.keep(alive)
            idle = 0 if self.proved < before * (1.0 - 1e-7) else idle + 1

    def _separate(self, flow: Floats, visited: Floats, seed: int) -> None:
        """Add cuts that the mean flow of the descent violates."""
        net, cuts = self.network, self.cuts
        order = np.flatnonzero(visited > 0.05).astype(np.int64)
        np.random.default_rng(seed).shuffle(order)
        before = cuts.count
        cuts.count, _ = _kernels.separate(
            net.neighbours, net.reverse, net.free, flow, visited, order, 0.03, 3, SCANS, 400,
            cuts.pointers, cuts.arcs, cuts.cells, cuts.prices, cuts.count,
        )  # fmt: skip
        cuts.moments[:, before : cuts.count] = 0.0

    # --- what no better plan can visit -----------------------------------------------------------------------------
    @property
    def finished(self) -> bool:
        """Whether no plan is worth more than one that is known."""
        return bool(self.proved <= max(self.known(), self.floor) * (1.0 + 1e-9))

    def _worth_keeping(self) -> NDArray[np.bool_] | None:
        """Cells that a better plan than the known one may visit, from the last evaluation; None if nearly all."""
        net, lower = self.network, max(self.known(), self.floor)
        if not np.isfinite(lower) or self.at <= lower:
            return None
        gap = self.at - lower
        limit = gap + 1e-7 * (net.steps + 1) * (1.0 + float(np.abs(self.lam).max()))
        kept: NDArray[np.bool_] = np.isfinite(
            _kernels.reduced_distances(net.neighbours, net.reverse, net.free, self.cost, limit)
        )
        kept |= net.ends > 0
        if kept.mean() > 0.97:
            return None
        self.floor = lower
        return kept

    @staticmethod
    def _on_rest(rows: Floats, kept: NDArray[np.bool_]) -> Floats:
        return np.ascontiguousarray(rows[kept])

    def _take_off(self, kept: NDArray[np.bool_]) -> None:
        self.cuts.renumber(self.network, kept)
        self.network, self.lam = self.network.without(kept), self.lam[kept]
        self._allocate()


def _renumbered(neighbours: NDArray[np.int32], kept: NDArray[np.bool_]) -> NDArray[np.int32]:
    """(kept, D) int32: neighbours among the cells that are kept, by their new numbers."""
    number = np.where(kept, np.cumsum(kept) - 1, -1).astype(np.int32)
    old = neighbours[kept]
    return np.ascontiguousarray(np.where(old >= 0, number[old], -1), np.int32)
