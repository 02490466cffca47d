"""Cells of one grid laid over those of another: areas in common, of any four-cornered cell with any square one."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def spread(x, y, values, height, width, totals, areas):
    """Share out every source cell's value among the target cells that it covers, by area.

    x, y : (h + 1, w + 1) float     corners of the source's cells, in columns and rows of the target
    values : (h, w) float           NaN: no data, passed over
    totals, areas : (height, width) float    added to: value times share of the source cell, and area in target cells
    """
    corners, spare = np.empty((12, 2)), np.empty((12, 2))
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            value = values[i, j]
            if np.isnan(value):
                continue
            qx = (x[i, j], x[i, j + 1], x[i + 1, j + 1], x[i + 1, j])
            qy = (y[i, j], y[i, j + 1], y[i + 1, j + 1], y[i + 1, j])
            whole = 0.0
            for k in range(4):
                n = (k + 1) % 4
                whole += 0.5 * (qx[k] * qy[n] - qx[n] * qy[k])
            whole = abs(whole)
            if not whole > 0.0:
                continue
            first_col, last_col = int(np.floor(max(min(qx), 0.0))), int(np.ceil(min(max(qx), float(width))))
            first_row, last_row = int(np.floor(max(min(qy), 0.0))), int(np.ceil(min(max(qy), float(height))))
            for row in range(first_row, last_row):
                for col in range(first_col, last_col):
                    for k in range(4):
                        corners[k, 0], corners[k, 1] = qx[k] - col, qy[k] - row
                    common = clipped(corners, spare)
                    totals[row, col] += value * common / whole
                    areas[row, col] += common


@njit(cache=True, nogil=True)
def clipped(corners, spare):
    """Area in common of a convex four-cornered cell and the unit square [Sutherland and Hodgman's clipping]."""
    count = 4
    for side in range(4):
        axis, sign, limit = side % 2, 1.0 if side < 2 else -1.0, 0.0 if side < 2 else -1.0
        kept = 0
        for k in range(count):
            n = (k + 1) % count
            here, there = sign * corners[k, axis] - limit, sign * corners[n, axis] - limit
            if here >= 0.0:
                spare[kept, 0], spare[kept, 1] = corners[k, 0], corners[k, 1]
                kept += 1
            if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
                part = here / (here - there)
                spare[kept, 0] = corners[k, 0] + part * (corners[n, 0] - corners[k, 0])
                spare[kept, 1] = corners[k, 1] + part * (corners[n, 1] - corners[k, 1])
                kept += 1
        count = kept
        if count < 3:
            return 0.0
        for k in range(count):
            corners[k, 0], corners[k, 1] = spare[k, 0], spare[k, 1]
    area = 0.0
    for k in range(count):
        n = (k + 1) % count
        area += 0.5 * (corners[k, 0] * corners[n, 1] - corners[n, 0] * corners[k, 1])
    return abs(area)
