"""Compiled sweep of a disc along a polyline over square cells: plain arrays in, plain arrays out.

Lengths are in cells; places are (row, column) floats, whole at the centres of cells.
"""

import math

import numpy as np
from numba import njit

TOUCH = 1e-9  # cells; farther than the radius by no more than this is still within it
CROSS = 1e-6  # cells; a leg that is over a cell for less than this does not see it
AGAIN = 1e-6  # cells; whoever is out of view for less than this is not seen anew


@njit(cache=True, nogil=True)
def _spans(places, radius, height, width):
    """Columns that each leg may see, row by row: (m, 4) int64 of row, first column, last column, leg."""
    legs = max(places.shape[0] - 1, 1)
    reach = max(radius, 0.75) + 2 * TOUCH
    total = 0
    for k in range(legs):
        a, b = places[k, 0], places[min(k + 1, places.shape[0] - 1), 0]
        top = max(math.ceil(min(a, b) - reach), 0)
        total += max(min(math.floor(max(a, b) + reach), height - 1) - top + 1, 0)
    spans = np.empty((total, 4), np.int64)
    n = 0
    for k in range(legs):
        j = min(k + 1, places.shape[0] - 1)
        row_a, col_a, fall, run = places[k, 0], places[k, 1], places[j, 0] - places[k, 0], places[j, 1] - places[k, 1]
        top = max(math.ceil(min(row_a, row_a + fall) - reach), 0)
        bottom = min(math.floor(max(row_a, row_a + fall) + reach), height - 1)
        for row in range(top, bottom + 1):
            enter, leave = 0.0, 1.0
            if abs(fall) > TOUCH:
                enter, leave = (row - reach - row_a) / fall, (row + reach - row_a) / fall
                if enter > leave:
                    enter, leave = leave, enter
                enter, leave = min(max(enter, 0.0), 1.0), max(min(leave, 1.0), 0.0)
            here, there = col_a + enter * run, col_a + leave * run
            west = max(math.ceil(min(here, there) - reach), 0)
            east = min(math.floor(max(here, there) + reach), width - 1)
            if west <= east:
                spans[n, 0], spans[n, 1], spans[n, 2], spans[n, 3] = row, west, east, k
                n += 1
    return spans[:n]


@njit(cache=True, nogil=True)
def _over(down, right, fall, run, length):
    """Metres along a leg at which it comes over the square around (0, 0), begun at (-down, -right); inf if never.

    (fall, run) : unit vector; a square holds its north and west edge (TOUCH beyond them), not its others.
    """
    enter, leave = 0.0, length
    for axis in range(2):
        at, slope = (-down, fall) if axis == 0 else (-right, run)
        low, high = -0.5 - TOUCH, 0.5 - TOUCH
        if abs(slope) < 1e-15:
            if not low <= at < high:
                return np.inf
        else:
            t0, t1 = (low - at) / slope, (high - at) / slope
            enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
    begun = -0.5 - TOUCH <= -down < 0.5 - TOUCH and -0.5 - TOUCH <= -right < 0.5 - TOUCH
    if begun:
        return 0.0
    return enter if leave - enter > CROSS else np.inf


@njit(cache=True, nogil=True)
def _first(down, right, fall, run, length, radius):
    """Cells along a leg at which a place comes within the radius; inf if it never does.

    (down, right) : the place, from the leg's start; (fall, run) : the leg's unit vector.
    """
    along = down * fall + right * run
    across = down * run - right * fall
    past = along - min(max(along, 0.0), length)
    if across * across + past * past > (radius + TOUCH) ** 2:
        return np.inf
    half = math.sqrt(max(radius * radius - across * across, 0.0))
    return min(max(along - half, 0.0), length)


@njit(cache=True, nogil=True)
def _slots(spans, width):
    """Slot of each span's first cell less that cell, so that spans share the slots of their cells; how many in all.

    The columns that legs may see in each row are sorted and joined to stretches: costs what the covered cells cost,
    not the map.
    """
    order = np.argsort(spans[:, 0] * width + spans[:, 1])
    offset = np.empty(spans.shape[0], np.int64)
    total, row, reach, shift = 0, -1, -1, 0
    for q in range(order.shape[0]):
        span = order[q]
        if spans[span, 0] != row or spans[span, 1] > reach + 1:
            row, reach = spans[span, 0], spans[span, 1] - 1
            shift = total - (row * width + spans[span, 1])
        total += max(spans[span, 2] - reach, 0)
        reach = max(reach, spans[span, 2])
        offset[span] = shift
    return offset, total


@njit(cache=True, nogil=True)
def _leg(places, leg):
    """Start, unit vector and length of a leg, in cells."""
    j = min(leg + 1, places.shape[0] - 1)
    fall, run = places[j, 0] - places[leg, 0], places[j, 1] - places[leg, 1]
    length = math.hypot(fall, run)
    fall, run = (fall / length, run / length) if length > 0 else (0.0, 1.0)
    return places[leg, 0], places[leg, 1], fall, run, length


