"""The cells in view along a flight, and when each first comes into view."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.grid import Grid, rows_and_cols
from sooner.sensors._footprint_kernels import sweep

__all__ = ["swept_cells"]

ALL = np.empty(0, bool)


def swept_cells(
    grid: Grid, polyline: ArrayLike, radius_m: float, obstacles: bool = False
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Cells whose centres lie within the radius of a polyline: the sensor's disc swept along it.

    F = {i : min over s of |c_i - r(s)| <= R},   first_i = min {s : |c_i - r(s)| <= R}      [Kuhlman2017, sec. 6.3]

    A centre at the radius is in view; so is one up to 1e-9 of a cell beyond it, for which s is where it is nearest.
    However small the radius, a look covers at least the cell below: every cell that a leg is over for more than 1e-6
    of a cell, or in which a leg begins, belongs to F (from sqrt(1/2) of a cell on, the radius alone sees to that). An
    edge between two cells belongs to the southern or eastern one.

    Parameters
    ----------
    grid : Grid                square cells
    polyline : (n, 2) float    metres in the frame of `Grid.centres_m`, n >= 1; it may leave the map
    radius_m : float           at least 0
    obstacles : bool           whether cells with obstacles belong to F

    Returns
    -------
    cells : (m,) int64         cell numbers, ascending, each once
    first_m : (m,) float       metres along the polyline at which each first comes into view

    Raises
    ------
    InvalidProblemError        if the polyline or the radius makes no sense
    UnsupportedProblemError    if cells are hexagons

    Examples
    --------
    >>> cells, first = swept_cells(Grid((1, 6), cell_m=2.0), [[0, 0], [6, 0]], radius_m=2.0)
    >>> cells, first
    (array([0, 1, 2, 3, 4]), array([0., 0., 2., 4., 6.]))
    """
    if grid.connectivity == "hex":
        raise UnsupportedProblemError("a hexagonal grid came; discs are swept over square cells only")
    points = np.asarray(polyline, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) == 0 or not np.isfinite(points).all():
        raise InvalidProblemError(
            f"a polyline of shape {points.shape} came; expected finite metres east and north, (n, 2) with n >= 1"
        )
    if not (np.isfinite(radius_m) and radius_m >= 0):
        raise InvalidProblemError(f"a radius of {radius_m} m came; expected a number of at least 0")
    passable = ALL if obstacles or grid.obstacles is None else grid.passable
    cells, first = sweep(rows_and_cols(grid, points), radius_m / grid.cell_m, *grid.shape, passable)
    return cells, first * grid.cell_m
