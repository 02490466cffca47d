"""Compiled orders of the actions of a walk over regions: plain arrays in, plain arrays out.

left (A,) int64        how often each action is still to be flown; a < R searches region a, from anywhere to itself
looks (K,) int64       looks at each atom so far
before (C,) int64      looks that an action has taken at the atom of each of its entries
sum over actions of gain times the middle of its time, in gain seconds, is what an early walk has little of.
"""

import numpy as np
from numba import njit

NEAR = 48  # regions around that are asked for the next search


@njit(cache=True, nogil=True)
def _look(starts, atoms, gains, looks, action):
    """What an action pays now; its looks are counted."""
    last = gains.shape[1] - 1
    value = 0.0
    for entry in range(starts[action], starts[action + 1]):
        atom = atoms[entry]
        value += gains[atom, min(looks[atom], last)]
        looks[atom] += 1
    return value


@njit(cache=True, nogil=True)
def _would_pay(starts, atoms, before, gains, looks, action):
    """What an action would pay now."""
    last = gains.shape[1] - 1
    value = 0.0
    for entry in range(starts[action], starts[action + 1]):
        value += gains[atoms[entry], min(looks[atoms[entry]] + before[entry], last)]
    return value


@njit(cache=True, nogil=True)
def _may_leave(way_starts, ways, ends, left, marks, stack, here, action):
    """Whether what is left can still be flown as one walk after this edge (Fleury 1883): it burns no bridge."""
    if left[action] > 1:
        return True
    others = 0
    for way in range(way_starts[here], way_starts[here + 1]):
        if ways[way] != action and left[ways[way]] > 0:
            others += 1
    if others == 0:
        return True
    marks[:] = False
    there = ends[action, 0] + ends[action, 1] - here
    marks[there] = True
    stack[0] = there
    size = 1
    while size > 0:
        size -= 1
        region = stack[size]
        for way in range(way_starts[region] + 1, way_starts[region + 1]):
            other = ways[way]
            if left[other] > 0 and other != action:
                beyond = ends[other, 0] + ends[other, 1] - region
                if beyond == here:
                    return True
                if not marks[beyond]:
                    marks[beyond] = True
                    stack[size] = beyond
                    size += 1
    return False


@njit(cache=True, nogil=True)
def _next(
    starts, atoms, before, way_starts, ways, ends, seconds, gains, left, looks, here, far, worth, first, open_regions
):  # fmt: skip
    """The search here, or else the first edge of the way to the search that pays most a second, ways included.

    Regions are asked in the order in which they are reached, the nearest `NEAR` and on to the first that can be
    searched. `far` is inf everywhere before and after; -1 where no search can be reached.
    """
    far[here], worth[here], first[here] = 0.0, 0.0, -1
    open_regions[0] = here
    settled, size = 0, 1  # open_regions[:settled] are done with, open_regions[settled:size] reached
    best, choice = -1.0, -1
    while settled < size and (settled < NEAR or choice < 0):
        nearest = settled
        for n in range(settled + 1, size):
            if far[open_regions[n]] < far[open_regions[nearest]]:
                nearest = n
        region = open_regions[nearest]
        open_regions[nearest], open_regions[settled] = open_regions[settled], region
        settled += 1
        if left[region] > 0:
            paid = worth[region] + _would_pay(starts, atoms, before, gains, looks, region)
            rate = paid / (far[region] + seconds[region])
            if rate > best:
                best, choice = rate, region if first[region] < 0 else first[region]
        for way in range(way_starts[region] + 1, way_starts[region + 1]):
            action = ways[way]
            there = ends[action, 0] + ends[action, 1] - region
            if left[action] > 0 and far[region] + seconds[action] < far[there]:
                if far[there] == np.inf:
                    open_regions[size] = there
                    size += 1
                far[there] = far[region] + seconds[action]
                worth[there] = worth[region] + _would_pay(starts, atoms, before, gains, looks, action)
                first[there] = action if first[region] < 0 else first[region]
    for n in range(size):
        far[open_regions[n]] = np.inf
    return choice


