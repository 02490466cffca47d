"""Compiled annealing of routes of straight legs: plain arrays in, plain arrays out.

routes : points (R, M, 2) float64, metres kept to the centimetre, home first; counts (R,) int64; seconds (R,) float64
ground : (cell_m, height, width, east, north), the last two of the south-west cell's centre
sight : (radius, law, strength (N,)); walls : `Airspace.walls`
paces : limits of each route (R, 7), heights, cell_m, as `Pace.arrays()` has them
effort : (N,) float64, what all legs put on each cell; poc : (N,) float64
change : (8,) int64, what is proposed: points between i and j of a route give way to m new ones, and likewise of another
route (or -1): route, i, j, m, other, i, j, m; new, new_other : (M, 2) float64, those points
words : (2,) int64, as `_random_kernels`
"""

import math

import numpy as np
from numba import njit

from sooner.grid._airspace_kernels import clear
from sooner.motion._pace_kernels import leg_s
from sooner.planners._random_kernels import below, uniform
from sooner.sensors._swath_kernels import leg_effort

KEPT_M = 0.01  # as `airspace.KEPT_M`
ENOUGH = 30.0  # effort beyond which a cell pays nothing more
SHIFT, LANE, INSERT, REMOVE, SWAP, REVERSE, MOVE, TAILS = 0, 1, 2, 3, 4, 5, 6, 7
ROUTE, FROM, TO, NEW, OTHER, FROM2, TO2, NEW2 = 0, 1, 2, 3, 4, 5, 6, 7
LONGEST = 30  # points of a stretch that is reversed
NOTES = 1 << 16  # looks at cells that are noted in one change, more on larger maps; a change of more is not made


@njit(cache=True, nogil=True)
def flown_s(x0, y0, x1, y1, r, paces):
    """Seconds along a leg of route r."""
    limits, heights, cell_m = paces
    speed, accel, airspeed, east, north, climb, descent = limits[r]
    return leg_s(x0, y0, x1, y1, speed, accel, airspeed, east, north, climb, descent, heights, cell_m)


@njit(cache=True, nogil=True)
def missed(effort):
    """exp(-effort), without the trouble where it is one or nothing."""
    if effort <= 0.0:
        return 1.0
    return math.exp(-effort) if effort < ENOUGH else 0.0


@njit(cache=True, nogil=True)
def put(x0, y0, x1, y1, sign, effort, poc, ground, sight, cells, worth, at, top):
    """Add (sign 1) or take away (-1) the effort of a leg, and note it from `top` on; answers change of value and top.

    Top is -1 where there was no room to note it; then nothing is changed.
    """
    cell_m, height, width, east, north = ground
    radius, law, strength = sight
    found = leg_effort(
        x0 - east, y0 - north, x1 - east, y1 - north,
        cell_m, height, width, radius, law, strength, cells[top:], worth[top:], at[top:],
    )  # fmt: skip
    if found < 0:
        return 0.0, -1
    change = 0.0
    for k in range(top, top + found):
        cell = cells[k]
        before = effort[cell]
        worth[k] *= sign
        after = max(before + worth[k], 0.0)
        effort[cell] = after
        if poc[cell] > 0.0:
            change += poc[cell] * (missed(before) - missed(after))
    return change, top + found


@njit(cache=True, nogil=True)
def unput(effort, cells, worth, begin, top):
    """Take back what was noted from `begin` to `top`."""
    for k in range(begin, top):
        effort[cells[k]] = max(effort[cells[k]] - worth[k], 0.0)


@njit(cache=True, nogil=True)
def load(points, counts, seconds, effort, poc, ground, sight, paces, cells, worth, at):
    """Work out effort and seconds anew; answers the value."""
    effort[:] = 0.0
    value = 0.0
    for r in range(points.shape[0]):
        seconds[r] = 0.0
        for k in range(max(counts[r] - 1, 1)):
            j = min(k + 1, counts[r] - 1)
            x0, y0, x1, y1 = points[r, k, 0], points[r, k, 1], points[r, j, 0], points[r, j, 1]
            seconds[r] += flown_s(x0, y0, x1, y1, r, paces)
            value += put(x0, y0, x1, y1, 1.0, effort, poc, ground, sight, cells, worth, at, 0)[0]
    return value


