"""Compiled time in flight: straight legs from rest to rest, in wind, over terrain.

`*pace` is `Pace.arrays()`: speed, accel, airspeed, east, north, climb, descent, heights (H, W), cell_m; a limit that
there is not is inf, and heights are empty where slopes do not matter. Frame and units: `sooner.motion.pace`.
"""

import math

import numpy as np
from numba import njit

STRAIGHT_RAD = 1e-6  # as `kinematics.STRAIGHT_RAD`
MAX_PIECES = 100_000  # of one leg


@njit(cache=True, nogil=True)
def height_at(x, y, heights, cell_m):
    """Height at a place: bilinear between the centres of cells, the border's beyond the map."""
    rows, cols = heights.shape
    col = min(max(x / cell_m, 0.0), cols - 1.0)
    row = min(max(rows - 1.0 - y / cell_m, 0.0), rows - 1.0)
    i, j = min(int(row), max(rows - 2, 0)), min(int(col), max(cols - 2, 0))
    below, right = min(i + 1, rows - 1), min(j + 1, cols - 1)
    down, along = row - i, col - j
    upper = heights[i, j] + along * (heights[i, right] - heights[i, j])
    lower = heights[below, j] + along * (heights[below, right] - heights[below, j])
    return upper + down * (lower - upper)


@njit(cache=True, nogil=True)
def heights_at(places, heights, cell_m):
    """(n,): heights at places (n, 2)."""
    found = np.empty(len(places))
    for k in range(len(places)):
        found[k] = height_at(places[k, 0], places[k, 1], heights, cell_m)
    return found


@njit(cache=True, nogil=True)
def cruise_mps(dx, dy, length, speed, airspeed, east, north):
    """Most speed over the ground along (dx, dy), metres a second; 0 where the wind is no weaker than the airspeed."""
    if airspeed == math.inf:
        return speed
    if east * east + north * north >= airspeed * airspeed:
        return 0.0
    along = (east * dx + north * dy) / length
    across = (east * dy - north * dx) / length
    return min(speed, along + math.sqrt(max(airspeed * airspeed - across * across, 0.0)))


@njit(cache=True, nogil=True)
def run(length, start, end, cap, accel):
    """Seconds speeding up, cruising and braking along a piece, and its greatest speed.

    start, end : squares of the speeds there, which the piece is long enough to join
    """
    if accel == math.inf:
        return 0.0, length / cap, 0.0, cap
    squares = start + end
    peak = min(math.sqrt(accel * length + squares / 2.0), cap)
    cruised = max(length - (2.0 * peak * peak - squares) / (2.0 * accel), 0.0) if peak >= cap else 0.0
    up = max((peak - math.sqrt(start)) / accel, 0.0)
    down = max((peak - math.sqrt(end)) / accel, 0.0)
    return up, cruised / peak, down, peak


@njit(cache=True, nogil=True)
def pieces(x0, y0, dx, dy, length, cruise, accel, climb, descent, heights, cell_m):
    """A leg over terrain in pieces of half a cell at most: (n,) most speed along each, (n + 1,) squared at its ends.

    Along a piece |dh / ds| v is no more than the climb or the descent allows. Forwards no speed is more than the one
    before lets it grow to, backwards no more than it can brake from.
    """
    n = max(math.ceil(min(2.0 * length / cell_m, MAX_PIECES)), 1)
    caps, squares = np.empty(n), np.empty(n + 1)
    metres = length / n
    before = height_at(x0, y0, heights, cell_m)
    squares[0] = 0.0
    for k in range(n):
        share = (k + 1.0) / n
        after = height_at(x0 + share * dx, y0 + share * dy, heights, cell_m)
        rise = after - before
        caps[k] = cruise
        if rise > 0.0:
            caps[k] = min(cruise, climb * metres / rise)
        elif rise < 0.0:
            caps[k] = min(cruise, descent * metres / -rise)
        squares[k] = min(squares[k], caps[k] * caps[k])
        squares[k + 1] = min(squares[k] + 2.0 * accel * metres, caps[k] * caps[k])
        before = after
    squares[n] = 0.0
    for k in range(n - 1, -1, -1):
        squares[k] = min(squares[k], squares[k + 1] + 2.0 * accel * metres)
    return caps, squares


@njit(cache=True, nogil=True)
def leg_s(x0, y0, x1, y1, speed, accel, airspeed, east, north, climb, descent, heights, cell_m):
    """Seconds along a straight leg from rest to rest; inf where it cannot be flown."""
    dx, dy = x1 - x0, y1 - y0
    length = math.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return 0.0
    cruise = cruise_mps(dx, dy, length, speed, airspeed, east, north)
    if cruise <= 0.0:
        return math.inf
    if heights.size == 0:
        up, along, down, _ = run(length, 0.0, 0.0, cruise, accel)
        return up + along + down
    caps, squares = pieces(x0, y0, dx, dy, length, cruise, accel, climb, descent, heights, cell_m)
    seconds = 0.0
    for k in range(len(caps)):
        up, along, down, _ = run(length / len(caps), squares[k], squares[k + 1], caps[k], accel)
        seconds += up + along + down
    return seconds


