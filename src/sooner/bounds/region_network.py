"""What several walks over one graph of regions share, and a value that no such walks can pass, for any prices.

**Derivation.** Let n_a count how often action a is flown by all searchers together, m_k = sum of n_a over the actions
that cover atom k, and f_k(m) the sum of the first m gains of atom k, once the legs that every plan has are flown. With
prices p_k >= 0 of looks,

    value - legs = sum over k of [f_k(m_k) - p_k m_k] + sum over a of n_a P_a,     P_a = sum of p_k over the atoms of a.

The first brackets are at most h_k = sum over j of (gain(k, j) - p_k)+. The second sum is at most what a knapsack of
fractions holds, filled by the rates P_a / w_a: the actions take sum of n_a w_a <= T, the seconds of all searchers, and
none is flown more than N_a times.

Walks are connected. Let S be a set of regions in which no searcher starts, r in S, v_r = 1 if anybody comes to r and
0 if not, t(S) how many searchers end in S. Every searcher that enters S leaves it again or ends there, so

    n(edges that leave S) + t(S) - 2 v_r >= 0,                                                                   (1)

and y >= 0 times that may be added. Where v_r = 0, atoms that only the search of r and edges to r cover are never
looked at, and r is not searched: n_r <= N_r v_r, of which q_r >= 0 times may be added. In all,

    value <= legs + sum of h_k over atoms of no priced region + knapsack of (P_a + Y_a - q_a)+, seconds w_a, N_a
             + sum over priced regions r of (sum of h_k over atoms of r alone + N_r q_r - 2 sum of y of r's cuts)+
             + sum over searchers of the largest sum of y of cuts with its end in S,                             (2)

where Y_a is the sum of the y of the cuts whose border a crosses.

That holds for any p, y, q >= 0: a solver only has to find good ones, and none of its tolerances count. What remains is
the rounding of sums in (2), orders below the margin of `GUARD`. (1) and (2) take one total of seconds for all
searchers, so for a team the bound is also one for searchers that hand each other their seconds.

Searchers that fly unlike one another have a copy of the graph for each kind (`stacked_ground`), with actions, seconds
and a knapsack of its own; all look at the same atoms. (1) holds within each copy. An atom that two copies cover has no
region r of its own, which only loosens (2).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from sooner.bounds.stacked_ground import stacked, stacked_actions
from sooner.errors import UnsupportedProblemError
from sooner.problem import SearchProblem
from sooner.problem.region_ground import RegionGround
from sooner.problem.regions import ROUNDING_S, RegionMoves

__all__ = ["Cut", "Prices", "RegionNetwork"]

Floats = NDArray[np.float64]

GUARD = 1e-9  # share of a bound that is added to it; a sum of a million floats is rounded by a thousandth of that
CAPACITY = 1_000_000  # one unit of flow, where minimum cuts are found over whole numbers


@dataclass(frozen=True, eq=False)
class Cut:
    """Inequality (1): whoever comes to `region` crosses the border of `inside`, (R,) bool, twice or ends there."""

    inside: NDArray[np.bool_]
    region: int


@dataclass(frozen=True, eq=False)
class Prices:
    """Multipliers of (2): p of looks (K,), y of cuts, one each, and q of searches (R,)."""

    looks: Floats
    cuts: Floats
    searches: Floats


@dataclass(frozen=True, eq=False)
class RegionNetwork:
    """All that searchers can fly and collect together.

    Parameters
    ----------
    ground : RegionGround       actions and atoms; its gains are those that are left once all legs are flown
    firsts : (A,) int           region where each searcher begins
    lasts : (A,) int            and where it ends; -1: anywhere
    kinds : (A,) int            which copy of the graph each action is of
    limits_s : (C,) float       seconds of all searchers together that fly in each copy, without their legs
    most : (A,) int             how often each action can be flown at most; 0 where nobody gets there in time
    home : (K,) int             region that every action which covers the atom touches; -1 where there is none
    """

    ground: RegionGround
    firsts: NDArray[np.int64]
    lasts: NDArray[np.int64]
    kinds: NDArray[np.int64]
    limits_s: Floats
    most: NDArray[np.int64]
    home: NDArray[np.int64]

    @staticmethod
    def of(problem: SearchProblem) -> RegionNetwork:
        """The network of a problem whose searchers move over regions.

        Raises
        ------
        UnsupportedProblemError    where they do not, the person moves, or looks pay for ever
        """
        moves = [searcher.moves for searcher in problem.searchers]
        regional = [each for each in moves if isinstance(each, RegionMoves)]
        if problem.drift is not None or len(regional) < len(moves):
            raise UnsupportedProblemError("this bound needs moves over regions and a person who stays")
        if problem.gains.ratio.any():
            raise UnsupportedProblemError("this bound needs gains that end with their table")
        grounds = [RegionGround.of(replace(problem, searchers=(searcher,))) for searcher in problem.searchers]
        graphs = list({id(each.graph): each.graph for each in regional}.values())
        copy = [next(c for c, graph in enumerate(graphs) if graph is each.graph) for each in regional]
        firsts = [next(g for g, c in zip(grounds, copy, strict=True) if c == kind) for kind in range(len(graphs))]
        order = stacked_actions(firsts)
        kinds = np.repeat(np.arange(len(graphs)), [each.n_actions for each in firsts])
        ground = firsts[0] if len(graphs) == 1 else stacked(firsts)
        if len(grounds) > 1:
            ground = _joint(problem, ground, regional)
        most = np.zeros(len(kinds), np.int64)
        limits_s = np.zeros(len(graphs))
        for own, walk, kind in zip(grounds, regional, copy, strict=True):
            most[kinds == kind] += _most(own, walk)
            limits_s[kind] += own.limit_s + ROUNDING_S
        shift = np.cumsum([0, *(each.n_regions for each in firsts)])[copy]
        lasts = np.array([each.last for each in regional])
        return RegionNetwork(
            ground=ground,
            firsts=np.array([each.first for each in regional]) + shift,
            lasts=np.where(lasts < 0, -1, lasts + shift),
            kinds=kinds[order],
            limits_s=limits_s,
            most=most[order],
            home=_homes(ground),
        )

    @property
    def limit_s(self) -> float:
        """Seconds of all searchers together, without their legs."""
        return float(self.limits_s.sum())

    @property
    def n_open(self) -> int:
        """Searchers that may end anywhere."""
        return int((self.lasts < 0).sum())

    @property
    def actions(self) -> NDArray[np.int64]:
        """(C,) int: the action of each entry of the ground's atoms."""
        return np.repeat(np.arange(self.ground.n_actions), np.diff(self.ground.starts))

    def looks(self, counts: NDArray[np.floating] | NDArray[np.integer]) -> Floats:
        """(K,) float: looks at each atom where actions are flown so often."""
        flown = np.asarray(counts, np.float64)[self.actions]
        return np.bincount(self.ground.atoms, flown, len(self.ground.gains)).astype(np.float64)

    def crossed(self, cut: Cut) -> NDArray[np.bool_]:
        """(A,) bool: actions that cross the border of the cut's set."""
        ends = cut.inside[self.ground.ends]
        return np.asarray(ends[:, 0] != ends[:, 1])

    # --- the bound ------------------------------------------------------------------------------------------------
    def bound(self, prices: Prices, cuts: list[Cut]) -> float:
        """Inequality (2), with its margin."""
        ground = self.ground
        look, cut, search = (np.maximum(each, 0.0) for each in (prices.looks, prices.cuts, prices.searches))
        paid = np.bincount(self.actions, look[ground.atoms], ground.n_actions)
        paid[: ground.n_regions] -= search
        inside = np.zeros(ground.n_regions)
        spent = np.zeros(ground.n_regions)
        for price, each in zip(cut, cuts, strict=True):
            paid += price * self.crossed(each)
            inside += price * each.inside
            spent[each.region] += 2.0 * price
        left = np.maximum(ground.gains - look[:, None], 0.0).sum(axis=1)  # h
        priced = (search > 0) | (spent > 0)
        own = (self.home >= 0) & priced[self.home]
        per_region = np.bincount(self.home[own], left[own], ground.n_regions) + self.most[: ground.n_regions] * search
        total = left[~own].sum() + np.maximum(per_region - spent, 0.0)[priced].sum()
        rates, room = paid / ground.seconds, self.most * ground.seconds
        for kind, limit_s in enumerate(self.limits_s.tolist()):
            total += _knapsack(rates[self.kinds == kind], room[self.kinds == kind], limit_s)
        total += self.n_open * inside.max() + inside[self.lasts[self.lasts >= 0]].sum()
        return float(ground.leg_value + total) * (1.0 + GUARD)

    # --- sets that a solution enters too little -------------------------------------------------------------------
    def violated(self, counts: Floats, ending: Floats, visited: Floats, slack: float = 1e-3) -> list[Cut]:
        """Cuts (1) that these numbers of actions violate, by minimum cuts between the starts and each region.

        Parameters
        ----------
        counts : (A,) float       how often each action is flown
        ending : (R,) float       how many searchers end in each region
        visited : (R,) float      v
        slack : float             smallest violation that counts
        """
        graph, source = self._capacities(counts, ending), self.ground.n_regions
        found: dict[bytes, Cut] = {}
        for region in np.argsort(-visited).tolist():
            if visited[region] <= slack:
                break
            if region in self.firsts:
                continue
            flow = maximum_flow(graph, source, region)
            if flow.flow_value < 2.0 * (visited[region] - slack) * CAPACITY:
                inside = _behind(graph - flow.flow, region)[:source]
                found.setdefault(inside.tobytes(), Cut(inside, region))
        return list(found.values())

    def _capacities(self, counts: Floats, ending: Floats) -> coo_array:
        """Edges both ways; and from a source to the starts without limit, to every region as many as end there."""
        ground, source = self.ground, self.ground.n_regions
        one, other = ground.ends[ground.n_regions :].T
        edges, regions = counts[ground.n_regions :], np.arange(ground.n_regions)
        inward = np.where(np.isin(regions, self.firsts), 2.0 * len(self.firsts) + 2.0, ending)
        tails = np.concatenate([one, other, np.full(ground.n_regions, source)])
        heads = np.concatenate([other, one, regions])
        room = np.round(np.minimum(np.concatenate([edges, edges, inward]), 1000.0) * CAPACITY).astype(np.int32)
        return coo_array((room, (tails, heads)), shape=(source + 1, source + 1)).tocsr()


