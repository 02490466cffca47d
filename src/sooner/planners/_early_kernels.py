"""Compiled moves of annealing whole walks for early gains: plain arrays in, plain arrays out.

walk (C,) int64        actions, the first `n` of which are flown; a < R searches region a
looks (K,) int64       scratch, zero between calls
"""

import math

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def worth(starts, atoms, seconds, gains, limit_s, looks, walk, n):
    """What a walk collects, and the integral of that over the time allowed, each gain at the middle of its action."""
    last = gains.shape[1] - 1
    now = total = area = 0.0
    for step in range(n):
        action = walk[step]
        value = 0.0
        for entry in range(starts[action], starts[action + 1]):
            atom = atoms[entry]
            value += gains[atom, min(looks[atom], last)]
            looks[atom] += 1
        total += value
        area += value * (limit_s - now - 0.5 * seconds[action])
        now += seconds[action]
    looks[:] = 0
    return total, area


@njit(cache=True, nogil=True)
def _pick(draw, n):
    return min(int(draw * n), n - 1)


@njit(cache=True, nogil=True)
def _spliced(walk, n, i, k, middle, size, into):
    """walk[:i], then the middle, then walk[k:n]; -1 where there is no room."""
    count = n - (k - i) + size
    if count > len(into):
        return -1
    into[:i] = walk[:i]
    into[i : i + size] = middle[:size]
    into[i + size : count] = walk[k:n]
    return count


@njit(cache=True, nogil=True)
def _visit(places, n, region, draw, low, high):
    """A visit to a region drawn from places[low:high + 1]; -1 where there is none."""
    count = 0
    for step in range(low, min(high, n) + 1):
        if places[step] == region:
            count += 1
    if count == 0:
        return -1
    wanted = _pick(draw, count)
    for step in range(low, min(high, n) + 1):
        if places[step] == region:
            if wanted == 0:
                return step
            wanted -= 1
    return -1


@njit(cache=True, nogil=True)
def _reordered(walk, places, n, draws, into):
    """Two closed walks that follow one another change places, or one is flown from back to front; else -1."""
    i = _pick(draws[1], n)
    reach = n if draws[2] < 0.3 else min(n, i + 40)
    k = _visit(places, n, places[i], draws[3], i + 1, reach)
    if k < 0:
        return -1
    into[:n] = walk[:n]
    j = _visit(places, n, places[i], draws[4], i, k - 1)
    if j == i:
        for m in range(i, k):
            into[m] = walk[k - 1 - (m - i)]
    else:
        into[i : i + k - j] = walk[j:k]
        into[i + k - j : k] = walk[i:j]
    return n


@njit(cache=True, nogil=True)
def _searched(walk, places, n, draws, n_regions, middle, into):
    """A search more at a visit to its region, one less, or both: a search elsewhere; else -1."""
    i = _pick(draws[1], n + 1)
    if draws[2] < 0.5:
        middle[0] = places[i]
        return _spliced(walk, n, i, i, middle, 1, into)
    if i == n or walk[i] >= n_regions:
        return -1
    return _spliced(walk, n, i, i + 1, middle, 0, into)


@njit(cache=True, nogil=True)
def _detoured(way_starts, ways, ends, walk, places, n, draws, n_regions, middle, into):
    """There and back over an edge, with or without a search there, put in or left out; else -1."""
    i = _pick(draws[1], n + 1)
    here = places[i]
    if draws[2] < 0.5:
        count = way_starts[here + 1] - way_starts[here] - 1
        if count == 0:
            return -1
        action = ways[way_starts[here] + 1 + _pick(draws[3], count)]
        size = 3 if draws[4] < 0.6 else 2
        middle[0] = middle[size - 1] = action
        if size == 3:
            middle[1] = ends[action, 0] + ends[action, 1] - here
        return _spliced(walk, n, i, i, middle, size, into)
    if i == n or walk[i] < n_regions:
        return -1
    k = i + 1
    while k < n and walk[k] < n_regions:
        k += 1
    if k == n or walk[k] != walk[i]:
        return -1
    return _spliced(walk, n, i, k + 1, middle, 0, into)


@njit(cache=True, nogil=True)
def _straightened(nexts, ends, walk, places, n, draws, middle, into):
    """A stretch of the walk gives way to the quickest way between its ends; else -1."""
    i = _pick(draws[1], n)
    k = min(i + 2 + _pick(draws[2], 12), n)
    here, size = places[i], 0
    while here != places[k]:
        if size == len(middle):
            return -1
        action = nexts[here, places[k]]
        middle[size] = action
        size += 1
        here = ends[action, 0] + ends[action, 1] - here
    return _spliced(walk, n, i, k, middle, size, into)


