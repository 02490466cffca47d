"""Modes of a surface over cells: its peaks, a flat one represented by its middle [Lin2014, section IV-B]."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid

__all__ = ["modes"]


def modes(grid: Grid, surface: NDArray[np.float64]) -> NDArray[np.int64]:
    """One cell for every mode: a plateau of equal height, all around which lies lower.

    All around means the eight cells of a square's surround, also where drones step to four only, and the six of a
    hexagon's. A plateau is represented by its centroid, rounded to a cell; by its own cell nearest to that, where
    the centroid falls on an obstacle.

    Parameters
    ----------
    grid : Grid
    surface : (N,) float       height of each cell; ground of zero height is no mode

    Returns
    -------
    (M,) int                   cells in order of their modes' first cells, row by row

    Examples
    --------
    >>> modes(Grid((1, 7)), np.array([3.0, 1.0, 2.0, 2.0, 2.0, 0.0, 1.0])).tolist()
    [0, 3, 6]
    """
    from sooner.decomposition._kernels import peaks

    around = grid if grid.connectivity == "hex" else replace(grid, connectivity="square8")
    kernel: Any = peaks
    labels: NDArray[np.int32] = kernel(around.neighbours, np.ascontiguousarray(surface, np.float64))
    cells = np.flatnonzero(labels)
    if cells.size == 0:
        return np.zeros(0, np.int64)
    label = labels[cells] - 1
    rows, cols = np.divmod(cells, grid.shape[1])
    size = np.bincount(label)
    row, col = np.bincount(label, rows) / size, np.bincount(label, cols) / size
    middle: NDArray[np.int64] = np.rint(row).astype(np.int64) * grid.shape[1] + np.rint(col).astype(np.int64)
    for mode in np.flatnonzero(~grid.passable[middle]):
        own = label == mode
        apart = np.where(own, (rows - row[mode]) ** 2 + (cols - col[mode]) ** 2, np.inf)
        middle[mode] = cells[np.argmin(apart)]
    return middle
