"""Compiled reachability over directed steps: plain arrays in, plain arrays out.

A state is cell * D + slot: the searcher stands on `cell` and came from `neighbours[cell, slot]`.
"""

import numpy as np
from numba import njit

SLACK = 48  # bits kept of "can it end there after least + j steps"
PERIOD = 24  # from then on the last 24 repeat: loops of 4, 6, 8, 12 and 24 cells all return in step


@njit(cache=True, nogil=True)
def slot_of(neighbours, cell, other):
    """Slot of `other` among the neighbours of `cell`; -1 where it is none."""
    for slot in range(neighbours.shape[1]):
        if neighbours[cell, slot] == other:
            return slot
    return -1


@njit(cache=True, nogil=True)
def steps_to_end(neighbours, end):
    """For every state: fewest steps to `end` without turning back, and which larger numbers of steps also do.

    Returns least (N * D,) int32, -1 where there is no way, and also (N * D,) int64: bit j says that exactly
    least + j steps are possible. Each pair of state and bit is visited once: O(N D^2 SLACK).
    """
    n_cells, n_slots = neighbours.shape
    least = np.full(n_cells * n_slots, -1, np.int32)
    also = np.zeros(n_cells * n_slots, np.int64)
    frontier = np.empty(n_cells * n_slots, np.int32)
    count = 0
    for slot in range(n_slots):
        if neighbours[end, slot] >= 0:
            least[end * n_slots + slot] = 0
            also[end * n_slots + slot] = 1
            frontier[count] = end * n_slots + slot
            count += 1
    following = np.empty(n_cells * n_slots, np.int32)
    steps = 0
    while count > 0:
        steps += 1
        found = 0
        for n in range(count):
            cell = frontier[n] // n_slots
            before = neighbours[cell, frontier[n] % n_slots]
            for slot in range(n_slots):
                if neighbours[before, slot] < 0 or neighbours[before, slot] == cell:
                    continue
                state = before * n_slots + slot
                if least[state] < 0:
                    least[state] = steps
                slack = steps - least[state]
                if slack >= SLACK or (also[state] >> slack) & 1:
                    continue
                also[state] |= np.int64(1) << slack
                following[found] = state
                found += 1
        frontier, following = following, frontier
        count = found
    return least, also


@njit(cache=True, nogil=True)
def steps_until_stuck(neighbours):
    """For every state: the most further steps without turning back, (N * D,) int32; 2^31 - 1 where it never ends."""
    n_cells, n_slots = neighbours.shape
    ways = np.zeros(n_cells, np.int32)
    for cell in range(n_cells):
        for slot in range(n_slots):
            if neighbours[cell, slot] >= 0:
                ways[cell] += 1
    forever = np.int32(2147483647)
    most = np.full(n_cells * n_slots, forever, np.int32)
    left = np.zeros(n_cells * n_slots, np.int32)
    queue = np.empty(n_cells * n_slots, np.int32)
    tail = 0
    for cell in range(n_cells):
        for slot in range(n_slots):
            if neighbours[cell, slot] < 0:
                continue
            state = cell * n_slots + slot
            left[state] = ways[cell] - 1
            if left[state] == 0:
                most[state] = 0
                queue[tail] = state
                tail += 1
    head = 0
    while head < tail:
        here = queue[head]
        head += 1
        cell = here // n_slots
        before = neighbours[cell, here % n_slots]
        for slot in range(n_slots):
            if neighbours[before, slot] < 0 or neighbours[before, slot] == cell:
                continue
            state = before * n_slots + slot
            left[state] -= 1
            if left[state] == 0:  # its longest way on went through the state that fell last
                most[state] = most[here] + 1
                queue[tail] = state
                tail += 1
    return most


@njit(cache=True, nogil=True)
def can_go_on(neighbours, fixed_wing, has_end, to_end, least, also, most, cell, came_from, steps):
    """Whether a searcher on `cell`, having come from `came_from` (-1: heading free), can fly exactly `steps` more
    steps and keep every rule. The arrays are those of `sooner.problem.reach.Reach`.
    """
    if not fixed_wing:
        return (not has_end) or 0 <= to_end[cell] <= steps
    if steps == 0:
        return (not has_end) or to_end[cell] == 0
    if came_from >= 0:
        slot = slot_of(neighbours, cell, came_from)
        return _wing_can_go_on(neighbours, has_end, least, also, most, cell, slot, steps)
    for first in range(neighbours.shape[1]):
        other = neighbours[cell, first]
        if other >= 0:
            slot = slot_of(neighbours, other, cell)
            if _wing_can_go_on(neighbours, has_end, least, also, most, other, slot, steps - 1):
                return True
    return False


@njit(cache=True, nogil=True)
def _wing_can_go_on(neighbours, has_end, least, also, most, cell, slot, steps):
    state = cell * neighbours.shape[1] + slot
    if not has_end:
        return steps <= most[state]
    if least[state] < 0 or steps < least[state]:
        return False
    slack = steps - least[state]
    if slack >= SLACK:
        slack = SLACK - PERIOD + (slack - SLACK) % PERIOD
    return (also[state] >> slack) & 1 == 1
