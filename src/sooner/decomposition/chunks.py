"""Regions cut further: at the borders of classes of ground, and into chunks of a few plow lines; slivers are joined."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.decomposition.regions import Pieces, Regions
from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["chunked", "tidied"]

ROWS = 64  # of the map at a time, where memory is what counts


def chunked(
    grid: Grid,
    regions: Regions,
    chunk_m: float = 17.6,
    classes: NDArray[np.integer] | None = None,
    min_m2: float = 200.0,
    tall_m: float = np.inf,
) -> Regions:
    """Cut regions at the borders of classes, and what is then wider than a chunk into equal shares of its columns.

    A search takes all of its region or nothing, so that smaller regions can be searched as often as each is worth
    [Kuhlman2017, sec. 5.3 and 8, where such a decomposition is left to future work]. What a cut leaves smaller than
    `min_m2` joins the neighbour with which it shares the longest border, one of its own class before all others.

    Parameters
    ----------
    grid : Grid
    regions : Regions          of that grid; ground in none of them stays in none
    chunk_m : float            metres from west to east; inf: only classes are parted
    classes : (H, W) int       class of each cell; None: all are one
    min_m2 : float             square metres of the least chunk

    Raises
    ------
    InvalidProblemError        if shapes differ or a number makes no sense

    Examples
    --------
    >>> grid = Grid((2, 8))
    >>> whole = Regions.from_labels(grid, np.zeros((2, 8), np.int32))
    >>> chunked(grid, whole, 3.0, np.arange(16).reshape(2, 8) % 8 // 6, min_m2=1.0).labels
    array([[0, 0, 0, 1, 1, 1, 2, 2],
           [0, 0, 0, 1, 1, 1, 2, 2]], dtype=int32)
    """
    if classes is not None and classes.shape != grid.shape:
        raise InvalidProblemError(f"classes of shape {classes.shape} came; the grid has {grid.shape}")
    if not (chunk_m > 0 and min_m2 >= 0):
        raise InvalidProblemError(f"chunks of {chunk_m} m, at least {min_m2} m2, came; expected positive numbers")
    kinds = np.zeros(grid.shape, np.int32) if classes is None else classes.astype(np.int32)
    pieces, _ = _cut(regions.labels, kinds)
    _, part = pieces.parts()
    pieces = pieces._replace(label=_shares(pieces, part, chunk_m / grid.cell_m))
    labels = _stacked(pieces, tall_m / grid.cell_m) if np.isfinite(tall_m) else pieces.painted(pieces.label)
    return tidied(grid, labels, kinds, min_m2 / grid.cell_m**2)


def tidied(grid: Grid, labels: NDArray[np.int32], kinds: NDArray[np.int32], min_cells: float) -> Regions:
    """Regions of connected ground of one label and kind, but for slivers, which join a neighbour."""
    pieces, kind = _cut(labels, kinds)
    parts, part = pieces.parts()
    found = _without_slivers(pieces, parts, part, kind, min_cells)
    return Regions.from_labels(grid, pieces.painted(_in_order(found)))


def _cut(labels: NDArray[np.int32], kinds: NDArray[np.int32]) -> tuple[Pieces, NDArray[np.int32]]:
    """Pieces of one label and kind, and the kind of each."""
    count = int(kinds.max()) + 1
    pieces = Pieces.of(np.where(labels >= 0, labels * np.int32(count) + kinds, np.int32(-1)))
    kind: NDArray[np.int32] = pieces.label % count
    return pieces, kind


def _shares(pieces: Pieces, part: NDArray[np.int32], columns: float) -> NDArray[np.int32]:
    """(M,): a number for each share of each part: as many equal ones as come nearest to so many columns."""
    column, parts = pieces.column, int(part.max()) + 1
    west, east = np.full(parts, pieces.shape[1]), np.zeros(parts, np.int64)
    np.minimum.at(west, part, column)
    np.maximum.at(east, part, column)
    width = east - west + 1
    shares = np.maximum(np.rint(width / columns), 1).astype(np.int64)
    before = np.cumsum(shares) - shares
    share = (column - west[part]) * shares[part] // width[part]
    return np.asarray(before[part] + share, np.int32)


def _stacked(pieces: Pieces, rows: float) -> NDArray[np.int32]:
    """(H, W): labels of each part in as many equal shares of its rows as come nearest to so many of them."""
    parts, part = pieces.parts()
    period = pieces.shape[0] + 1
    north, south = np.full(parts, period), np.zeros(parts, np.int64)
    np.minimum.at(north, part, pieces.start % period)
    np.maximum.at(south, part, (pieces.stop - 1) % period)
    height = south - north + 1
    shares = np.maximum(np.rint(height / rows), 1).astype(np.int64)
    before = np.cumsum(shares) - shares
    labels = pieces.painted(part)
    for top in range(0, len(labels), ROWS):
        some = labels[top : top + ROWS]
        row, col = np.nonzero(some >= 0)
        own = some[row, col]
        some[row, col] = before[own] + (row + top - north[own]) * shares[own] // height[own]
    return labels


def _without_slivers(
    pieces: Pieces, parts: int, part: NDArray[np.int32], kind: NDArray[np.int32], min_cells: float
) -> NDArray[np.int64]:
    """(M,): the part of each piece, once small ones have joined a neighbour, the smallest first."""
    cells = np.bincount(part, pieces.stop - pieces.start, parts).tolist()
    of_kind = np.zeros(parts, np.int64)
    of_kind[part] = kind
    borders = _borders(pieces, parts, part)
    into = list(range(parts))
    waiting = sorted((n for n in range(parts) if cells[n] < min_cells), key=lambda n: (cells[n], n))
    for small in waiting:
        if cells[small] >= min_cells or not borders[small]:
            continue
        near = max(borders[small], key=lambda n: (of_kind[n] == of_kind[small], borders[small][n], -n))
        into[small] = near
        cells[near] += cells[small]
        for other, length in borders.pop(small).items():
            del borders[other][small]
            if other != near:
                borders[near][other] = borders[other][near] = borders[near].get(other, 0) + length
    for n in range(parts):
        while into[into[n]] != into[n]:
            into[n] = into[into[n]]
    return np.array(into)[part]


def _borders(pieces: Pieces, parts: int, part: NDArray[np.int32]) -> dict[int, dict[int, int]]:
    """For each part, how many sides of cells it shares with each other."""
    west, east, shared = pieces.beside()
    above = np.flatnonzero(pieces.stop[:-1] == pieces.start[1:])
    pairs = np.column_stack([np.append(part[west], part[above]), np.append(part[east], part[above + 1])])
    lengths = np.append(shared, np.ones(len(above), np.int64))
    apart = pairs[:, 0] != pairs[:, 1]
    unique, which = np.unique(np.sort(pairs[apart], axis=1), axis=0, return_inverse=True)
    totals = np.bincount(which.ravel(), lengths[apart], len(unique)).astype(np.int64)
    borders: dict[int, dict[int, int]] = {n: {} for n in range(parts)}
    for (one, other), length in zip(unique.tolist(), totals.tolist(), strict=True):
        borders[one][other] = borders[other][one] = length
    return borders


def _in_order(found: NDArray[np.int64]) -> NDArray[np.int32]:
    """The same groups, numbered as they first come."""
    _, first, which = np.unique(found, return_index=True, return_inverse=True)
    number = np.empty(len(first), np.int32)
    number[np.argsort(first)] = np.arange(len(first))
    return number[which.ravel()]