@njit(cache=True, nogil=True)
def order(starts, atoms, before, way_starts, ways, ends, seconds, gains, start, counts, walk):
    """Fill `walk` with all the counted actions, what pays most a second first, as far as one walk can have it."""
    n_regions = len(way_starts) - 1
    left = counts.astype(np.int64)
    looks = np.zeros(len(gains), np.int64)
    marks, stack = np.zeros(n_regions, np.bool_), np.zeros(n_regions, np.int64)
    far, worth = np.full(n_regions, np.inf), np.zeros(n_regions)
    first = np.zeros(n_regions, np.int64)
    here = start
    for step in range(len(walk)):
        action = _next(
            starts, atoms, before, way_starts, ways, ends, seconds, gains, left, looks, here, far, worth, first, stack
        )  # fmt: skip
        if action != here and (action < 0 or not _may_leave(way_starts, ways, ends, left, marks, stack, here, action)):
            action = -1
            for way in range(way_starts[here] + 1, way_starts[here + 1]):
                other = ways[way]
                better = left[other] > 0 and (action < 0 or left[other] > left[action])
                if better and _may_leave(way_starts, ways, ends, left, marks, stack, here, other):
                    action = other
        if action != here and left[here] > 0:  # whoever leaves for the last time searches first
            remaining = -1
            for way in range(way_starts[here] + 1, way_starts[here + 1]):
                remaining += left[ways[way]]
            if remaining <= 0:
                action = here
        walk[step] = action
        left[action] -= 1
        _look(starts, atoms, gains, looks, action)
        here = ends[action, 0] + ends[action, 1] - here


@njit(cache=True, nogil=True)
def _cost(starts, atoms, seconds, gains, looks, actions, count):
    """Sum of gain times middle of time over actions flown one after another from time 0; looks stay the same."""
    now = total = 0.0
    for n in range(count):
        action = actions[n]
        total += _look(starts, atoms, gains, looks, action) * (now + 0.5 * seconds[action])
        now += seconds[action]
    for n in range(count):
        for entry in range(starts[actions[n]], starts[actions[n] + 1]):
            looks[atoms[entry]] -= 1
    return total


@njit(cache=True, nogil=True)
def improve(starts, atoms, ends, seconds, gains, start, walk, reach, work):
    """Change the order of a walk while that brings gains forward: what is left of `work`, in looks.

    Between visits of one region lie closed walks, a search being the shortest: one is flown the other way round, or
    two that follow one another change places. Changes reach no further than so many actions.
    """
    n = len(walk)
    places = np.empty(n + 1, np.int64)
    places[0] = start
    for step in range(n):
        places[step + 1] = ends[walk[step], 0] + ends[walk[step], 1] - places[step]
    looks = np.zeros(len(gains), np.int64)
    trial = np.empty(reach, np.int64)
    changed = True
    while changed and work > 0:
        changed = False
        looks[:] = 0
        for i in range(n):
            here = places[i]
            limit = min(i + reach, n)
            for k in range(i + 1, limit + 1):
                if places[k] != here or work <= 0:
                    continue
                size = k - i
                spent = 0
                for m in range(i, k):
                    spent += starts[walk[m] + 1] - starts[walk[m]]
                best = _cost(starts, atoms, seconds, gains, looks, walk[i:k], size) * (1 - 1e-12) - 1e-12
                work -= spent
                cut = -1
                for j in range(i, k):  # j = i: the whole is turned round
                    if places[j] != here or (j == i and size < 3):
                        continue
                    _rearranged(walk, trial, i, j, k)
                    cost = _cost(starts, atoms, seconds, gains, looks, trial, size)
                    work -= spent
                    if cost < best:
                        best, cut = cost, j
                if cut >= 0:
                    _rearranged(walk, trial, i, cut, k)
                    walk[i:k] = trial[:size]
                    for m in range(i, k):
                        places[m + 1] = ends[walk[m], 0] + ends[walk[m], 1] - places[m]
                    changed = True
            _look(starts, atoms, gains, looks, walk[i])
    return work


@njit(cache=True, nogil=True)
def _rearranged(walk, trial, i, j, k):
    """walk[i:k] with its parts before and after j changed over; where j = i, from back to front."""
    if j == i:
        for m in range(k - i):
            trial[m] = walk[k - 1 - m]
    else:
        trial[: k - j] = walk[j:k]
        trial[k - j : k - i] = walk[i:j]