def _knapsack(rates: Floats, room: Floats, limit: float) -> float:
    """The most that `limit` can collect, spread over actions with so much room each, by rate."""
    order = np.argsort(-rates, kind="stable")
    rates, room = np.maximum(rates[order], 0.0), room[order]
    return float(rates @ np.clip(limit - (np.cumsum(room) - room), 0.0, room))


def _behind(residual: coo_array, region: int) -> NDArray[np.bool_]:
    """Nodes from which the region can be reached over what is left of the capacities."""
    left = residual.tocsr()
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    inside = np.zeros(left.shape[0], bool)
    inside[breadth_first_order(left.T.tocsr(), region, return_predecessors=False)] = True
    return inside


def _joint(problem: SearchProblem, ground: RegionGround, moves: list[RegionMoves]) -> RegionGround:
    """The ground with all searchers' legs flown."""
    legs = [each.atoms.of(leg) for each in moves for leg in each.legs]
    looked = np.bincount(np.concatenate([*legs, np.zeros(0, np.int64)]), minlength=len(ground.gains))
    table = problem.gains.after(looked).table
    before = np.where(np.arange(problem.gains.table.shape[1]) < looked[:, None], problem.gains.table, 0.0)
    gains = np.concatenate([table, np.zeros((len(table), 1))], axis=1)
    return replace(ground, gains=gains, leg_value=float(before.sum()))


