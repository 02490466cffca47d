"""Numbers of actions as one walk, and which of all such walks pays early."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.problem.region_ground import RegionGround

__all__ = ["early_order", "walk_of"]

LONG = 4000  # actions beyond which a walk is taken as it comes
WORK = 2_000_000  # looks that putting a walk into a better order may cost: some ten milliseconds
REACH = 300  # actions between which it may be changed


def walk_of(ground: RegionGround, counts: NDArray[np.int32], end: int) -> list[int]:
    """A walk from the first region to `end` that flies each action as often as it is counted, what pays most first.

    What the actions collect together does not depend on their order; how early they do does. See `early_order`; walks
    of thousands of actions are not ordered: their edges make any Eulerian trail (Hierholzer 1873), and a region is
    searched once a visit, and as often as is left on the last.
    """
    if counts.sum() <= LONG:
        return early_order(ground, counts)
    regions, edges = _trail(ground, counts, end)
    last = {region: visit for visit, region in enumerate(regions)}
    left = counts[: ground.n_regions].copy()
    walk: list[int] = []
    for visit, region in enumerate(regions):
        searches = int(left[region]) if visit == last[region] else min(int(left[region]), 1)
        walk += [region] * searches + edges[visit : visit + 1]
        left[region] -= searches
    return walk


def early_order(ground: RegionGround, counts: NDArray[np.int32], work: int = WORK) -> list[int]:
    """A walk of the counted actions with much of its gain early.

    Built step by step: toward the search that pays most a second, the edges to it included, over edges that are left,
    but over no bridge to what could not be flown any more (Fleury 1883). Then, for as long as it helps, closed walks
    between visits of one region are turned round or change places; such changes lead from any Eulerian trail to any
    other (Kotzig 1968), here each of them must help.

    Parameters
    ----------
    counts : (A,) int          how often each action is flown; numbers that one walk from the first region can have
    work : int                 looks that changes may cost

    Returns
    -------
    list of int                the same numbers, whichever way they are ordered, end in the same region
    """
    from sooner.planners._walk_kernels import improve, order

    walk = np.empty(int(counts.sum()), np.int64)
    starts, atoms, _, _, way_starts, ways, ends = ground.arrays
    order(
        starts, atoms, ground.before, way_starts, ways, ends, ground.seconds, ground.gains, ground.first, counts, walk
    )
    improve(starts, atoms, ends, ground.seconds, ground.gains, ground.first, walk, REACH, work)
    found: list[int] = walk.tolist()
    return found


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
