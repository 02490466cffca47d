"""Compiled tests of straight legs against walls: plain arrays in, plain arrays out.

walls : (E, 4) float64    x and y of both ends of every stretch of border; legs that touch one cross it
"""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def clear(x0, y0, x1, y1, walls):
    """Whether the leg from (x0, y0) to (x1, y1) meets no wall."""
    dx, dy = x1 - x0, y1 - y0
    west, east = min(x0, x1), max(x0, x1)
    south, north = min(y0, y1), max(y0, y1)
    for k in range(walls.shape[0]):
        ax, ay, bx, by = walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]
        if max(ax, bx) < west or min(ax, bx) > east or max(ay, by) < south or min(ay, by) > north:
            continue
        side_a = dx * (ay - y0) - dy * (ax - x0)
        side_b = dx * (by - y0) - dy * (bx - x0)
        if (side_a > 0.0 and side_b > 0.0) or (side_a < 0.0 and side_b < 0.0):
            continue
        wx, wy = bx - ax, by - ay
        side_0 = wx * (y0 - ay) - wy * (x0 - ax)
        side_1 = wx * (y1 - ay) - wy * (x1 - ax)
        if (side_0 > 0.0 and side_1 > 0.0) or (side_0 < 0.0 and side_1 < 0.0):
            continue
        return False
    return True


@njit(cache=True, nogil=True)
def inside(x, y, walls):
    """Whether a place lies within the walls: a ray to the east meets them an odd number of times."""
    odd = False
    for k in range(walls.shape[0]):
        ax, ay, bx, by = walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]
        if (ay > y) != (by > y) and x < ax + (bx - ax) * (y - ay) / (by - ay):
            odd = not odd
    return odd


@njit(cache=True, nogil=True)
def visible(here, there, walls):
    """(n, m) float64: metres from each place to each other along a free straight leg, inf where there is none."""
    found = np.full((here.shape[0], there.shape[0]), np.inf)
    for i in range(here.shape[0]):
        for j in range(there.shape[0]):
            if clear(here[i, 0], here[i, 1], there[j, 0], there[j, 1], walls):
                found[i, j] = np.hypot(here[i, 0] - there[j, 0], here[i, 1] - there[j, 1])
    return found
