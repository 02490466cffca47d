"""Compiled effort of straight legs on square cells: plain arrays in, plain arrays out.

Lengths are in metres; places are metres east and north of the south-west cell's centre, row 0 lies north.
laws : SEEN (whoever is in view is seen), EVEN (a rate for each metre in view), CUBE (falling with distance cubed),
EDGED (seen, but for an edge across which ever less of the ground is)
"""

import math

import numpy as np
from numba import njit

SEEN, EVEN, CUBE, EDGED = 0, 1, 2, 3
SURE = 40.0  # effort of a look that detects for certain: exp(-40) is nothing
TOUCH_M = 1e-6  # farther than the radius by no more than this is still in view
NEAREST = 1e-3  # share of the radius nearer than which the inverse cube does not grow any more


@njit(cache=True, nogil=True)
def edge_effort(aside2, off2, along, length, inner, radius, edge):
    """Effort at the edge of what is in view: of a whole pass -ln(1 - f), of a part of it that part, so that a leg cut
    in two is worth no more; and no more than the share f in view where the leg is nearest.
    """
    half = math.sqrt(radius * radius - aside2)
    part = max(min(along + half, length) - max(along - half, 0.0), 0.0) / (2.0 * half)
    here = -math.log(max(1.0 - (radius - math.sqrt(off2)) / edge, 1e-17))
    if aside2 <= inner * inner:
        return part * here
    return min(part * -math.log(max(1.0 - (radius - math.sqrt(aside2)) / edge, 1e-17)), here)


@njit(cache=True, nogil=True)
def effort_on(east, north, along_x, along_y, length, radius, law, strength):
    """Effort of one leg on a place `east` and `north` of its start, and the metres along it at which it is nearest.

    along_x, along_y : direction of the leg, a unit vector
    strength : above 0; EVEN: effort a metre in view; CUBE: sweep width W, for W^2 / 8 pi r^3 of effort a metre; EDGED:
    width of the edge
    """
    along = east * along_x + north * along_y
    aside = east * along_y - north * along_x
    aside2 = aside * aside
    if law == SEEN or law == EDGED:  # noqa: SIM109
        nearest = min(max(along, 0.0), length)
        off2 = aside2 + (along - nearest) * (along - nearest)
        if law == SEEN:
            return (SURE if off2 <= (radius + TOUCH_M) * (radius + TOUCH_M) else 0.0), nearest
        inner = max(radius - strength, 0.0)
        if off2 <= inner * inner:
            return SURE, nearest
        if off2 >= radius * radius:
            return 0.0, nearest
        return edge_effort(aside2, off2, along, length, inner, radius, strength), nearest
    half2 = radius * radius - aside2
    if half2 <= 0.0:
        return 0.0, 0.0
    half = math.sqrt(half2)
    enter, leave = max(along - half, 0.0) - along, min(along + half, length) - along
    if leave <= enter:
        return 0.0, 0.0
    nearest = min(max(along, 0.0), length)
    if law == EVEN:
        return min(strength * (leave - enter), SURE), nearest
    aside2 = max(aside2, (NEAREST * radius) ** 2)
    swept = leave / math.sqrt(aside2 + leave * leave) - enter / math.sqrt(aside2 + enter * enter)
    return min(strength * strength / (8.0 * math.pi) * swept / aside2, SURE), nearest


@njit(cache=True, nogil=True)
def leg_effort(x0, y0, x1, y1, cell_m, height, width, radius, law, strength, cells, effort, nearest):
    """Fill the arrays with the cells that one leg puts effort on; answers how many, -1 where they do not fit.

    strength : (N,) float64 by cell; 0 sees nothing
    """
    count = 0
    reach = radius + TOUCH_M
    low = max(math.ceil((min(y0, y1) - reach) / cell_m), 0)
    high = min(math.floor((max(y0, y1) + reach) / cell_m), height - 1)
    dx, dy = x1 - x0, y1 - y0
    length = math.sqrt(dx * dx + dy * dy)
    along_x, along_y = (dx / length, dy / length) if length > 1e-12 else (1.0, 0.0)
    for up in range(low, high + 1):
        north = up * cell_m
        west, east = min(x0, x1), max(x0, x1)
        if abs(dy) > 1e-9:  # only the part of the leg that lies within reach of this row
            t0, t1 = (north - reach - y0) / dy, (north + reach - y0) / dy
            if t0 > t1:
                t0, t1 = t1, t0
            t0, t1 = min(max(t0, 0.0), 1.0), min(max(t1, 0.0), 1.0)
            a, b = x0 + t0 * dx, x0 + t1 * dx
            west, east = min(a, b), max(a, b)
        first = max(math.ceil((west - reach) / cell_m), 0)
        last = min(math.floor((east + reach) / cell_m), width - 1)
        row = (height - 1 - up) * width
        if count + last - first >= cells.shape[0]:
            return -1
        for col in range(first, last + 1):
            here = strength[row + col]
            if here <= 0.0:
                continue
            worth, at = effort_on(col * cell_m - x0, north - y0, along_x, along_y, length, radius, law, here)
            if worth > 0.0:
                cells[count], effort[count], nearest[count] = row + col, worth, at
                count += 1
    return count


@njit(cache=True, nogil=True)
def line_effort(points, cell_m, height, width, radius, law, strength):
    """Effort of every leg of a polyline (n, 2), in order: cells, effort, and metres along the line when nearest."""
    room = 1024
    cells, effort, nearest = np.empty(room, np.int64), np.empty(room), np.empty(room)
    leg_cells, leg_worth, leg_at = np.empty(1024, np.int64), np.empty(1024), np.empty(1024)
    count, flown = 0, 0.0
    for k in range(max(points.shape[0] - 1, 1)):
        j = min(k + 1, points.shape[0] - 1)
        x0, y0, x1, y1 = points[k, 0], points[k, 1], points[j, 0], points[j, 1]
        found = leg_effort(x0, y0, x1, y1, cell_m, height, width, radius, law, strength, leg_cells, leg_worth, leg_at)
        while found < 0:
            more = 4 * leg_cells.shape[0]
            leg_cells, leg_worth, leg_at = np.empty(more, np.int64), np.empty(more), np.empty(more)
            found = leg_effort(
                x0, y0, x1, y1, cell_m, height, width, radius, law, strength, leg_cells, leg_worth, leg_at
            )
        if count + found > room:
            room = 2 * (count + found)
            more_cells, more_worth, more_at = np.empty(room, np.int64), np.empty(room), np.empty(room)
            more_cells[:count], more_worth[:count], more_at[:count] = cells[:count], effort[:count], nearest[:count]
            cells, effort, nearest = more_cells, more_worth, more_at
        cells[count : count + found] = leg_cells[:found]
        effort[count : count + found] = leg_worth[:found]
        nearest[count : count + found] = leg_at[:found] + flown
        count += found
        flown += math.hypot(x1 - x0, y1 - y0)
    return cells[:count], effort[:count], nearest[:count]