@njit(cache=True, nogil=True)
def _visited(nexts, ends, walk, places, n, draws, n_regions, middle, into):
    """A detour the quickest way to some region for a search, and the quickest way on to a place soon after."""
    i = _pick(draws[1], n + 1)
    k = min(i + _pick(draws[2], 6), n)
    goal = _pick(draws[3], n_regions)
    here, size = places[i], 0
    for target in (goal, places[k]):
        while here != target:
            if size >= len(middle) - 1:
                return -1
            action = nexts[here, target]
            middle[size] = action
            size += 1
            here = ends[action, 0] + ends[action, 1] - here
        if target == goal:
            middle[size] = goal
            size += 1
            goal = -1
    return _spliced(walk, n, i, k, middle, size, into)


@njit(cache=True, nogil=True)
def _ended(way_starts, ways, walk, places, n, draws, into):
    """An edge more at the end, or the last action less; else -1."""
    into[:n] = walk[:n]
    if draws[1] < 0.5:
        return n - 1 if n > 1 else -1
    here = places[n]
    count = way_starts[here + 1] - way_starts[here] - 1
    if count == 0 or n == len(into):
        return -1
    into[n] = ways[way_starts[here] + 1 + _pick(draws[2], count)]
    return n + 1


@njit(cache=True, nogil=True)
def _moved(way_starts, ways, ends, nexts, free_end, walk, places, n, draws, middle, into):
    """One random change; -1 where what was drawn cannot be done."""
    n_regions = len(way_starts) - 1
    kind = draws[0]
    if kind < 0.35:
        return _reordered(walk, places, n, draws, into)
    if kind < 0.55:
        return _searched(walk, places, n, draws, n_regions, middle, into)
    if kind < 0.7:
        return _detoured(way_starts, ways, ends, walk, places, n, draws, n_regions, middle, into)
    if kind < 0.85:
        return _straightened(nexts, ends, walk, places, n, draws, middle, into)
    if kind < 0.95:
        return _visited(nexts, ends, walk, places, n, draws, n_regions, middle, into)
    return _ended(way_starts, ways, walk, places, n, draws, into) if free_end else -1


@njit(cache=True, nogil=True)
def _placed(ends, walk, n, places):
    for step in range(n):
        places[step + 1] = ends[walk[step], 0] + ends[walk[step], 1] - places[step]


@njit(cache=True, nogil=True)
def anneal_early(
    starts, atoms, way_starts, ways, ends, nexts, seconds, gains, limit_s, first, free_end,
    least, price, hot, cold, draws, walk, n,
):  # fmt: skip
    """Anneal a walk of n actions to the largest area of all that collect `least`; its length.

    A walk that collects less pays `price` for each unit. Each row of `draws` is a move of one to three changes.
    """
    capacity = len(walk)
    looks = np.zeros(len(gains), np.int64)
    middle = np.empty(64, np.int64)
    now, one, other = walk.copy(), np.empty(capacity, np.int64), np.empty(capacity, np.int64)
    places, trial = np.empty(capacity + 1, np.int64), np.empty(capacity + 1, np.int64)
    places[0] = trial[0] = first
    _placed(ends, now, n, places)
    total, area = worth(starts, atoms, seconds, gains, limit_s, looks, now, n)
    score = area - price * max(least - total, 0.0)
    best, kept, size = score, n, n
    moves = len(draws)
    for move in range(moves):
        temperature = hot * (cold / hot) ** (move / moves)
        parts = 1 + _pick(draws[move, 0], 3)
        source, target, count, at = now, one, size, places
        for part in range(parts):
            count = _moved(
                way_starts, ways, ends, nexts, free_end, source, at, count, draws[move, 2 + 5 * part : 7 + 5 * part],
                middle, target,
            )  # fmt: skip
            if count < 1:
                break
            source, target = target, (other if target is one else one)
            if part + 1 < parts:
                _placed(ends, source, count, trial)
                at = trial
        if count < 1:
            continue
        used = 0.0
        for step in range(count):
            used += seconds[source[step]]
        if used > limit_s:
            continue
        total, area = worth(starts, atoms, seconds, gains, limit_s, looks, source, count)
        new = area - price * max(least - total, 0.0)
        if new >= score or new - score > temperature * math.log(draws[move, 1] + 1e-300):
            score, size = new, count
            now[:count] = source[:count]
            _placed(ends, now, count, places)
            if score > best + 1e-9 * abs(best) and total >= least:
                best, kept = score, count
                walk[:count] = now[:count]
    return kept
