"""Rings: a first belief from where the person was last known to be, and how far others like them were found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["disc_areas", "ring_poc"]

Floats = NDArray[np.float64]

_LARGEST_M = 1_000_000.0


def ring_poc(grid: Grid, centre_m: ArrayLike, rings_m: Sequence[float], quantiles: Sequence[float]) -> Floats:
    """POC of every cell from a table of distances, as statistics of lost persons give them.

    p_i = sum_k (q_k - q_{k-1}) |i and ring k| / |ring k|,   |ring k| = pi (r_k^2 - r_{k-1}^2)

    The table says which share of cases was found within each distance and no more; of all beliefs that agree with it,
    even within each ring is the one of the largest entropy. The rest, 1 - q_last and what of a ring lies beyond the
    grid, is outside.

    Parameters
    ----------
    grid : Grid                     of square cells
    centre_m : (2,) float           metres east and north of the south-west cell's centre; may lie beyond the grid
    rings_m : sequence of float     distances, growing
    quantiles : sequence of float   share of cases found within each, growing, the last at most 1

    Returns
    -------
    (H, W) float                    totals at most the last quantile

    Raises
    ------
    InvalidProblemError             if distances or shares do not grow, or are not as many

    Examples
    --------
    >>> poc = ring_poc(Grid((81, 81), cell_m=50.0), (2000.0, 2000.0), [300.0, 1500.0], [0.5, 0.95])
    >>> round(float(poc.sum()), 12)
    0.95
    """
    radii, shares = _checked(rings_m, quantiles)
    if grid.connectivity == "hex":
        raise InvalidProblemError("hexagons came; expected square cells for rings")
    centre = np.asarray(centre_m, np.float64)
    if centre.shape != (2,) or not np.isfinite(centre).all():
        raise InvalidProblemError(f"a centre of {centre.tolist()} came; expected metres east and north")
    poc, within, last, reached = np.zeros(grid.shape), np.zeros(grid.shape), 0.0, 0.0
    for radius, share in zip(radii, shares, strict=True):
        areas = disc_areas(grid.shape, grid.cell_m, centre, radius)
        poc += (share - reached) * np.maximum(areas - within, 0.0) / (np.pi * (radius**2 - last**2))
        within, last, reached = areas, radius, share
    return poc


def _checked(rings_m: Sequence[float], quantiles: Sequence[float]) -> tuple[Floats, Floats]:
    radii, shares = np.asarray(rings_m, np.float64), np.asarray(quantiles, np.float64)
    if radii.ndim != 1 or radii.shape != shares.shape or not len(radii):
        raise InvalidProblemError(
            f"{radii.size} distances and {shares.size} shares came; expected one share for each distance"
        )
    if not (np.isfinite(radii).all() and (np.diff(radii, prepend=0.0) > 0).all() and radii[-1] <= _LARGEST_M):
        raise InvalidProblemError(f"distances of {list(rings_m)} m came; expected positive ones that grow")
    if not (np.isfinite(shares).all() and (np.diff(shares, prepend=0.0) > 0).all() and shares[-1] <= 1.0):
        raise InvalidProblemError(
            f"shares of {list(quantiles)} came; expected some that grow, from above 0 to at most 1"
        )
    return radii, shares


def disc_areas(shape: tuple[int, int], cell_m: float, centre_m: ArrayLike, radius_m: float) -> Floats:
    """(H, W) float: square metres of each square cell that lie within a disc, exactly.

    Examples
    --------
    >>> disc_areas((1, 2), 2.0, (0.0, 0.0), 1.0).round(6)
    array([[3.141593, 0.      ]])
    """
    east, north = np.asarray(centre_m, np.float64)
    x = (np.arange(shape[1] + 1) - 0.5) * cell_m - east
    y = (shape[0] - 0.5 - np.arange(shape[0] + 1)) * cell_m - north
    corners = _corner_areas(x[None, :], y[:, None], radius_m)
    areas = corners[:-1, 1:] - corners[:-1, :-1] - corners[1:, 1:] + corners[1:, :-1]
    return np.asarray(np.clip(areas, 0.0, cell_m**2))


def _corner_areas(x: Floats, y: Floats, radius: float) -> Floats:
    """Signed area of the disc within the rectangle from its middle to (x, y): odd in x and in y.

    With a = min(|x|, r) and b = min(|y|, r) it is a b where that corner lies within the disc, else b c up to where the
    circle comes down to b, at c = sqrt(r^2 - b^2), and below the circle from there to a.
    """
    a, b = np.minimum(np.abs(x), radius), np.minimum(np.abs(y), radius)
    c = np.minimum(np.sqrt(np.maximum(radius**2 - b**2, 0.0)), a)
    area = b * c + _below(a, radius) - _below(c, radius)
    return np.asarray(np.sign(x) * np.sign(y) * area)


def _below(x: Floats, radius: float) -> Floats:
    """Area below the circle from 0 to x."""
    return np.asarray((x * np.sqrt(np.maximum(radius**2 - x**2, 0.0)) + radius**2 * np.arcsin(x / radius)) / 2.0)
