"""Depth-first coverage of regions, several times over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.problem import Incumbent, Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround, single_region_searcher

__all__ = ["DepthFirst", "relaxation"]


@dataclass(frozen=True)
class DepthFirst:
    """Walk a depth-first tree over all regions again and again, and search each region as often as is worth it.

    How often that is, S_g, the relaxation says that picks actions by rate from anywhere. At most one search a visit;
    until the time is used up or every region has had its searches [Kuhlman2017, sec. 4.1]. The paper leaves open which
    neighbour comes first: here the nearest.
    """

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over regions."""
        return single_region_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield once."""
        ground = RegionGround.of(problem)
        plan = Plan.of(_Walk(ground, relaxation(ground)[1]).actions())
        yield Incumbent(plan, evaluate(problem, plan).value)


def relaxation(ground: RegionGround) -> tuple[float, NDArray[np.int64]]:
    """What actions picked by rate from anywhere collect, and how often each is picked [Kuhlman2017, eq. (4)].

    The paper's iterative greedy heuristic: a reference, and no bound where footprints overlap.
    """
    from sooner.planners._region_kernels import relaxed

    looks, counts = np.zeros(len(ground.gains), np.int64), np.zeros(ground.n_actions, np.int64)
    value = relaxed(
        ground.starts, ground.atoms, ground.before, ground.cover_starts, ground.covers, ground.cover_before,
        ground.seconds, ground.gains, looks, ground.limit_s, counts,
    )  # fmt: skip
    return ground.leg_value + value, counts


class _Walk:
    """The walk so far."""

    def __init__(self, ground: RegionGround, wanted: NDArray[np.int64]) -> None:
        self.ground, self.wanted = ground, wanted[: ground.n_regions].copy()
        self.here, self.left = ground.first, ground.limit_s
        self.flown: list[int] = []

    def actions(self) -> list[int]:
        """Tour after tour."""
        tour = _tour(self.ground)
        self._search()
        while self.wanted.any() and len(tour) > 1:
            before = self.wanted.sum()
            for here, there in pairwise(tour):
                edge = next(action for action, to in self.ground.ways_from(here)[1:] if to == there)
                if not self._fits(edge, there):
                    return self._ended()
                self._fly(edge, there)
                self._search()
                if not self.wanted.any():
                    return self._ended()
            if self.wanted.sum() == before:  # no search has fitted in a whole tour
                break
        while self.wanted[self.here] and self._fits(self.here, self.here):  # a single region
            self._search()
        return self._ended()

    def _search(self) -> None:
        if self.wanted[self.here] and self._fits(self.here, self.here):
            self.wanted[self.here] -= 1
            self._fly(self.here, self.here)

    def _fits(self, action: int, there: int) -> bool:
        return bool(self.ground.seconds[action] + self.ground.to_last[there] <= self.left + 1e-9)

    def _fly(self, action: int, there: int) -> None:
        self.flown.append(action)
        self.left -= float(self.ground.seconds[action])
        self.here = there

    def _ended(self) -> list[int]:
        """Go to where the walk must end; a walk of nothing at all makes the first action that fits."""
        if not self.flown and self.ground.last in (-1, self.here):
            self._fly(*min(self.ground.ways_from(self.here), key=lambda way: float(self.ground.seconds[way[0]])))
        return [*self.flown, *self.ground.homeward(self.here)]


def _tour(ground: RegionGround) -> list[int]:
    """Regions in the order of a walk around a depth-first tree, back to the first."""
    seen, tour = {ground.first}, [ground.first]
    open_ways = [(ground.first, iter(_nearest(ground, ground.first)))]
    while open_ways:
        _, ways = open_ways[-1]
        there = next((there for there in ways if there not in seen), None)
        if there is None:
            open_ways.pop()
            if open_ways:
                tour.append(open_ways[-1][0])
        else:
            seen.add(there)
            tour.append(there)
            open_ways.append((there, iter(_nearest(ground, there))))
    return tour


def _nearest(ground: RegionGround, region: int) -> list[int]:
    ways = sorted(ground.ways_from(region)[1:], key=lambda way: float(ground.seconds[way[0]]))
    return [there for _, there in ways]