@njit(cache=True, nogil=True)
def legs_s(starts, ends, speed, accel, airspeed, east, north, climb, descent, heights, cell_m):
    """(n,): seconds along the legs from starts (n, 2) to ends (n, 2)."""
    found = np.empty(len(starts))
    for k in range(len(starts)):
        found[k] = leg_s(
            starts[k, 0], starts[k, 1], ends[k, 0], ends[k, 1],
            speed, accel, airspeed, east, north, climb, descent, heights, cell_m,
        )  # fmt: skip
    return found


@njit(cache=True, nogil=True)
def way_s(points, speed, accel, airspeed, east, north, climb, descent, heights, cell_m):
    """Seconds along a polyline (n, 2) from rest to rest, that stops where it turns and flies on through the rest.

    Over terrain it stops at those as well where that is quicker by a hair, as slopes are those of other pieces then.
    """
    seconds, first, last, parts = 0.0, 0, 0, 0.0
    dx, dy = 0.0, 0.0
    for k in range(1, len(points) + 1):
        if k < len(points):
            ex, ey = points[k, 0] - points[last, 0], points[k, 1] - points[last, 1]
            if ex == 0.0 and ey == 0.0:
                continue
            turns = last > first and math.atan2(abs(dx * ey - dy * ex), dx * ex + dy * ey) > STRAIGHT_RAD
        if k == len(points) or turns:
            whole = leg_s(
                points[first, 0], points[first, 1], points[last, 0], points[last, 1],
                speed, accel, airspeed, east, north, climb, descent, heights, cell_m,
            )  # fmt: skip
            seconds += min(whole, parts) if heights.size else whole
            first, parts = last, 0.0
        if k < len(points):
            if heights.size:
                parts += leg_s(
                    points[last, 0], points[last, 1], points[k, 0], points[k, 1],
                    speed, accel, airspeed, east, north, climb, descent, heights, cell_m,
                )  # fmt: skip
            last = k
            dx, dy = ex, ey
    return seconds


@njit(cache=True, nogil=True)
def halts(points, corners, speed, accel, airspeed, east, north, climb, descent, heights, cell_m):
    """Where a flight stops, as `way_s`: indices of `corners`, and of waypoints between two where it is quicker so."""
    found, count = np.empty(len(points), np.int64), 0
    for c in range(len(corners)):
        if c > 0 and heights.size:
            a, b, parts, last = corners[c - 1], corners[c], 0.0, corners[c - 1]
            for k in range(a + 1, b + 1):
                parts += leg_s(
                    points[last, 0], points[last, 1], points[k, 0], points[k, 1],
                    speed, accel, airspeed, east, north, climb, descent, heights, cell_m,
                )  # fmt: skip
                last = k
            whole = leg_s(
                points[a, 0], points[a, 1], points[b, 0], points[b, 1],
                speed, accel, airspeed, east, north, climb, descent, heights, cell_m,
            )  # fmt: skip
            for k in range(a + 1, b):
                apart = points[k, 0] != points[k - 1, 0] or points[k, 1] != points[k - 1, 1]
                if parts < whole and apart and (points[k, 0] != points[b, 0] or points[k, 1] != points[b, 1]):
                    found[count] = k
                    count += 1
        found[count] = corners[c]
        count += 1
    return found[:count]


@njit(cache=True, nogil=True)
def leg_knots(x0, y0, x1, y1, speed, accel, airspeed, east, north, climb, descent, heights, cell_m):
    """(m, 4): each stretch of constant acceleration along a leg: its seconds, metres, and speeds at both ends.

    The leg can be flown; `leg_s` adds up the same seconds.
    """
    dx, dy = x1 - x0, y1 - y0
    length = math.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return np.empty((0, 4))
    cruise = cruise_mps(dx, dy, length, speed, airspeed, east, north)
    if heights.size == 0:
        caps, squares = np.full(1, cruise), np.zeros(2)
    else:
        caps, squares = pieces(x0, y0, dx, dy, length, cruise, accel, climb, descent, heights, cell_m)
    metres = length / len(caps)
    found, m = np.empty((3 * len(caps), 4)), 0
    for k in range(len(caps)):
        up, along, down, peak = run(metres, squares[k], squares[k + 1], caps[k], accel)
        start, end = math.sqrt(squares[k]), math.sqrt(squares[k + 1])
        for seconds, before, after in ((up, start, peak), (along, peak, peak), (down, peak, end)):
            if seconds > 0.0:
                found[m] = seconds, seconds * (before + after) / 2.0, before, after
                m += 1
    return found[:m]
