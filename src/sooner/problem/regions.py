"""Moves over regions: search the region here, or fly to the next; actions take seconds and look at many cells."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InfeasibleProblemError, InvalidProblemError
from sooner.problem.atoms import Atoms, Footprints
from sooner.problem.moves import Looks

if TYPE_CHECKING:
    from sooner.grid import Grid
    from sooner.problem.search_problem import Searcher

__all__ = ["RegionGraph", "RegionMoves"]

ROUNDING_S = 1e-6  # a plan may be so much longer than its budget, because sums of seconds are rounded


@dataclass(frozen=True, eq=False)
class RegionGraph:
    """What can be flown: a search of each region, each way between two, and legs to and from a searcher's own places.

    Actions have numbers: 0 to R - 1 search a region, R to R + E - 1 fly an edge (whichever way), then come the legs.
    A search begins and ends at its region's centre, an edge joins two centres.

    Parameters
    ----------
    n_regions : int                 R
    edges : (E, 2) int              the two regions that each joins
    seconds : (A,) float            that each action takes
    paths : of (n, 2) float         waypoints of each action, metres east and north; an edge's from its first region
    footprints : Footprints         cells that each action looks at
    labels : (H, W) int32           region of each cell, -1 where none
    """

    n_regions: int
    edges: NDArray[np.int64]
    seconds: NDArray[np.float64]
    paths: tuple[NDArray[np.float64], ...]
    footprints: Footprints
    labels: NDArray[np.int32]

    def __post_init__(self) -> None:
        if not (np.isfinite(self.seconds).all() and (self.seconds >= 0).all()):
            raise InvalidProblemError("seconds of actions came negative or not finite")
        if (self.seconds[: self.n_regions + self.n_edges] <= 0).any():
            raise InvalidProblemError("an action that takes no time came; expected searches and edges to take some")

    @property
    def n_edges(self) -> int:
        """Number of edges E."""
        return len(self.edges)

    @cached_property
    def ways(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """For each region, the edges that lead away, each with where to: by the number of the edge's action."""
        found: list[list[tuple[int, int]]] = [[] for _ in range(self.n_regions)]
        for edge, (one, other) in enumerate(self.edges.tolist()):
            found[one].append((self.n_regions + edge, other))
            found[other].append((self.n_regions + edge, one))
        return tuple(map(tuple, found))

    def target(self, action: int, region: int) -> int | None:
        """Where an action that begins in `region` ends; None where it cannot begin there."""
        if 0 <= action < self.n_regions:
            return region if action == region else None
        if not self.n_regions <= action < self.n_regions + self.n_edges:
            return None
        one, other = self.edges[action - self.n_regions].tolist()
        return other if region == one else one if region == other else None