@njit(cache=True, nogil=True)
def longer_by(points, count, r, i, j, new, m, paces):
    """Seconds by which route r grows where `new[:m]` come between i and j."""
    longer = 0.0
    for k in range(i, min(j, count - 1)):
        longer -= flown_s(points[r, k, 0], points[r, k, 1], points[r, k + 1, 0], points[r, k + 1, 1], r, paces)
    x, y = points[r, i, 0], points[r, i, 1]
    for k in range(m + 1):
        if k == m and j == count:
            break
        nx, ny = (new[k, 0], new[k, 1]) if k < m else (points[r, j, 0], points[r, j, 1])
        longer += flown_s(x, y, nx, ny, r, paces)
        x, y = nx, ny
    return longer


@njit(cache=True, nogil=True)
def all_clear(points, count, r, i, j, new, m, walls):
    """Whether no leg meets a wall where `new[:m]` come between i and j of route r."""
    x, y = points[r, i, 0], points[r, i, 1]
    for k in range(m + 1):
        if k == m and j == count:
            break
        nx, ny = (new[k, 0], new[k, 1]) if k < m else (points[r, j, 0], points[r, j, 1])
        if not clear(x, y, nx, ny, walls):
            return False
        x, y = nx, ny
    return True


@njit(cache=True, nogil=True)
def spliced(points, counts, r, i, j, new, m):
    """Put `new[:m]` in place of the points between i and j of route r."""
    count = counts[r]
    more = m - (j - i - 1)
    if more > 0:
        for k in range(count - 1, j - 1, -1):
            points[r, k + more, 0], points[r, k + more, 1] = points[r, k, 0], points[r, k, 1]
    elif more < 0:
        for k in range(j, count):
            points[r, k + more, 0], points[r, k + more, 1] = points[r, k, 0], points[r, k, 1]
    for k in range(m):
        points[r, i + 1 + k, 0], points[r, i + 1 + k, 1] = new[k, 0], new[k, 1]
    counts[r] = count + more


@njit(cache=True, nogil=True)
def replace(
    points, counts, seconds, effort, r, i, j, new, m, limit, poc, ground, sight, paces, walls, cells, worth, at, top
):
    """Put `new[:m]` in place of the points between i and j of route r; j = counts[r] stands for the open end.

    Returns change of value, of seconds, and the new top of the notes; top -1, and nothing changed, where the route had
    no room, came under two points, took longer than `limit`, or a leg met a wall.
    """
    count = counts[r]
    after = count + m - (j - i - 1)
    if after > points.shape[1] or after < 2:
        return 0.0, 0.0, -1
    longer = longer_by(points, count, r, i, j, new, m, paces)
    if not seconds[r] + longer <= limit or not all_clear(points, count, r, i, j, new, m, walls):
        return 0.0, 0.0, -1
    begin, value = top, 0.0
    x, y = points[r, i, 0], points[r, i, 1]
    alone = 1 if count == 1 else 0  # it stood at home and looked around
    for k in range(i, min(j, count - 1) + alone):
        b = min(k + 1, count - 1)
        change, noted = put(
            points[r, k, 0], points[r, k, 1], points[r, b, 0], points[r, b, 1],
            -1.0, effort, poc, ground, sight, cells, worth, at, top,
        )  # fmt: skip
        if noted < 0:
            unput(effort, cells, worth, begin, top)
            return 0.0, 0.0, -1
        value, top = value + change, noted
    for k in range(m + 1):
        if k == m and j == count:
            break
        nx, ny = (new[k, 0], new[k, 1]) if k < m else (points[r, j, 0], points[r, j, 1])
        change, noted = put(x, y, nx, ny, 1.0, effort, poc, ground, sight, cells, worth, at, top)
        if noted < 0:
            unput(effort, cells, worth, begin, top)
            return 0.0, 0.0, -1
        value, top = value + change, noted
        x, y = nx, ny
    spliced(points, counts, r, i, j, new, m)
    seconds[r] += longer
    return value, longer, top


