"""Coverage paths: a region swept along parallel lines, as the ox plows [Kuhlman2017, sec. 5.3, fig. 4]."""

from __future__ import annotations

from bisect import insort
from itertools import pairwise
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sooner.decomposition.regions import Regions
from sooner.errors import InvalidProblemError
from sooner.grid import Grid, centres_of, rows_and_cols, way

__all__ = ["SWEEP_ORDERS", "SweepOrder", "coverage_path", "coverage_paths", "plow_lines"]

SweepOrder = Literal["west north", "west south", "east north", "east south"]
SWEEP_ORDERS: tuple[SweepOrder, ...] = get_args(SweepOrder)

_Cell = tuple[int, int]
_Line = list[tuple[_Cell, _Cell]]  # the northmost and southmost cell of each interval of one column, from the north


def coverage_paths(
    grid: Grid,
    regions: Regions,
    region: int,
    spacing_m: float,
    inset_m: float = 0.0,
    radius_m: float | None = None,
) -> tuple[NDArray[np.float64], ...]:
    """The coverage path of a region in each of the four `SWEEP_ORDERS`; parameters and errors as `coverage_path`.

    The fastest of them is a region's search: `min(coverage_paths(...), key=Dynamics(v_max, a_max).seconds)`.
    """
    return tuple(coverage_path(grid, regions, region, spacing_m, order, inset_m, radius_m) for order in SWEEP_ORDERS)


def coverage_path(
    grid: Grid,
    regions: Regions,
    region: int,
    spacing_m: float,
    order: SweepOrder = "west north",
    inset_m: float = 0.0,
    radius_m: float | None = None,
) -> NDArray[np.float64]:
    """From a region's centre along all its plow lines and back to the centre.

    Lines follow one another from west or east. Each is flown from the end that is nearer to the end of the line
    before, the first from the north or south; of the intervals of a line, those ends are nearest first. From line to
    line the drone flies rectilinearly: along a row and a column, whichever first is clear of obstacles; where neither
    is, and to and from the centre, as `grid.way` does. The path may leave the region, but never free ground.

    Parameters
    ----------
    grid : Grid                square cells
    regions : Regions          of that grid
    region : int
    spacing_m, inset_m, radius_m : float
                               as `plow_lines`
    order : str                one of `SWEEP_ORDERS`: the side on which the first line lies, and the end it begins at

    Returns
    -------
    (n, 2) float               waypoints, metres in the frame of `Grid.centres_m`, the first and last the centre; all
                               lie on cells' centres. One only if the region is searched without moving

    Raises
    ------
    InvalidProblemError        if the regions are another grid's, or a number or the order makes no sense

    Notes
    -----
    The paper does not say from which end a line is flown; in most regions the nearer end makes the ox's turn.
    A line whose neighbour ends elsewhere is flown back in part: an L joins them, as a slanting line would cut corners.

    Examples
    --------
    >>> grid = Grid((3, 6))
    >>> coverage_path(grid, Regions.from_labels(grid, np.zeros((3, 6), np.int32)), 0, spacing_m=3.0)
    array([[2., 1.],
           [1., 2.],
           [1., 0.],
           [4., 0.],
           [4., 2.],
           [2., 1.]])
    """
    if order not in SWEEP_ORDERS:
        raise InvalidProblemError(f"order {order!r} came; expected one of {', '.join(map(repr, SWEEP_ORDERS))}")
    lines = plow_lines(grid, regions, region, spacing_m, inset_m, radius_m)
    side, end = order.split()
    flown = _ends_in_order(lines if side == "west" else lines[::-1], end == "south")
    centre = int(regions.centres[region])
    path = [_way(grid, grid.cell(centre), flown[0])]
    path += [_rectilinear(grid, a, b) for a, b in pairwise(flown)]
    path.append(_way(grid, flown[-1], grid.cell(centre)))
    return centres_of(grid, _without_stops(np.concatenate(path)) @ (grid.shape[1], 1))


def plow_lines(
    grid: Grid,
    regions: Regions,
    region: int,
    spacing_m: float,
    inset_m: float = 0.0,
    radius_m: float | None = None,
) -> list[_Line]:
    """Columns to fly along in a region, from the west, and where each begins and ends.

    The fewest lines that lie no further apart than the spacing, each in the middle of an equal share of the region's
    width, rounded to a column. Each runs to the region's last cells on it [Kuhlman2017, sec. 5.3]. Where the border is
    ragged, cells between lines may be seen from neither; a radius adds lines there until there are none.

    Parameters
    ----------
    grid : Grid
    regions : Regions
    region : int
    spacing_m : float          metres between lines: the sensing radius, or up to twice that
    inset_m : float            metres by which lines end before the region's border does; what is shorter than two
                               of them is flown over its middle
    radius_m : float           metres to which the drone sees, so that every cell of the region lies within that of a
                               line; None for the paper's lines

    Returns
    -------
    list of lines              each the intervals of one column: [row, col] of the northmost and southmost cell

    Examples
    --------
    >>> grid = Grid((3, 6))
    >>> plow_lines(grid, Regions.from_labels(grid, np.zeros((3, 6), np.int32)), 0, spacing_m=3.0)
    [[((0, 1), (2, 1))], [((0, 4), (2, 4))]]
    """
    inset = _checked_inset(grid, regions, spacing_m, inset_m, radius_m)
    cols = regions.box(region)[1]
    width = cols.stop - cols.start
    count = min(width, max(1, int(np.ceil(width * grid.cell_m / spacing_m - 1e-9))))
    columns = cols.start + (2 * np.arange(count) + 1) * width // (2 * count)
    lines = [_line(regions, region, int(col), inset) for col in columns]
    if radius_m is not None:
        while (col := _least_seen(regions, region, lines, radius_m / grid.cell_m)) is not None:
            insort(lines, _line(regions, region, col, inset), key=lambda line: line[0][0][1])
    return lines


