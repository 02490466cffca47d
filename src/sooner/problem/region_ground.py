"""A search over regions as plain arrays, the form in which planners and bounds work on it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sooner.problem.regions import RegionMoves
from sooner.problem.search_problem import SearchProblem

__all__ = ["RegionGround", "single_region_searcher"]


def single_region_searcher(problem: SearchProblem) -> str | None:
    """What planners over regions handle: one searcher, a person who stays, the most by the end; None if it is so."""
    if len(problem.searchers) != 1:
        return f"it plans for one searcher; this problem has {len(problem.searchers)}"
    if not isinstance(problem.searcher.moves, RegionMoves):
        return "it plans moves over regions"
    if problem.drift is not None:
        return "it plans for a person who stays"
    if problem.objective.target is not None:
        return "it plans for the most by the end"
    return None


@dataclass(frozen=True, eq=False)
class RegionGround:
    """What can be flown from where, what it takes and what it pays.

    Action a < R searches region a; action R + e flies edge e. Legs that every plan has are taken off the time, and
    their looks off the gains.

    Parameters
    ----------
    n_regions : int                  R
    ends : (A, 2) int                regions at the two ends of an action; the same for a search
    seconds : (A,) float
    limit_s : float                  time for all actions together
    first, last : int                where the walk begins and ends; last = -1: anywhere
    to_last : (R,) float             seconds of the quickest way to where it ends
    starts : (A + 1,) int            action a covers atoms[starts[a]:starts[a + 1]], each as often as it looks there
    atoms : (C,) int
    before : (C,) int                looks at that atom that the same action has taken before; 0, 1, 2, ... in order
    cover_starts : (K + 1,) int      atom k is covered by covers[cover_starts[k]:cover_starts[k + 1]], one a look
    covers : (C,) int
    cover_before : (C,) int          looks that the same action has taken before that one
    way_starts : (R + 1,) int        actions that can begin in region r are ways[way_starts[r]:way_starts[r + 1]],
    ways : (R + 2 E,) int            its search first
    gains : (K, L + 1) float         what the k-th look pays once the legs are flown; the last column is zero
    leg_value : float                what the legs pay
    """

    n_regions: int
    ends: NDArray[np.int64]
    seconds: NDArray[np.float64]
    limit_s: float
    first: int
    last: int
    to_last: NDArray[np.float64]
    starts: NDArray[np.int64]
    atoms: NDArray[np.int64]
    before: NDArray[np.int64]
    cover_starts: NDArray[np.int64]
    covers: NDArray[np.int64]
    cover_before: NDArray[np.int64]
    way_starts: NDArray[np.int64]
    ways: NDArray[np.int64]
    gains: NDArray[np.float64]
    leg_value: float

    @property
    def n_actions(self) -> int:
        """Searches and edges, A."""
        return len(self.seconds)

    @property
    def arrays(self) -> tuple[NDArray[np.int64], ...]:
        """What kernels take: starts, atoms, cover_starts, covers, way_starts, ways, ends."""
        return self.starts, self.atoms, self.cover_starts, self.covers, self.way_starts, self.ways, self.ends

    def ways_from(self, region: int) -> list[tuple[int, int]]:
        """Actions that can begin in a region, its search first, each with the region where it ends."""
        ways = self.ways[self.way_starts[region] : self.way_starts[region + 1]].tolist()
        return [(action, int(self.ends[action].sum()) - region) for action in ways]

    def walked(self, actions: Iterable[int]) -> int:
        """Region in which a walk of these actions ends."""
        here = self.first
        for action in actions:
            here = int(self.ends[action].sum()) - here
        return here

    def homeward(self, region: int) -> list[int]:
        """Edges of the quickest way from a region to where the walk must end; none where it may end anywhere."""
        edges: list[int] = []
        while self.last not in (-1, region):
            action, region = min(
                self.ways_from(region)[1:], key=lambda way: float(self.seconds[way[0]] + self.to_last[way[1]])
            )
            edges.append(action)
        return edges

    def quickest(self) -> list[int]:
        """The shortest walk there is: one action, and from there to where it must end."""
        action, there = min(
            self.ways_from(self.first), key=lambda way: float(self.seconds[way[0]] + self.to_last[way[1]])
        )
        return [action, *self.homeward(there)]

    @staticmethod
    def of(problem: SearchProblem) -> RegionGround:
        """The ground of a problem with one searcher over regions."""
        moves = problem.searcher.moves
        assert isinstance(moves, RegionMoves)
        graph, atoms = moves.graph, moves.atoms
        count = graph.n_regions + graph.n_edges
        own = np.arange(graph.n_regions)[:, None].repeat(2, axis=1)
        entries = atoms.starts[count]
        covered, starts = atoms.covered[:entries], atoms.starts[: count + 1]
        legs = np.concatenate([np.zeros(0, np.int64), *(atoms.of(leg) for leg in moves.legs)])
        cover_starts, order = _turned(covered, atoms.n_atoms)
        actions, before = np.repeat(np.arange(count), np.diff(starts)), atoms.before[:entries]
        ways = [[region, *(action for action, _ in graph.ways[region])] for region in range(graph.n_regions)]
        table = problem.gains.after(np.bincount(legs, minlength=atoms.n_atoms)).table
        return RegionGround(
            n_regions=graph.n_regions,
            ends=np.concatenate([own, graph.edges]).astype(np.int64),
            seconds=np.ascontiguousarray(graph.seconds[:count]),
            limit_s=float(problem.searcher.budget) - moves.leg_s,
            first=moves.first,
            last=moves.last,
            to_last=moves.to_last,
            starts=np.ascontiguousarray(starts, np.int64),
            atoms=np.ascontiguousarray(covered, np.int64),
            before=before,
            cover_starts=cover_starts,
            covers=actions[order],
            cover_before=before[order],
            way_starts=np.cumsum([0, *map(len, ways)]),
            ways=np.concatenate(ways).astype(np.int64),
            gains=np.concatenate([table, np.zeros((len(table), 1))], axis=1),
            leg_value=_value(problem, legs),
        )


def _turned(atoms: NDArray[np.int64], n_atoms: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where each atom's entries begin once they are in order of atoms, and that order."""
    ends = np.cumsum(np.bincount(atoms, minlength=n_atoms))
    return np.concatenate([[0], ends]), np.argsort(atoms, kind="stable")


def _value(problem: SearchProblem, items: NDArray[np.int64]) -> float:
    """What looks at these atoms pay together."""
    looked = np.bincount(items, minlength=problem.gains.n_cells)
    total = 0.0
    for look in range(int(looked.max(initial=0))):
        there = np.flatnonzero(looked > look)
        total += float(problem.gains.of(there, np.full(there.size, look)).sum())
    return total