@njit(cache=True, nogil=True)
def sweep(places, radius, height, width, passable):
    """Cells within `radius` of a polyline, and how far along it each is first seen.

    places : (n, 2) float, n >= 1; passable : (N,) bool, or (0,) for all cells
    returns cells (m,) int64, ascending, and flown (m,) float in cells.
    """
    spans = _spans(places, radius, height, width)
    offset, total = _slots(spans, width)
    seen = np.full(total, np.inf)
    numbers = np.empty(total, np.int64)
    flown, leg = 0.0, -1
    row_a, col_a, fall, run, length = 0.0, 0.0, 0.0, 1.0, 0.0
    for span in range(spans.shape[0]):  # these come leg by leg
        while leg < spans[span, 3]:
            leg += 1
            flown += length
            row_a, col_a, fall, run, length = _leg(places, leg)
        for col in range(spans[span, 1], spans[span, 2] + 1):
            down, right = spans[span, 0] - row_a, col - col_a
            cell = spans[span, 0] * width + col
            slot = cell + offset[span]
            numbers[slot] = cell
            if seen[slot] <= flown:
                continue
            at = _first(down, right, fall, run, length, radius)
            if radius < 0.75:
                at = min(at, _over(down, right, fall, run, length))
            if flown + at < seen[slot]:
                seen[slot] = flown + at
    n = 0
    for slot in range(total):
        if seen[slot] < np.inf and (passable.shape[0] == 0 or passable[numbers[slot]]):
            numbers[n], seen[n] = numbers[slot], seen[slot]
            n += 1
    return numbers[:n].copy(), seen[:n].copy()


@njit(cache=True, nogil=True)
def _stays(down, right, fall, run, length, radius):
    """Cells along a leg between which a place is in view: (inf, inf) if it never is; parameters as `_first`.

    Where the radius is small, the cell below is in view as well: both stays are of one leg, and are joined.
    """
    begins = _first(down, right, fall, run, length, radius)
    ends = np.inf
    if begins < np.inf:  # flown backwards from the leg's end, it comes into view where it went out of it
        ends = length - _first(down - length * fall, right - length * run, -fall, -run, length, radius)
    if radius < 0.75:
        over = _over(down, right, fall, run, length)
        if over < np.inf:
            gone = length - _over(down - length * fall, right - length * run, -fall, -run, length)
            gone = over if gone == -np.inf else gone
            begins, ends = min(begins, over), (max(ends, gone) if ends < np.inf else gone)
    return begins, ends


@njit(cache=True, nogil=True)
def sweep_passes(places, radius, height, width, passable):
    """Every time that a cell comes into view along a polyline, and when it goes out of it again.

    Parameters as `sweep`; returns cells (m,) int64, ascending, each cell's passes in order, and the cells flown when
    it comes and when it goes, (m,) float each.
    """
    spans = _spans(places, radius, height, width)
    offset, total = _slots(spans, width)
    numbers = np.full(total, -1, np.int64)
    room = np.zeros(total + 1, np.int64)
    gone = np.full(total, -np.inf)
    comes, goes = np.empty(0), np.empty(0)
    for filling in range(2):  # first how many passes each cell has, then which
        gone[:] = -np.inf
        flown, leg = 0.0, -1
        row_a, col_a, fall, run, length = 0.0, 0.0, 0.0, 1.0, 0.0
        for span in range(spans.shape[0]):
            while leg < spans[span, 3]:
                leg += 1
                flown += length
                row_a, col_a, fall, run, length = _leg(places, leg)
            for col in range(spans[span, 1], spans[span, 2] + 1):
                cell = spans[span, 0] * width + col
                if passable.shape[0] > 0 and not passable[cell]:
                    continue
                begins, ends = _stays(spans[span, 0] - row_a, col - col_a, fall, run, length, radius)
                if begins == np.inf:
                    continue
                slot = cell + offset[span]
                begins, ends = flown + begins, flown + ends
                if begins > gone[slot] + AGAIN:
                    numbers[slot] = cell
                    room[slot] += 1
                    if filling:
                        comes[room[slot] - 1] = begins
                if filling:
                    goes[room[slot] - 1] = max(ends, gone[slot])
                gone[slot] = max(ends, gone[slot])
        if not filling:
            n = 0
            for slot in range(total):
                n, room[slot] = n + room[slot], n
            room[total] = n
            comes, goes = np.empty(n), np.empty(n)
    cells = np.empty(room[total], np.int64)
    first = 0
    for slot in range(total):  # room[slot] is now where the cell's passes end
        for n in range(first, room[slot]):
            cells[n] = numbers[slot]
        first = room[slot]
    return cells, comes, goes
