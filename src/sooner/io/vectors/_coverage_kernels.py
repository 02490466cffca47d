"""How much of each cell lies within borders: the share of ground to the right of every edge, summed."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def right_of(edges, height, width):
    """(height, width): signed shares of cells to the right (greater x) of edges (n, 4), x0, y0, x1, y1 in cells.

    Edges that go down (greater y) count positive, those that go up negative: summed around a border they leave what is
    within. In each row an edge of height h and mean x m within column c adds h (c + 1 - m) to that cell, and h to all
    cells beyond; so rows are summed from the left at the end.
    """
    steps = np.zeros((height, width + 1))
    for e in range(edges.shape[0]):
        x0, y0, x1, y1 = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
        if y0 == y1:
            continue
        sign = 1.0
        if y0 > y1:
            x0, y0, x1, y1, sign = x1, y1, x0, y0, -1.0
        slope = (x1 - x0) / (y1 - y0)
        top, bottom = max(y0, 0.0), min(y1, float(height))
        row = int(top)
        while row < bottom:
            upper, lower = max(top, float(row)), min(bottom, row + 1.0)
            if lower > upper:
                xa, xb = x0 + slope * (upper - y0), x0 + slope * (lower - y0)
                add_row(steps[row], min(xa, xb), max(xa, xb), sign * (lower - upper), width)
            row += 1
    shares = np.empty((height, width))
    for row in range(height):
        total = 0.0
        for col in range(width):
            total += steps[row, col]
            shares[row, col] = total
    return shares


@njit(cache=True, nogil=True)
def add_row(steps, left, right, tall, width):
    """An edge's part within a row, from x = left to right, adds its height to the cells that it crosses."""
    if left >= width:
        return
    if right <= 0.0:
        steps[0] += tall
        return
    if right - left < 1e-12:
        col = min(int(max(left, 0.0)), width - 1)
        inside = min(max(left - col, 0.0), 1.0)
        steps[col] += tall * (1.0 - inside)
        steps[col + 1] += tall * inside
        return
    each = tall / (right - left)  # height for each cell of way
    if left < 0.0:
        steps[0] += each * -left
        left = 0.0
    right = min(right, float(width))
    col = int(left)
    while col < right:
        begins, ends = max(left, float(col)), min(right, col + 1.0)
        middle = 0.5 * (begins + ends) - col
        steps[col] += each * (ends - begins) * (1.0 - middle)
        steps[col + 1] += each * (ends - begins) * middle
        col += 1
