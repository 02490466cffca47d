"""The cells in view along a flight, and when each first comes into view."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.grid import Grid, rows_and_cols
from sooner.sensors._footprint_kernels import sweep, sweep_passes

__all__ = ["cell_passes", "swept_cells"]

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
    cells, first = sweep(*_checked(grid, polyline, radius_m, obstacles))
    return cells, first * grid.cell_m


def cell_passes(
    grid: Grid, polyline: ArrayLike, radius_m: float, obstacles: bool = False
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Every time that a cell comes into view of a disc swept along a polyline: F of `swept_cells`, pass by pass.

    A pass of cell i is a longest stretch of the polyline on which |c_i - r(s)| <= R. The disc is closed and a leg
    straight, so that a cell has at most one pass more than the polyline has corners.

    Parameters
    ----------
    as `swept_cells`

    Returns
    -------
    cells : (m,) int64             cell numbers, ascending, each as often as it comes into view
    comes_m, goes_m : (m,) float   metres along the polyline where each pass begins and ends, ascending in each cell

    Examples
    --------
    >>> there_and_back = [[0, 0], [6, 0], [0, 0]]
    >>> cells, comes, goes = cell_passes(Grid((1, 4), cell_m=2.0), there_and_back, radius_m=2.0)
    >>> cells, comes, goes
    (array([0, 0, 1, 1, 2, 3]), array([ 0., 10.,  0.,  8.,  2.,  4.]), array([ 2., 12.,  4., 12., 10.,  8.]))
    """
    cells, comes, goes = sweep_passes(*_checked(grid, polyline, radius_m, obstacles))
    return cells, comes * grid.cell_m, goes * grid.cell_m


def _checked(
    grid: Grid, polyline: ArrayLike, radius_m: float, obstacles: bool
) -> tuple[NDArray[np.float64], float, int, int, NDArray[np.bool_]]:
    """What the kernels take."""
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
    return rows_and_cols(grid, points), radius_m / grid.cell_m, *grid.shape, passable
