"""Regions that can be plowed: the boustrophedon decomposition of a map of cells [Kuhlman2017, sec. 6.2]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.decomposition.regions import Pieces, Regions, joined
from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["boustrophedon"]


def boustrophedon(
    grid: Grid,
    *,
    overlap: float = 0.8,
    min_cells: float = 75.0,
    min_columns: float = 3.0,
    min_obstacle: float = 0.0,
    at_width: float = 200.0,
) -> Regions:
    """Cut free ground into regions of which every column is one interval.

    A slice, one column wide, sweeps from west to east. A piece of it (a run of free cells) goes on as the piece next
    to it where neither touches another; where ground parts or joins, it goes on as the piece with which it shares at
    least `overlap` of the longer one, if there is such. What does not go on ends a region.

    Then regions that are too small to be covered sensibly are dropped. Their cells stay free but belong to no region,
    and the regions around them become adjacent in pairs. The largest region always stays.

    Parameters
    ----------
    grid : Grid                square cells
    overlap : float            in (0.5, 1]: more than half, so that no piece can go on as two
    min_cells : float          regions of fewer cells are dropped; on a map `at_width` columns wide
    min_columns : float        regions of fewer columns are dropped; likewise
    min_obstacle : float       the sweep ignores obstacles (joined by sides or corners) of fewer cells; likewise.
                               Their cells stay obstacles and lie as holes in regions; a part of a region that they
                               cut off is a region of its own.
    at_width : float           columns W0 of the map that the numbers are meant for. They grow with W / W0, those
                               that count cells with its square, so that a finer map of the same ground has the
                               same regions. The map's own width keeps them as they are.

    Returns
    -------
    Regions                    numbered as the sweep meets them, from the west and then from the north

    Raises
    ------
    InvalidProblemError        if there is no free cell, cells are hexagons, or a number makes no sense

    Notes
    -----
    The paper gives no numbers: these fit its counts of regions.

    Examples
    --------
    >>> rock = np.zeros((9, 12), bool)
    >>> rock[3:6, 4:8] = True
    >>> regions = boustrophedon(Grid(rock.shape, obstacles=rock), min_cells=1, min_columns=1, at_width=12)
    >>> regions.labels[[0, 4, 8]]
    array([[ 0,  0,  0,  0,  1,  1,  1,  1,  3,  3,  3,  3],
           [ 0,  0,  0,  0, -1, -1, -1, -1,  3,  3,  3,  3],
           [ 0,  0,  0,  0,  2,  2,  2,  2,  3,  3,  3,  3]], dtype=int32)
    >>> regions.adjacency.tolist()
    [[0, 1], [0, 2], [1, 3], [2, 3]]
    """
    _check(grid, overlap, (min_cells, min_columns, min_obstacle), at_width)
    finer = grid.shape[1] / at_width
    free = grid.passable.reshape(grid.shape)
    swept = free if min_obstacle == 0 else free | _small_obstacles(~free, min_obstacle * finer**2)
    chains = _chained(Pieces.of(np.where(swept, np.int32(0), np.int32(-1))), overlap)
    if swept is not free:
        chains = Pieces.of(np.where(free, chains.painted(chains.label), np.int32(-1)))
    return Regions.from_labels(grid, chains.painted(_large(chains, min_cells * finer**2, min_columns * finer)))


def _chained(pieces: Pieces, overlap: float) -> Pieces:
    """The same pieces, labelled by the chains in which they go on."""
    west, east, shared = pieces.beside()
    length = pieces.stop - pieces.start
    touch_east, touch_west = np.bincount(west, minlength=len(length)), np.bincount(east, minlength=len(length))
    goes_on = (touch_east[west] == 1) & (touch_west[east] == 1)
    goes_on |= shared >= overlap * np.maximum(length[west], length[east])
    _, chain = joined(len(length), west[goes_on], east[goes_on])
    return pieces._replace(label=chain)


def _large(pieces: Pieces, min_cells: float, min_columns: float) -> NDArray[np.int32]:
    """(M,): connected parts of equal label, numbered anew in the order of the sweep, but for small ones: -1."""
    parts, part = pieces.parts()
    cells = np.bincount(part, pieces.stop - pieces.start, parts)
    west, east = np.full(parts, pieces.shape[1]), np.full(parts, -1)
    np.minimum.at(west, part, pieces.column)
    np.maximum.at(east, part, pieces.column)
    kept = (cells >= min_cells) & (east - west + 1 >= min_columns)
    kept[np.argmax(cells)] = True
    _, first = np.unique(part, return_index=True)
    number = np.full(parts, -1, np.int32)
    number[np.flatnonzero(kept)[np.argsort(first[kept])]] = np.arange(kept.sum())
    found: NDArray[np.int32] = number[part]
    return found


def _small_obstacles(obstacles: NDArray[np.bool_], min_obstacle: float) -> NDArray[np.bool_]:
    from scipy.ndimage import label

    groups, _ = label(obstacles, np.ones((3, 3)))
    small: NDArray[np.bool_] = np.bincount(groups.ravel()) < min_obstacle
    small[0] = False
    ignored: NDArray[np.bool_] = small[groups]
    return ignored


def _check(grid: Grid, overlap: float, smallest: tuple[float, ...], at_width: float) -> None:
    if grid.connectivity == "hex":
        raise InvalidProblemError("hexagonal cells came; a boustrophedon decomposition needs square ones")
    if not grid.passable.any():
        raise InvalidProblemError("every cell came as an obstacle; expected at least one free cell")
    if not 0.5 < overlap <= 1:
        raise InvalidProblemError(f"an overlap of {overlap} came; expected more than 0.5 and at most 1")
    if not (np.isfinite(smallest).all() and min(smallest) >= 0):
        raise InvalidProblemError(f"least sizes {smallest} came; expected numbers of at least 0")
    if not (np.isfinite(at_width) and at_width > 0):
        raise InvalidProblemError(f"a width of {at_width} columns came; expected a positive number")