@njit(cache=True, nogil=True)
def kept(x):
    """A coordinate as plans keep it."""
    return round(x / KEPT_M) * KEPT_M


@njit(cache=True, nogil=True)
def normal(words):
    """A number of mean 0 and variance 1, by Box and Muller."""
    return math.sqrt(-2.0 * math.log(1.0 - uniform(words))) * math.cos(2.0 * math.pi * uniform(words))


@njit(cache=True, nogil=True)
def stretch(words, count, end, longest):
    """First and number of some consecutive points that may change: none is home, nor where the route must end."""
    free = count - 1 - (1 if end else 0)
    if free < 1:
        return 0, 0
    first = 1 + below(words, free)
    return first, min(1 + below(words, longest), free - first + 1)


@njit(cache=True, nogil=True)
def rich_place(effort, poc, pays, ground, words):
    """A place near to the richest of a few cells drawn at random."""
    cell_m, height, width, east, north = ground
    best, worth = pays[below(words, len(pays))], -1.0
    for _ in range(4):
        cell = pays[below(words, len(pays))]
        left = poc[cell] * math.exp(-effort[cell])
        if left > worth:
            best, worth = cell, left
    x = east + (best % width + uniform(words) - 0.5) * cell_m
    y = north + (height - 1 - best // width + uniform(words) - 0.5) * cell_m
    return kept(x), kept(y)


@njit(cache=True, nogil=True)
def nearest_leg(points, counts, ends, x, y, skip, words):
    """Route and point after which a place lies least out of the way; some legs are skipped at random, for variety."""
    route, after, least = 0, 0, math.inf
    for r in range(points.shape[0]):
        for k in range(counts[r] - 1 + (0 if ends[r] else 1)):
            if uniform(words) < skip:
                continue
            detour = math.hypot(points[r, k, 0] - x, points[r, k, 1] - y)
            if k + 1 < counts[r]:
                detour += math.hypot(points[r, k + 1, 0] - x, points[r, k + 1, 1] - y)
                detour -= math.hypot(points[r, k + 1, 0] - points[r, k, 0], points[r, k + 1, 1] - points[r, k, 1])
            if detour < least:
                route, after, least = r, k, detour
    return route, after


@njit(cache=True, nogil=True)
def propose_shift(points, counts, ends, r, lane, reach, change, new, words):
    """Shift a point, or the two or three of a lane together: anywhere, or along the leg before or after it."""
    k, length = stretch(words, counts[r], ends[r], 3)
    if length == 0:
        return False
    length = max(length, min(2, counts[r] - 1 - (1 if ends[r] else 0) - k + 1)) if lane else 1
    change[FROM], change[TO], change[NEW] = k - 1, k + length, length
    if lane and uniform(words) < 0.5:
        a = min(k if uniform(words) < 0.5 else k + length, counts[r] - 1)
        east, north = points[r, a, 0] - points[r, a - 1, 0], points[r, a, 1] - points[r, a - 1, 1]
        far = math.hypot(east, north)
        if far == 0.0:
            return False
        by = 2.0 * reach * normal(words) / far
        east, north = by * east, by * north
    else:
        east, north = reach * normal(words), reach * normal(words)
    for b in range(length):
        new[b, 0], new[b, 1] = kept(points[r, k + b, 0] + east), kept(points[r, k + b, 1] + north)
    return True


@njit(cache=True, nogil=True)
def propose_insert(points, counts, ends, swap, reach, effort, poc, pays, ground, change, new, words):
    """A point where much is left to find, or beside a leg; to swap gives up a few elsewhere on the same route."""
    if uniform(words) < 0.6:
        new[0, 0], new[0, 1] = rich_place(effort, poc, pays, ground, words)
        change[ROUTE], change[FROM] = nearest_leg(points, counts, ends, new[0, 0], new[0, 1], 0.2, words)
    else:
        r = change[ROUTE]
        i = below(words, counts[r] - 1) if counts[r] > 1 else 0
        k, share = min(i + 1, counts[r] - 1), uniform(words)
        change[FROM] = i
        for axis in range(2):
            on = points[r, i, axis] + share * (points[r, k, axis] - points[r, i, axis])
            new[0, axis] = kept(on + reach * normal(words))
    r, i = change[ROUTE], change[FROM]
    change[TO], change[NEW] = i + 1, 1
    if not swap:
        return True
    k, length = stretch(words, counts[r], ends[r], 2)
    if length == 0 or k - 1 <= i <= k + length - 1:
        return False
    change[OTHER], change[FROM2], change[TO2], change[NEW2] = r, k - 1, k + length, 0
    return True


@njit(cache=True, nogil=True)
def propose_reverse(points, counts, ends, r, change, new, words):
    """Fly a stretch the other way round."""
    k, length = stretch(words, counts[r], ends[r], LONGEST)
    if length < 2:
        return False
    change[FROM], change[TO], change[NEW] = k - 1, k + length, length
    for b in range(length):
        new[b, 0], new[b, 1] = points[r, k + length - 1 - b, 0], points[r, k + length - 1 - b, 1]
    return True


@njit(cache=True, nogil=True)
def propose_move(points, counts, ends, r, change, new, words):
    """Take a stretch out and put it in elsewhere, on any route, either way round."""
    k, length = stretch(words, counts[r], ends[r], 6)
    if length == 0:
        return False
    a = k + below(words, length)
    other, i = nearest_leg(points, counts, ends, points[r, a, 0], points[r, a, 1], 0.5, words)
    if other == r and k - 1 <= i <= k + length - 1:
        return False
    turned = uniform(words) < 0.5
    for b in range(length):
        c = k + (length - 1 - b if turned else b)
        new[b, 0], new[b, 1] = points[r, c, 0], points[r, c, 1]
    change[ROUTE], change[FROM], change[TO], change[NEW] = other, i, i + 1, length
    change[OTHER], change[FROM2], change[TO2], change[NEW2] = r, k - 1, k + length, 0
    return True


@njit(cache=True, nogil=True)
def propose_tails(points, counts, ends, r, change, new, new_other, words):
    """Two routes exchange all that they fly from some place on, the second at a place near to the first's."""
    other = below(words, points.shape[0])
    if other == r or ends[r] != ends[other] or counts[r] < 3 or counts[other] < 3:
        return False
    last, last2 = counts[r] - 1, counts[other] - 1
    for axis in range(2):
        if ends[r] and points[r, last, axis] != points[other, last2, axis]:
            return False
    i, i2, least = below(words, last), 0, math.inf
    for k in range(last2):
        far = math.hypot(points[other, k, 0] - points[r, i, 0], points[other, k, 1] - points[r, i, 1])
        if far < least and uniform(words) > 0.3:
            i2, least = k, far
    j, j2 = last + (0 if ends[r] else 1), last2 + (0 if ends[other] else 1)
    m, m2 = j2 - i2 - 1, j - i - 1
    for b in range(m):
        new[b, 0], new[b, 1] = points[other, i2 + 1 + b, 0], points[other, i2 + 1 + b, 1]
    for b in range(m2):
        new_other[b, 0], new_other[b, 1] = points[r, i + 1 + b, 0], points[r, i + 1 + b, 1]
    change[FROM], change[TO], change[NEW] = i, j, m
    change[OTHER], change[FROM2], change[TO2], change[NEW2] = other, i2, j2, m2
    return True


@njit(cache=True, nogil=True)
def propose(points, counts, ends, kind, reach, effort, poc, pays, ground, change, new, new_other, words):
    """One change of a kind to a route drawn at random; False where there is none."""
    r = below(words, points.shape[0])
    change[ROUTE], change[OTHER] = r, -1
    if kind in (SHIFT, LANE):
        return propose_shift(points, counts, ends, r, kind == LANE, reach, change, new, words)
    if kind in (INSERT, SWAP):
        return propose_insert(points, counts, ends, kind == SWAP, reach, effort, poc, pays, ground, change, new, words)
    if kind == REMOVE:
        k, length = stretch(words, counts[r], ends[r], 3)
        change[FROM], change[TO], change[NEW] = k - 1, k + length, 0
        return length > 0
    if kind == REVERSE:
        return propose_reverse(points, counts, ends, r, change, new, words)
    if kind == MOVE:
        return propose_move(points, counts, ends, r, change, new, words)
    return propose_tails(points, counts, ends, r, change, new, new_other, words)


@njit(cache=True, nogil=True)
def taken(points, r, i, j, kept_points):
    """Keep the points between i and j of a route, to put them back; answers how many."""
    for k in range(i + 1, j):
        kept_points[k - i - 1, 0], kept_points[k - i - 1, 1] = points[r, k, 0], points[r, k, 1]
    return j - i - 1


@njit(cache=True, nogil=True)
def anneal(
    points, counts, seconds, effort, value, best_points, best_counts, best_value,
    budgets, ends, pays, steps, temperature, price, reach, weights, words, poc, ground, sight, paces, walls,
):  # fmt: skip
    """Change routes `steps` times at one temperature; answers value and best value. Effort and routes change in place.

    The other route's change goes first, as it frees time, unless tails are exchanged; both are undone in reverse order.

    ends : (R,) bool           whether the last point is where the route must end
    pays : (P,) int64          cells worth flying to
    price : float              value that a second is worth, so that time is not wasted
    reach : float              metres by which points are shifted
    weights : (8,) float       how often each kind of change is tried, summed up
    """
    size, room = effort.shape[0], points.shape[1]
    notes = 4 * size + NOTES
    cells, worth, at = np.empty(notes, np.int64), np.empty(notes), np.empty(notes)
    new, new_other, old, old_other = np.empty((4, room, 2))
    change = np.zeros(8, np.int64)
    for _ in range(steps):
        kind, drawn = 0, uniform(words) * weights[-1]
        while weights[kind] < drawn:
            kind += 1
        if not propose(points, counts, ends, kind, reach, effort, poc, pays, ground, change, new, new_other, words):
            continue
        r, i, j, m, other, i2, j2, m2 = change
        won2 = late2 = 0.0
        gone2 = top = 0
        if other >= 0:
            gone2 = taken(points, other, i2, j2, old_other)
            won2, late2, top = replace(
                points, counts, seconds, effort, other, i2, j2, new_other, m2,
                budgets[other], poc, ground, sight, paces, walls, cells, worth, at, 0,
            )  # fmt: skip
            if top < 0:
                continue
            if r == other and i > i2:
                i, j = i - gone2 + m2, j - gone2 + m2
        first = top
        gone = taken(points, r, i, j, old)
        won, late, top = replace(
            points, counts, seconds, effort, r, i, j, new, m,
            budgets[r], poc, ground, sight, paces, walls, cells, worth, at, first,
        )  # fmt: skip
        gained = won + won2 - price * (late + late2)
        if top >= 0 and (gained >= 0.0 or uniform(words) < math.exp(gained / temperature)):
            value += won + won2
            if value > best_value + 1e-12:
                best_value = value
                best_counts[:] = counts
                for a in range(points.shape[0]):
                    best_points[a, : counts[a]] = points[a, : counts[a]]
            continue
        unput(effort, cells, worth, 0, max(top, first))
        if top >= 0:
            spliced(points, counts, r, i, i + m + 1, old, gone)
            seconds[r] -= late
        if other >= 0:
            spliced(points, counts, other, i2, i2 + m2 + 1, old_other, gone2)
            seconds[other] -= late2
    return value, best_value
