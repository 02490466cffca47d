"""From ways in metres to an occupancy graph: nodes in the cells that a way crosses, edges from one to the next."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.streets.occupancy import OccupancyGraph

__all__ = ["rasterised"]

Run = tuple[int, float, float, float]  # a cell, the length of the way in it, and that length times its mean place
OUTSIDE = -1


def rasterised(
    ways: Iterable[NDArray[np.float64]], grid: Grid, clip: float = 0.25, least_nodes: int = 5
) -> OccupancyGraph:
    """The occupancy graph of ways.

    The node of a cell is at the mean of all that ways run in it. A cell that a way clips for less than `clip` cells is
    passed over where the cells before and after touch. Ways that cross are joined, be it over a bridge. Parts of fewer
    than `least_nodes` nodes are dropped.

    Parameters
    ----------
    ways : (k, 2) float each      metres east and north, in the frame of `Grid.centres_m`; what is off the grid is cut
    grid : Grid                   square cells
    clip : float                  of a cell's side
    least_nodes : int

    Raises
    ------
    InvalidProblemError           if no street is left

    Examples
    --------
    >>> graph = rasterised([np.array([[0.0, 0.0], [4.0, 0.4]])], Grid((2, 5)))
    >>> graph.cells, graph.n_edges
    (array([5, 6, 7, 8, 9]), 4)
    """
    places: dict[int, list[float]] = {}
    edges: set[tuple[int, int]] = set()
    for way in ways:
        points = np.asarray(way, np.float64)
        if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
            raise InvalidProblemError(
                f"a way of shape {points.shape} came; expected (k, 2) finite metres east and north"
            )
        runs = _unclipped(_runs(points, grid), clip * grid.cell_m, grid.shape[1])
        for cell, length, east, north in runs:
            if cell != OUTSIDE:
                sums = places.setdefault(cell, [0.0, 0.0, 0.0])
                sums[:] = sums[0] + length, sums[1] + east, sums[2] + north
        joined = ((a, b) for (a, *_), (b, *_) in pairwise(runs) if a != b and OUTSIDE not in (a, b))
        edges |= {(min(pair), max(pair)) for pair in joined}
    if not places:
        raise InvalidProblemError("no street lies on the grid; expected at least one")
    cells = np.array(sorted(places), np.int64)
    sums_of = np.array([places[cell] for cell in cells.tolist()])
    numbers = np.searchsorted(cells, np.array(sorted(edges), np.int64).reshape(-1, 2))
    return _without_scraps(OccupancyGraph.of(grid, cells, numbers, sums_of[:, 1:] / sums_of[:, :1]), least_nodes)


def _runs(way: NDArray[np.float64], grid: Grid) -> list[Run]:
    """What a way runs in each cell, one after the other; OUTSIDE where it leaves the grid."""
    corner = way / grid.cell_m + 0.5  # in cells east and north of the grid's south-west corner
    size = np.array([grid.shape[1], grid.shape[0]], np.float64)
    low, high = np.minimum(corner[:-1], corner[1:]), np.maximum(corner[:-1], corner[1:])
    near: NDArray[np.bool_] = np.all((high >= 0.0) & (low <= size), axis=1)
    runs: list[Run] = []
    for k in range(len(corner) - 1):
        if not near[k]:
            _add(runs, OUTSIDE, 0.0, 0.0, 0.0)
            continue
        a, b = corner[k], corner[k + 1]
        length = float(np.hypot(*(b - a))) * grid.cell_m
        if length == 0.0:
            continue
        cuts = _cuts(a, b, size)
        for t, u in pairwise(cuts):
            middle = a + (b - a) * ((t + u) / 2.0)
            col, north = int(np.floor(middle[0])), int(np.floor(middle[1]))
            if 0 <= col < size[0] and 0 <= north < size[1]:
                cell, part = (grid.shape[0] - 1 - north) * grid.shape[1] + col, (u - t) * length
                east_m, north_m = (middle - 0.5) * grid.cell_m
                _add(runs, cell, part, part * float(east_m), part * float(north_m))
            else:
                _add(runs, OUTSIDE, 0.0, 0.0, 0.0)
    return runs


def _cuts(a: NDArray[np.float64], b: NDArray[np.float64], size: NDArray[np.float64]) -> list[float]:
    """Shares of a segment, from 0 to 1, at which it passes a line between cells, or the edge of the grid."""
    cuts = {0.0, 1.0}
    for axis in (0, 1):
        first, last = sorted((a[axis], b[axis]))
        lines = np.arange(np.ceil(max(first, 0.0)), np.floor(min(last, size[axis])) + 1.0)
        if len(lines) and first < last:
            cuts.update(((lines - a[axis]) / (b[axis] - a[axis])).tolist())
    return sorted(t for t in cuts if 0.0 <= t <= 1.0)


def _add(runs: list[Run], cell: int, length: float, east: float, north: float) -> None:
    if runs and runs[-1][0] == cell:
        _, *sums = runs[-1]
        runs[-1] = (cell, sums[0] + length, sums[1] + east, sums[2] + north)
    elif cell == OUTSIDE or length > 0.0:
        runs.append((cell, length, east, north))


def _unclipped(runs: list[Run], least_m: float, width: int) -> list[Run]:
    """Runs without those shorter than `least_m` between cells that touch, or that are one."""
    kept: list[Run] = []
    for k, run in enumerate(runs):
        before, after = kept[-1][0] if kept else OUTSIDE, runs[k + 1][0] if k + 1 < len(runs) else OUTSIDE
        inside = OUTSIDE not in (run[0], before, after)
        if not (inside and run[1] < least_m and _touch(before, after, width)):
            kept.append(run)
    return kept


def _touch(a: int, b: int, width: int) -> bool:
    return abs(a // width - b // width) <= 1 and abs(a % width - b % width) <= 1


def _without_scraps(graph: OccupancyGraph, least_nodes: int) -> OccupancyGraph:
    stays = np.bincount(graph.components)[graph.components] >= least_nodes
    if not stays.any():
        raise InvalidProblemError(f"no street of at least {least_nodes} cells lies on the grid; expected one")
    number = np.cumsum(stays) - 1
    edges = number[graph.edges[stays[graph.edges[:, 0]]]]
    return OccupancyGraph(graph.grid, graph.cells[stays], edges, graph.positions_m[stays])