def _line(regions: Regions, region: int, col: int, inset: int) -> _Line:
    """Both ends of each interval of a column that lies in the region."""
    rows = regions.box(region)[0]
    inside = np.concatenate([[False], regions.labels[rows, col] == region, [False]])
    first, past = np.flatnonzero(inside[1:] != inside[:-1]).reshape(-1, 2).T + rows.start
    shift = np.minimum(inset, (past - 1 - first) // 2)
    ends = zip((first + shift).tolist(), (past - 1 - shift).tolist(), strict=True)
    return [((north, col), (south, col)) for north, south in ends]


def _least_seen(regions: Regions, region: int, lines: list[_Line], radius: float) -> int | None:
    """The column of the region's cell furthest from all lines; None if that lies within the radius, in cells."""
    from scipy.ndimage import distance_transform_edt

    box = regions.box(region)
    off_lines = np.ones(tuple(side.stop - side.start for side in box), bool)
    for line in lines:
        for (north, col), (south, _) in line:
            off_lines[north - box[0].start : south + 1 - box[0].start, col - box[1].start] = False
    apart = np.where(regions.labels[box] == region, distance_transform_edt(off_lines), 0.0)
    furthest = int(np.argmax(apart))
    return furthest % apart.shape[1] + box[1].start if apart.flat[furthest] > radius * (1 + 1e-9) else None


def _ends_in_order(lines: list[_Line], south_first: bool) -> list[_Cell]:
    """The ends of all intervals in the order in which they are flown."""
    first, last = lines[0][0][0], lines[0][-1][-1]
    here = last if south_first else first
    flown: list[_Cell] = []
    for line in lines:
        left = list(line)
        while left:
            ends = [
                (abs(row - here[0]), k, end) for k, interval in enumerate(left) for end, (row, _) in enumerate(interval)
            ]
            _, nearest, end = min(ends)
            interval = left.pop(nearest)
            here = interval[1 - end]
            flown += [interval[end], here]
    return flown


def _rectilinear(grid: Grid, a: _Cell, b: _Cell) -> NDArray[np.int64]:
    """(n, 2) int: cells between which to fly straight, from a along a row and a column to b, if one way is clear."""
    for corner in ((a[0], b[1]), (b[0], a[1])):
        if _is_clear(grid, a, corner) and _is_clear(grid, corner, b):
            return np.array([a, corner, b])
    return _way(grid, a, b)


def _is_clear(grid: Grid, a: _Cell, b: _Cell) -> bool:
    """Whether all cells from one to another in its row or column are free."""
    (north, south), (west, east) = sorted((a[0], b[0])), sorted((a[1], b[1]))
    return bool(grid.passable.reshape(grid.shape)[north : south + 1, west : east + 1].all())


def _way(grid: Grid, a: _Cell, b: _Cell) -> NDArray[np.int64]:
    points = way(grid, grid.index(a), grid.index(b))
    return np.asarray(np.rint(rows_and_cols(grid, points)), np.int64)


def _without_stops(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """The same path without waypoints at which the drone neither turns nor ends: it stops at each."""
    cells = cells[np.append(True, (np.diff(cells, axis=0) != 0).any(axis=1))]
    (rows, cols), before, after = np.diff(cells, axis=0).T, slice(None, -1), slice(1, None)
    across = rows[before] * cols[after] - cols[before] * rows[after]
    along = rows[before] * rows[after] + cols[before] * cols[after]
    turns = (across != 0) | (along < 0)
    kept: NDArray[np.int64] = cells[np.concatenate([[True], turns, [True]])[: len(cells)]]
    return kept


def _checked_inset(grid: Grid, regions: Regions, spacing_m: float, inset_m: float, radius_m: float | None) -> int:
    """The inset in whole cells."""
    if regions.labels.shape != grid.shape:
        raise InvalidProblemError(f"regions of a map of shape {regions.labels.shape} came; the grid has {grid.shape}")
    if not (np.isfinite(spacing_m) and spacing_m > 0):
        raise InvalidProblemError(f"a spacing of {spacing_m} m came; expected a positive number")
    if not (np.isfinite(inset_m) and inset_m >= 0):
        raise InvalidProblemError(f"an inset of {inset_m} m came; expected a number of at least 0")
    inset = round(inset_m / grid.cell_m)
    if radius_m is not None and not (radius_m > 0 and radius_m >= inset * grid.cell_m):
        raise InvalidProblemError(
            f"a radius of {radius_m} m and an inset of {inset_m} m came; expected a radius above 0, not below the inset"
        )
    return inset
