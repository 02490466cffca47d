"""Compiled sweep of a disc along a polyline over square cells: plain arrays in, plain arrays out.

Lengths are in cells; places are (row, column) floats, whole at the centres of cells.
"""

import math

import numpy as np
from numba import njit

TOUCH = 1e-9  # cells; farther than the radius by no more than this is still within it
CROSS = 1e-6  # cells; a leg that is over a cell for less than this does not see it


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
def sweep(places, radius, height, width, passable):
    """Cells within `radius` of a polyline, and how far along it each is first seen.

    places : (n, 2) float, n >= 1; passable : (N,) bool, or (0,) for all cells
    returns cells (m,) int64, ascending, and flown (m,) float in cells. Costs what the covered cells cost, not the map:
    the legs' columns in each row are sorted and joined to stretches, and only their cells are looked at.
    """
    spans = _spans(places, radius, height, width)
    order = np.argsort(spans[:, 0] * width + spans[:, 1])
    offset = np.empty(spans.shape[0], np.int64)  # of the stretch's slots, minus its first cell
    total, row, reach, shift = 0, -1, -1, 0
    for q in range(order.shape[0]):
        span = order[q]
        if spans[span, 0] != row or spans[span, 1] > reach + 1:
            row, reach = spans[span, 0], spans[span, 1] - 1
            shift = total - (row * width + spans[span, 1])
        total += max(spans[span, 2] - reach, 0)
        reach = max(reach, spans[span, 2])
        offset[span] = shift
    seen = np.full(total, np.inf)
    numbers = np.empty(total, np.int64)
    flown, leg = 0.0, -1
    row_a, col_a, fall, run, length = 0.0, 0.0, 0.0, 1.0, 0.0
    for span in range(spans.shape[0]):  # these come leg by leg
        while leg < spans[span, 3]:
            leg += 1
            flown += length
            j = min(leg + 1, places.shape[0] - 1)
            row_a, col_a = places[leg, 0], places[leg, 1]
            fall, run = places[j, 0] - row_a, places[j, 1] - col_a
            length = math.hypot(fall, run)
            fall, run = (fall / length, run / length) if length > 0 else (0.0, 1.0)
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
