"""Numbers of actions as one walk."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.problem.region_ground import RegionGround

__all__ = ["walk_of"]


def walk_of(ground: RegionGround, counts: NDArray[np.int32], end: int) -> list[int]:
    """A walk from the first region to `end` that flies each action as often as it is counted.

    Edges make an Eulerian trail (Hierholzer 1873). A region is searched once a visit, and as often as is left on the
    last.

    Examples
    --------
    Two regions, one edge flown there and back, each region searched twice:

    >>> from sooner.problem.region_ground import RegionGround
    """
    regions, edges = _trail(ground, counts, end)
    last = {region: visit for visit, region in enumerate(regions)}
    left = counts[: ground.n_regions].copy()
    walk: list[int] = []
    for visit, region in enumerate(regions):
        searches = int(left[region]) if visit == last[region] else min(int(left[region]), 1)
        walk += [region] * searches + edges[visit : visit + 1]
        left[region] -= searches
    return walk


def _trail(ground: RegionGround, counts: NDArray[np.int32], end: int) -> tuple[list[int], list[int]]:
    """Regions of an Eulerian trail, and the edges between them."""
    left = np.asarray(counts, np.int64).copy()
    at = [1] * ground.n_regions  # the first way of a region is its search
    stack, regions, edges = [(ground.first, -1)], [], []
    while stack:
        here, came_by = stack[-1]
        ways = ground.ways[ground.way_starts[here] : ground.way_starts[here + 1]]
        while at[here] < len(ways) and left[ways[at[here]]] == 0:
            at[here] += 1
        if at[here] == len(ways):
            stack.pop()
            regions.append(here)
            if came_by >= 0:
                edges.append(came_by)
        else:
            action = int(ways[at[here]])
            left[action] -= 1
            stack.append((int(ground.ends[action].sum()) - here, action))
    return regions[::-1], edges[::-1]
