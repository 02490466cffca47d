"""The linear program over regions: how often each action is flown, in fractions; a bound on every plan.

Variables are n_a, how often action a is flown, and for every atom k the share z_kj of its j-th look that is taken:

    max  sum of gain(k, j) z_kj    with  sum over j of z_kj <= sum of n_a over the actions that cover k,
                                         0 <= z_kj <= 1,    sum of n_a w_a <= T.

Gains never rise, so the looks of an atom are taken in their order, and whole numbers of actions are worth what they
pay. Edges pay too, and a fraction of a flight there and back keeps every walk closed, so that nothing more is to be
said of walks than that they are connected: cuts, which are added where they are violated (see `region_network`).

**Few levels.** An atom has as many levels z_kj as looks pay, but only those near its price matter. A window of levels
is kept, and the atom's value is continued beyond it along the gains of its first and its last level: no less than the
true one, since gains fall. Windows that turn out too narrow are widened, and the program is solved again.

**Proof.** Only the prices of looks and cuts are taken from the solver. The bound itself is worked out from them,
inequality (2) of `region_network`, over all levels of all atoms: no tolerance of the solver enters it. It starts with
the prices at which actions picked by rate stop [Kuhlman2017, eq. (4)].
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heapify, heappop, heapreplace
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import coo_array, csr_array

from sooner.bounds.bound import Bound, Known, known_value
from sooner.bounds.region_network import Cut, Prices, RegionNetwork
from sooner.problem import SearchProblem

__all__ = ["Levels", "RegionLP", "picked_by_rate"]

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

PROOF = "linear program over regions"
ASSUMES = "flights over these regions; looks of an action are as many, and pay as much, whenever it is flown"


@dataclass(frozen=True)
class RegionLP:
    """Bound every plan over regions, in milliseconds where there are tens of them.

    Parameters
    ----------
    width : int         levels kept at first on each side of what actions picked by rate look at
    rounds : int        of widening and cutting, at most; three that gain less than a millionth are the last
    """

    width: int = 1
    rounds: int = 100

    def bounds(self, problem: SearchProblem, known: Known = -inf) -> Iterator[Bound]:
        """Yield bounds that never rise, one a round; for several searchers, of all together.

        Raises
        ------
        UnsupportedProblemError    where moves are not over regions, or the person moves
        """
        for value, _ in self.solutions(RegionNetwork.of(problem)):
            yield Bound(value, PROOF, ASSUMES)
            if value <= known_value(known):
                return

    def solutions(self, network: RegionNetwork) -> Iterator[tuple[float, Floats]]:
        """The bound so far, and how often the last program flies each action, (A,)."""
        counts = picked_by_rate(network).astype(np.float64)
        looks = network.looks(counts)
        best = min(network.bound(prices, []) for prices in _around(network, looks))
        yield best, counts
        levels, cuts, idle = Levels.around(network, looks, self.width), list[Cut](), 0
        for _ in range(self.rounds):
            found = _Program(network, levels, cuts).solved()
            if found is None:  # the solver gave up; what is proved stays proved
                return
            now = network.bound(found.prices, cuts)
            idle = 0 if now < best * (1.0 - 1e-6) else idle + 1
            best = min(best, now)
            yield best, found.counts
            wider = levels.widened(network.looks(found.counts))
            more = network.violated(found.counts, found.ending, found.visited)
            if idle == 3 or (wider is None and not more):
                return
            levels, cuts = wider or levels, cuts + more


def picked_by_rate(network: RegionNetwork) -> Whole:
    """(A,) int: how often each action is picked by rate, from anywhere, while it fits [Kuhlman2017, eq. (4)].

    Rates only fall, so an action whose rate is still the highest once it is worked out anew is the best.
    """
    ground, counts = network.ground, np.zeros(network.ground.n_actions, np.int64)
    looks, last = np.zeros(len(ground.gains), np.int64), ground.gains.shape[1] - 1
    covered = [slice(a, b) for a, b in zip(ground.starts[:-1], ground.starts[1:], strict=True)]

    def rate(action: int) -> float:
        atoms = ground.atoms[covered[action]]
        next_looks = np.minimum(looks[atoms] + ground.before[covered[action]], last)
        return float(ground.gains[atoms, next_looks].sum() / ground.seconds[action])

    queue = [(-rate(action), action) for action in np.flatnonzero(network.most).tolist()]
    heapify(queue)
    left_s, full = network.limits_s.copy(), np.zeros(len(network.limits_s), bool)
    while queue and queue[0][0] < 0.0 and not full.all():
        was, action = queue[0]
        now = -rate(action)
        if now > was:
            heapreplace(queue, (now, action))
            continue
        kind = network.kinds[action]
        full[kind] |= ground.seconds[action] > left_s[kind]
        if full[kind]:
            heappop(queue)
            continue
        left_s[kind] -= ground.seconds[action]
        counts[action] += 1
        np.add.at(looks, ground.atoms[covered[action]], 1)
        heapreplace(queue, (-rate(action), action))
    return counts


def _around(network: RegionNetwork, looks: Floats) -> Iterator[Prices]:
    """Prices between what the last look at each atom paid and what the next would."""
    gains, atoms = network.ground.gains, np.arange(len(looks))
    last = gains.shape[1] - 1
    after = gains[atoms, np.minimum(looks.astype(np.int64), last)]
    before = gains[atoms, np.clip(looks.astype(np.int64) - 1, 0, last)]
    for share in np.linspace(0.0, 1.0, 9):
        yield Prices(share * before + (1.0 - share) * after, np.zeros(0), np.zeros(network.ground.n_regions))


@dataclass(frozen=True, eq=False)
class Levels:
    """A window of levels lo <= j < hi of each atom; as columns, atom by atom.

    A column's share z lies between `least` and `most`. That of the first level may go down to -lo, that of the last up
    to all looks beyond it that pay: the value is continued along both ends.

    Parameters
    ----------
    gains : (K, L + 1) float
    lo, hi : (K,) int
    """

    gains: Floats
    lo: Whole
    hi: Whole

    @staticmethod
    def around(network: RegionNetwork, looks: Floats, width: int) -> Levels:
        """Windows of `width` on each side of so many looks."""
        gains = network.ground.gains
        deepest = gains.shape[1] - 1
        lo = np.clip(np.floor(looks).astype(np.int64) - width, 0, deepest - 1)
        return Levels(gains, lo, np.clip(np.ceil(looks).astype(np.int64) + width, lo + 1, deepest))

    def widened(self, looks: Floats) -> Levels | None:
        """Windows that hold so many looks, with a level more; None where they all do."""
        deepest = self.gains.shape[1] - 1
        above = (looks > self.hi + 1e-6) & (self.hi < deepest)
        below = (looks < self.lo - 1e-6) & (self.lo > 0)
        if not (above | below).any():
            return None
        hi = np.where(above, np.minimum(np.ceil(looks).astype(np.int64) + 1, deepest), self.hi)
        return Levels(self.gains, np.where(below, np.maximum(np.floor(looks).astype(np.int64) - 1, 0), self.lo), hi)

    def whole(self, atoms: NDArray[np.bool_]) -> Levels:
        """The same with the windows of these atoms from the first look on."""
        return Levels(self.gains, np.where(atoms, 0, self.lo), self.hi)

    @property
    def atoms(self) -> Whole:
        """(Z,) int: atom of each column."""
        return np.repeat(np.arange(len(self.lo)), self.hi - self.lo)

    @property
    def ranks(self) -> Whole:
        """(Z,) int: level of each column."""
        begun = np.cumsum(self.hi - self.lo) - (self.hi - self.lo)
        return np.asarray(np.arange(len(self.atoms)) - begun[self.atoms] + self.lo[self.atoms])

    @property
    def paid(self) -> Floats:
        """(Z,) float: gain of each column."""
        return np.asarray(self.gains[self.atoms, self.ranks])

    @property
    def least(self) -> Floats:
        """(Z,) float."""
        atoms, ranks = self.atoms, self.ranks
        return np.where(ranks == self.lo[atoms], -self.lo[atoms], 0).astype(np.float64)

    @property
    def most(self) -> Floats:
        """(Z,) float."""
        atoms, ranks = self.atoms, self.ranks
        beyond = self.gains.shape[1] - 1 - self.hi[atoms]
        return np.where(ranks == self.hi[atoms] - 1, 1 + beyond, 1).astype(np.float64)

    @property
    def base(self) -> float:
        """What the looks below the windows pay."""
        return float(np.where(np.arange(self.gains.shape[1]) < self.lo[:, None], self.gains, 0.0).sum())


@dataclass(frozen=True, eq=False)
class _Solved:
    """A solution of the linear program: n (A,), ends (R,), v (R,), and its prices."""

    counts: Floats
    ending: Floats
    visited: Floats
    prices: Prices


class _Program:
    """The linear program: columns n, v of the regions that have cuts, ends, z; rows looks, v, seconds, cuts."""

    def __init__(self, network: RegionNetwork, levels: Levels, cuts: list[Cut]) -> None:
        self.network, self.cuts = network, cuts
        regions = np.unique([cut.region for cut in cuts]).astype(np.int64)
        self.regions, self.place = regions, np.full(network.ground.n_regions + 1, -1)
        self.place[regions] = np.arange(len(regions))
        self.of_atom = np.where(network.home >= 0, self.place[network.home], -1)  # the column v of each atom, or -1
        self.levels = levels.whole(self.of_atom >= 0)
        n_actions, n_regions = network.ground.n_actions, network.ground.n_regions
        self.v = n_actions
        self.ends = self.v + len(regions)
        self.z = self.ends + n_regions
        self.n_columns = self.z + len(self.levels.atoms)

    def solved(self) -> _Solved | None:
        """Solve it by HiGHS (Huangfu and Hall 2018)."""
        network, levels = self.network, self.levels
        n_regions, unit = network.ground.n_regions, max(float(levels.gains.max()), 1e-300)
        cost = np.zeros(self.n_columns)
        cost[self.z :] = -levels.paid / unit
        rows, most = self._rows()
        once = csr_array(np.where(self._columns(self.ends, n_regions), 1.0, 0.0)[None])
        bounds = np.stack([np.zeros(self.n_columns), np.ones(self.n_columns)], axis=1)
        bounds[: self.v, 1] = network.most
        bounds[self.ends : self.z, 1] = network.n_open
        bounds[self.z :] = np.stack([levels.least, levels.most], axis=1)
        found: Any = linprog(cost, rows, most, once, [network.n_open], bounds, method="highs-ds")
        if found.status != 0:
            return None
        price = -found.ineqlin.marginals * unit
        n_atoms, n_cuts = len(levels.lo), len(self.cuts)
        searches = np.zeros(n_regions)
        searches[self.regions] = price[len(price) - n_cuts - len(self.regions) : len(price) - n_cuts]
        x = found.x
        visited = np.ones(n_regions)
        visited[(network.most[:n_regions] == 0)] = 0.0
        visited[self.regions] = x[self.v : self.ends]
        ending = x[self.ends : self.z] + np.bincount(network.lasts[network.lasts >= 0], minlength=n_regions)
        return _Solved(
            x[: self.v], ending, self._worth_visiting(x, visited),
            Prices(price[:n_atoms], price[len(price) - n_cuts :], searches),
        )  # fmt: skip

    def _worth_visiting(self, x: Floats, visited: Floats) -> Floats:
        """v without those that are free: regions that nobody needs."""
        network = self.network
        used = np.zeros(len(visited))
        own = network.home >= 0
        np.maximum.at(used, network.home[own], np.minimum(network.looks(x[: self.v])[own], 1.0))
        searched = np.minimum(x[: len(visited)], 1.0)
        return np.minimum(visited, np.maximum(used, searched))

    def _columns(self, first: int, count: int) -> NDArray[np.bool_]:
        there = np.zeros(self.n_columns, bool)
        there[first : first + count] = True
        return there

    def _rows(self) -> tuple[csr_array, Floats]:
        """Left and right sides of all inequalities: looks, seconds, z <= v, n <= N v, cuts."""
        network, levels, ground = self.network, self.levels, self.network.ground
        n_atoms, n_z, n_kinds = len(levels.lo), len(levels.atoms), len(network.limits_s)
        entries: list[tuple[NDArray[Any], NDArray[Any], NDArray[Any]]] = [
            (levels.atoms, self.z + np.arange(n_z), np.ones(n_z)),
            (ground.atoms, network.actions, -np.ones(len(ground.atoms))),
            (n_atoms + network.kinds, np.arange(ground.n_actions), ground.seconds / network.limits_s[network.kinds]),
        ]
        tied = np.flatnonzero(self.of_atom[levels.atoms] >= 0)
        rows = n_atoms + n_kinds + np.arange(len(tied))
        entries += [
            (rows, self.z + tied, np.ones(len(tied))),
            (rows, self.v + self.of_atom[levels.atoms[tied]], -levels.most[tied]),
        ]
        rows = n_atoms + n_kinds + len(tied) + np.arange(len(self.regions))
        most = network.most[self.regions].astype(np.float64)
        entries += [
            (rows, self.regions, np.ones(len(rows))),
            (rows, self.v + np.arange(len(rows)), -most),
        ]
        right: list[Any] = [-levels.lo, np.ones(n_kinds), np.zeros(len(tied) + len(rows))]
        count = n_atoms + n_kinds + len(tied) + len(rows)
        for number, cut in enumerate(self.cuts):
            crossing, ending = np.flatnonzero(network.crossed(cut)), self.ends + np.flatnonzero(cut.inside)
            touched = np.concatenate([crossing, ending, [self.v + self.place[cut.region]]])
            weights = np.append(-np.ones(len(touched) - 1), 2.0)
            entries.append((np.full(len(touched), count + number), touched, weights))
            right.append([float(cut.inside[network.lasts[network.lasts >= 0]].sum())])
        where, columns, values = zip(*entries, strict=True)
        shape = (count + len(self.cuts), self.n_columns)
        left = coo_array((np.concatenate(values), (np.concatenate(where), np.concatenate(columns))), shape=shape)
        return left.tocsr(), np.concatenate(right).astype(np.float64)
