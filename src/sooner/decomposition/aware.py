"""Regions that know where there is more to learn [Kuhlman2017, sec. 8 and 9: future work]."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.decomposition.boustrophedon import boustrophedon
from sooner.decomposition.chunks import chunked
from sooner.decomposition.regions import Regions
from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["gain_classes", "regions_for", "spacing_for"]

LARGEST = 0.25  # of what the shortest flight can sweep
HASTE, APART = 1.5, 1.75  # less than so many sweeps: lines lie so many radii apart


def spacing_for(radius_m: float, swept_m2: float, ground_m2: float) -> float:
    """Metres between plow lines: the sensor's radius, or 1.75 of it where there is no time for one and a half sweeps.

    swept_m2 is the ground that all drones can sweep in their time with lines one radius apart. So swept, a cell comes
    into view twice in each search; where time is short it is better to see more ground once. Tuned as `regions_for`.
    """
    return radius_m if swept_m2 >= HASTE * ground_m2 else APART * radius_m


def regions_for(
    grid: Grid,
    first_look: ArrayLike,
    base: Regions | None = None,
    chunk_m: float = 52.8,
    most: int = 400,
    min_m2: float = 363.0,
    swept_m2: float = np.inf,
    smooth_m: float = 8.8,
) -> Regions:
    """Regions of ground that is alike, so that each can be searched as often as it is worth.

    Boustrophedon regions, cut at the borders of `gain_classes` and into chunks; where ground is all alike, as they are
    but for those that are too large.

    Parameters
    ----------
    grid : Grid                square cells
    first_look : (N,) float    what the first look at each cell pays: `Gains.first`
    base : Regions             what is cut; None: `boustrophedon(grid)`
    chunk_m : float            metres from west to east of a chunk: best about six times the sensing radius
    most : int                 chunks grow where there would be more of them than this
    min_m2 : float             least region, as `chunked`
    swept_m2 : float           ground that the shortest flight can sweep: larger regions than a quarter of it are hardly
                               ever worth their time, and are cut
    smooth_m : float           as `gain_classes`

    Notes
    -----
    Tuned on environments 41 and 42 of [Kuhlman2017]'s kinds. Smaller regions lose more to turns than they gain by
    being apart, but for a judge that counts looks by actions (`benchmarks/regions`).

    Examples
    --------
    >>> grid = Grid((30, 60), cell_m=2.0)
    >>> regions_for(grid, np.repeat([[0.1, 0.4]], 30, axis=0).repeat(30, axis=1), chunk_m=80.0).n_regions
    2
    """
    cut = boustrophedon(grid) if base is None else base
    classes = gain_classes(grid, first_look, smooth_m=smooth_m)
    largest_m2 = max(LARGEST * swept_m2, 2 * min_m2)
    least_m = grid.cell_m * float(np.sqrt(grid.passable.sum() / most))
    if classes.any():
        wide_m = max(chunk_m, least_m)
        return chunked(grid, cut, wide_m, classes, min_m2, max(largest_m2 / wide_m, least_m))
    if cut.sizes.max() * grid.cell_m**2 <= largest_m2:
        return cut
    side_m = max(float(np.sqrt(largest_m2)), least_m)
    return chunked(grid, cut, side_m, None, min_m2, side_m)


def gain_classes(
    grid: Grid, first_look: ArrayLike, levels: int = 3, smooth_m: float = 8.8, apart: float = 0.1
) -> NDArray[np.int32]:
    """Class of each cell by what there is to learn, from 0 for the least, with borders smooth enough to plow along.

    Gains are grouped around at most so many means, to the least sum of squares (Lloyd 1982, IEEE Trans. Inf. Theory
    28, 129-137), means that differ by less than `apart` of the largest gain being one; then each cell takes the
    class that most of the free ground around it has.

    Parameters
    ----------
    grid : Grid
    first_look : (N,) or (H, W) float
    levels : int               most classes
    smooth_m : float           metres around a cell that say which class it is of: about the sensor's radius
    apart : float              share of the largest gain by which classes differ at least

    Returns
    -------
    (H, W) int32

    Examples
    --------
    >>> gain_classes(Grid((1, 8)), [1, 1, 1, 9, 1, 5, 5, 5], smooth_m=2.0).tolist()
    [[0, 0, 0, 0, 0, 1, 1, 1]]
    """
    gains = np.asarray(first_look, np.float64).reshape(-1)
    if gains.size != grid.n_cells or not np.isfinite(gains).all() or (gains < 0).any():
        raise InvalidProblemError(f"gains of {gains.size} cells came; expected {grid.n_cells}, finite and at least 0")
    if levels < 1 or not (np.isfinite(smooth_m) and smooth_m >= 0):
        raise InvalidProblemError(f"{levels} levels and {smooth_m} m came; expected at least 1 level and 0 m")
    borders = _borders(gains[grid.passable], levels, apart)
    classes = np.searchsorted(borders, gains).astype(np.int32).reshape(grid.shape)
    return _majority(classes, grid.passable.reshape(grid.shape), len(borders) + 1, smooth_m / grid.cell_m)


def _borders(gains: NDArray[np.float64], levels: int, apart: float) -> NDArray[np.float64]:
    """Gains at which classes part, halfway between neighbouring means."""
    if np.ptp(gains) <= 1e-9 * gains.max():  # alike but for rounding
        return np.empty(0)
    counts, edges = np.histogram(gains, 512)
    middles, occupied = (edges[1:] + edges[:-1]) / 2, counts > 0
    middles, counts = middles[occupied], counts[occupied]
    means = np.unique(np.linspace(middles[0], middles[-1], levels))
    for _ in range(100):
        nearest = np.abs(middles[:, None] - means).argmin(axis=1)
        weight = np.bincount(nearest, counts, len(means))
        held = weight > 0
        new = np.bincount(nearest, counts * middles, len(means))[held] / weight[held]
        close = np.flatnonzero(np.diff(new) < apart * gains.max())
        new = np.delete(new, close[:1] + 1)
        if len(new) == len(means) and np.allclose(new, means):
            break
        means = new
    return np.asarray((means[1:] + means[:-1]) / 2)


def _majority(classes: NDArray[np.int32], free: NDArray[np.bool_], count: int, cells: float) -> NDArray[np.int32]:
    """What class most of the free ground in a square around each cell has, counted twice to round its corners off."""
    from scipy.ndimage import uniform_filter

    width = 2 * round(cells / 2) + 1
    if count == 1 or width == 1:
        return classes
    best, most = np.zeros(classes.shape, np.int32), np.full(classes.shape, -1.0, np.float32)
    for one in range(count):
        share = np.where(free & (classes == one), np.float32(1.0), np.float32(0.0))
        share = uniform_filter(uniform_filter(share, width, mode="constant"), width, mode="constant")
        more = share > most + 1e-6
        best[more], most[more] = one, share[more]
    return best