@dataclass(frozen=True, eq=False)
class RegionMoves:
    """A walk over regions: each action begins where the one before ended, and none is cut short.

    Parameters
    ----------
    graph : RegionGraph
    atoms : Atoms               of the graph's footprints
    first : int                 region in which the walk begins
    last : int                  region in which it ends; -1: any
    depart : int                leg from the start to the first region's centre, as an action; -1: the start is there
    back : int                  leg from the last region's centre to the end; -1: the end is there, or there is none
    """

    graph: RegionGraph
    atoms: Atoms
    first: int
    last: int = -1
    depart: int = -1
    back: int = -1
    departs_s: ClassVar[float] = 0.0

    def check(self, grid: Grid, searcher: Searcher) -> None:
        """Enough seconds to get from the start to the end."""
        if not (np.isfinite(searcher.budget) and searcher.budget > 0):
            raise InvalidProblemError(f"a budget of {searcher.budget} s came; expected a positive number")
        least = self.leg_s + float(self.from_first[self.last])
        if self.last >= 0 and least > searcher.budget + ROUNDING_S:
            raise InfeasibleProblemError(
                f"the way from start to end alone takes {least:.1f} s; the budget is {searcher.budget:g} s"
            )
        if self.leg_s + self.quickest_s > searcher.budget + ROUNDING_S:
            raise InfeasibleProblemError(
                f"a budget of {searcher.budget:g} s came; the quickest action, with the ways to and from it, takes "
                f"{self.leg_s + self.quickest_s:.1f} s"
            )

    def n_items(self, grid: Grid) -> int:
        """One row for each atom."""
        return self.atoms.n_atoms

    @property
    def legs(self) -> tuple[int, ...]:
        """Actions that every plan has."""
        return tuple(leg for leg in (self.depart, self.back) if leg >= 0)

    @property
    def leg_s(self) -> float:
        """Seconds that the legs take."""
        return float(sum(self.graph.seconds[leg] for leg in self.legs))

    @cached_property
    def quickest_s(self) -> float:
        """The shortest action that can be first, and from there to where the walk must end."""
        ways = [(self.first, self.first), *self.graph.ways[self.first]]
        return min(float(self.graph.seconds[action] + self.to_last[there]) for action, there in ways)

    @cached_property
    def from_first(self) -> NDArray[np.float64]:
        """(R,) float: seconds from the first region's centre to that of every other; inf where there is no way."""
        return self.seconds_from(self.first)

    @cached_property
    def to_last(self) -> NDArray[np.float64]:
        """(R,) float: seconds from every region's centre to the last one's; zero where the walk may end anywhere."""
        return np.zeros(self.graph.n_regions) if self.last < 0 else self.seconds_from(self.last)

    def seconds_from(self, region: int) -> NDArray[np.float64]:
        """(R,) float: of the quickest way over edges from a region to every other."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import dijkstra

        graph, count = self.graph, self.graph.n_regions
        weights = graph.seconds[count : count + graph.n_edges]
        ends = (graph.edges[:, 0], graph.edges[:, 1])
        joined = coo_array((weights, ends), shape=(count, count)).tocsr()
        return np.asarray(dijkstra(joined, directed=False, indices=region))

    def fault(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> str | None:
        """Why this sequence of actions cannot be flown, or None if it can."""
        if actions.ndim != 1 or len(actions) == 0:
            return "it has no actions; expected at least one"
        here = self.first
        for number, action in enumerate(actions.tolist()):
            there = self.graph.target(action, here)
            if there is None:
                return f"action {number} is {self.named(action)}, which cannot begin in region {here}"
            here = there
        if self.last >= 0 and here != self.last:
            return f"it ends in region {here}; the end is in region {self.last}"
        taken = self.seconds(actions)
        if taken > searcher.budget + ROUNDING_S:
            return f"it takes {taken:.1f} s; the budget is {searcher.budget:g} s"
        return None

    def named(self, action: int) -> str:
        """An action in words."""
        if 0 <= action < self.graph.n_regions:
            return f"search of region {action}"
        if self.graph.n_regions <= action < self.graph.n_regions + self.graph.n_edges:
            one, other = self.graph.edges[action - self.graph.n_regions].tolist()
            return f"flight between regions {one} and {other}"
        return f"unknown ({action})"

    def seconds(self, actions: NDArray[np.int64]) -> float:
        """How long a plan takes, its legs included."""
        return float(self.graph.seconds[actions].sum()) + self.leg_s

    def flown(self, actions: Sequence[int] | NDArray[np.int64]) -> Iterator[tuple[int, float, bool]]:
        """Each action with when it begins and whether it is flown the other way round, the legs included."""
        now, here = 0.0, self.first
        if self.depart >= 0:
            yield self.depart, now, False
            now += float(self.graph.seconds[self.depart])
        for action in map(int, actions):
            there = self.graph.target(action, here)
            turned = action >= self.graph.n_regions and int(self.graph.edges[action - self.graph.n_regions, 0]) != here
            yield action, now, turned
            now += float(self.graph.seconds[action])
            here = here if there is None else there
        if self.back >= 0:
            yield self.back, now, False

    def looks(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> Looks:
        """Each action looks at the atoms that it covers whenever the mean cell of each comes into view."""
        items, times = [np.zeros(0, np.int64)], [np.zeros(0)]
        for action, begun, turned in self.flown(actions):
            entries = slice(self.atoms.starts[action], self.atoms.starts[action + 1])
            items.append(self.atoms.covered[entries])
            times.append(begun + (self.atoms.back_s if turned else self.atoms.seconds)[entries])
        all_items, all_times = np.concatenate(items), np.concatenate(times)
        order = np.argsort(all_times, kind="stable")
        return Looks(all_items[order], all_times[order])

    def cell_looks(self, grid: Grid, actions: NDArray[np.int64]) -> NDArray[np.int64]:
        """(N,) int: how often each cell is looked at, counted cell by cell and without atoms."""
        found = np.zeros(grid.n_cells, np.int64)
        for action, _, _ in self.flown(actions):
            found += np.bincount(self.graph.footprints.of(action), minlength=grid.n_cells)
        return found

    def timed(self, actions: Sequence[int] | NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(n, 2) waypoints of a flight, and (n,) about when it is there: an action's time is spread over its length."""
        points, times = [np.zeros((0, 2))], [np.zeros(0)]
        for action, begun, turned in self.flown(actions):
            path = self.graph.paths[action][::-1] if turned else self.graph.paths[action]
            along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
            share = along / along[-1] if along[-1] > 0 else np.linspace(0.0, 1.0, len(along))
            points.append(path)
            times.append(begun + share * float(self.graph.seconds[action]))
        return np.concatenate(points), np.concatenate(times)

    def path(self, actions: Sequence[int] | NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 2) float: waypoints of the whole plan, metres east and north."""
        parts = [
            self.graph.paths[action][::-1] if turned else self.graph.paths[action]
            for action, _, turned in self.flown(actions)
        ]
        whole = np.concatenate(parts) if parts else np.zeros((0, 2))
        moved = np.append(True, (np.diff(whole, axis=0) != 0).any(axis=1))[: len(whole)]
        return np.asarray(whole[moved])
