"""Voronoi regions around obstacles, smaller where there is more to learn [Kuhlman2017, sec. 8 and 9: future work]."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.decomposition.chunks import tidied
from sooner.decomposition.regions import Regions
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.grid.paths import geodesic

__all__ = ["voronoi"]

LEAST = 0.05  # of the largest weight: ground that weighs nothing still needs somebody to fly over it


def voronoi(
    grid: Grid,
    weights: ArrayLike,
    size_m2: float = 2500.0,
    classes: NDArray[np.integer] | None = None,
    rounds: int = 6,
    min_m2: float = 363.0,
) -> Regions:
    """Give each free cell to the seed to which the way around obstacles is shortest, then move seeds to the middle.

    A seed moves to the free cell of its own that is nearest to the weighted mean of its cells, again and again (Lloyd
    1982), which makes regions small where weights are large (Du, Faber and Gunzburger 1999, SIAM Review 41, 637-676).
    The first seeds lie one after another where distance^2 times weight is largest (Gonzalez 1985).

    Parameters
    ----------
    grid : Grid                square cells
    weights : (N,) float       of cells: what there is to learn
    size_m2 : float            square metres of the mean region
    classes : (H, W) int       regions do not reach from one class into another; None: all are one
    rounds : int               of moving seeds
    min_m2 : float             what is cut off smaller joins a neighbour, as in `chunked`

    Raises
    ------
    InvalidProblemError        if there is no free cell, cells are hexagons, shapes differ, or a number makes no sense

    Examples
    --------
    >>> grid = Grid((2, 8))
    >>> voronoi(grid, np.ones(16), size_m2=8.0, min_m2=1.0).sizes.tolist()
    [6, 10]
    """
    density = _checked(grid, weights, size_m2, min_m2)
    kinds = np.zeros(grid.shape, np.int64) if classes is None else np.asarray(classes)
    if kinds.shape != grid.shape:
        raise InvalidProblemError(f"classes of shape {kinds.shape} came; the grid has {grid.shape}")
    labels = np.full(grid.n_cells, -1, np.int32)
    for kind in np.unique(kinds[grid.passable.reshape(grid.shape)]):
        own = replace(grid, obstacles=~grid.passable.reshape(grid.shape) | (kinds != kind))
        owner = _settled(own, density, size_m2 / grid.cell_m**2, rounds)
        labels[own.passable] = owner[own.passable] + labels.max() + 1
    return tidied(grid, labels.reshape(grid.shape), kinds.astype(np.int32), min_m2 / grid.cell_m**2)


def _settled(grid: Grid, density: NDArray[np.float64], size: float, rounds: int) -> NDArray[np.int32]:
    """(N,) int32: the seed of each cell."""
    from sooner.decomposition._voronoi_kernels import middles

    seeds = _seeds(grid, density, max(round(int(grid.passable.sum()) / size), 1))
    owner = geodesic(grid, seeds)[0]
    for _ in range(rounds):
        moved = middles(owner, grid.shape[1], density, len(seeds))
        if np.array_equal(moved, seeds):
            break
        seeds = moved
        owner = geodesic(grid, seeds)[0]
    return owner


def _seeds(grid: Grid, density: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """At least so many cells far from one another, and one at least in each part of the ground."""
    from sooner.decomposition._voronoi_kernels import approach, farthest

    first = int(np.argmax(grid.passable))
    apart = geodesic(grid, [first])[1]
    seeds = [int(np.argmax(np.where(np.isinf(apart), -1.0, apart)))]
    apart = np.full(grid.n_cells, np.inf)
    steps, waiting = np.full((3, grid.n_cells), -1, np.int32), np.empty((3, grid.n_cells), np.int32)
    touched = np.empty(grid.n_cells, np.int32)
    while True:
        approach(grid.passable, grid.shape[1], seeds[-1], apart, steps[0], steps[1], steps[2], waiting, touched)
        far = int(farthest(grid.passable, apart, density))
        if (len(seeds) >= count and np.isfinite(apart[far])) or apart[far] == 0.0:
            return np.array(seeds)
        seeds.append(far)


def _checked(grid: Grid, weights: ArrayLike, size_m2: float, min_m2: float) -> NDArray[np.float64]:
    """Weights of cells, none much below the others."""
    density = np.asarray(weights, np.float64).reshape(-1)
    if grid.connectivity == "hex":
        raise InvalidProblemError("hexagonal cells came; expected square ones")
    if not grid.passable.any():
        raise InvalidProblemError("every cell came as an obstacle; expected at least one free cell")
    if density.size != grid.n_cells or not np.isfinite(density).all() or (density < 0).any():
        raise InvalidProblemError(
            f"weights of {density.size} cells came; expected {grid.n_cells}, finite and at least 0"
        )
    if not (np.isfinite(size_m2) and size_m2 > 0 and min_m2 >= 0):
        raise InvalidProblemError(f"regions of {size_m2} m2, at least {min_m2} m2, came; expected positive numbers")
    return np.maximum(density, LEAST * density.max()) if density.any() else np.ones(grid.n_cells)