def _most(ground: RegionGround, moves: RegionMoves) -> NDArray[np.int64]:
    """(A,) int: how often one searcher can fly each action, the way there and on to its end flown once."""
    one, other = ground.ends.T
    there, back = moves.from_first, ground.to_last
    way = np.minimum(there[one] + back[other], there[other] + back[one])
    left = np.where(np.isfinite(way), ground.limit_s - way, -1.0) + ROUNDING_S
    searches = np.arange(ground.n_actions) < ground.n_regions
    once = left >= ground.seconds
    whole = np.floor(np.where(searches, left, ground.limit_s + ROUNDING_S) / ground.seconds + 1e-9)
    return np.where(once, whole, 0.0).astype(np.int64)


def _homes(ground: RegionGround) -> NDArray[np.int64]:
    """(K,) int: a region that all actions which cover an atom touch, their search's own first; -1 where none."""
    homes = np.full(len(ground.gains), -1, np.int64)
    for atom in range(len(homes)):
        ends = ground.ends[ground.covers[ground.cover_starts[atom] : ground.cover_starts[atom + 1]]]
        if not len(ends):
            continue
        common = [end for end in dict.fromkeys(ends[0].tolist()) if (ends == end).any(axis=1).all()]
        homes[atom] = common[0] if common else -1
    return homes
