"""The ground as agents fly over it: a rectangle, its corners and its perimeter, in metres."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["area", "perimeter_places"]


def area(grid: Grid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """South-west and north-east corners of the ground, metres east and north of the south-west cell's centre.

    >>> area(Grid((2, 4), "square8", 5.0))
    (array([-2.5, -2.5]), array([17.5,  7.5]))
    """
    if grid.connectivity == "hex":
        raise InvalidProblemError("a grid of hexagons came; agents with graded sensors look at square cells")
    half = 0.5 * grid.cell_m
    return np.array([-half, -half]), np.array([grid.shape[1], grid.shape[0]]) * grid.cell_m - half


def perimeter_places(grid: Grid, n_places: int, rng: Generator) -> NDArray[np.float64]:
    """(n, 2) float: places drawn uniformly along the edge of the ground."""
    low, high = area(grid)
    east, north = high - low
    along = rng.random(n_places) * 2.0 * (east + north)
    places = np.empty((n_places, 2))
    for n, way in enumerate(along):  # once round, from the south-west corner against the clock
        if way < east:
            places[n] = way, 0.0
        elif way < east + north:
            places[n] = east, way - east
        elif way < 2.0 * east + north:
            places[n] = 2.0 * east + north - way, north
        else:
            places[n] = 0.0, 2.0 * (east + north) - way
    return low + places
