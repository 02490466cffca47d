"""Ways around obstacles: shortest over cells, straight where one sees, taut in between."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InfeasibleProblemError, InvalidProblemError, UnsupportedProblemError
from sooner.grid._path_kernels import TOUCH, clear, shortcut, slide, spread, trace, turning
from sooner.grid.grid import Grid

__all__ = [
    "centres_of",
    "distances_m",
    "geodesic",
    "line_is_clear",
    "pruned",
    "rows_and_cols",
    "shortest_path",
    "string_pulled",
    "turns_rad",
    "way",
]

MARKS = 64  # cell centres along a leg at which a string may bend anew


def shortest_path(grid: Grid, start: int, goal: int) -> NDArray[np.int64]:
    """Cells of a shortest 8-connected way between two cells that cuts no obstacle's corner.

    length = cell_m (straight steps + sqrt(2) diagonal steps)            [Kuhlman2017, sec. 5.3]

    The search is held to a window around both cells, which grows until no way that leaves it could be shorter; so a
    short way on a large map is cheap. Of equally long ways it is always the same one, which seldom turns.

    Parameters
    ----------
    grid : Grid                squares; 8 neighbours are used whatever the grid's own connectivity
    start, goal : int          cell numbers

    Returns
    -------
    (n,) int64                 cell numbers, start and goal included

    Raises
    ------
    InfeasibleProblemError     if there is no way

    Examples
    --------
    >>> shortest_path(Grid((3, 4)), 0, 11)
    array([ 0,  5, 10, 11])
    """
    height, width = _squares(grid)
    _check_cells(grid, [start, goal])
    ends = np.array([grid.cell(start), grid.cell(goal)])
    low, high = ends.min(axis=0), ends.max(axis=0)
    passable = grid.passable.reshape(height, width)
    pad = 8 + int((high - low).max()) // 4
    while True:
        (top, west), (bottom, east) = np.maximum(low - pad, 0), np.minimum(high + pad, [height - 1, width - 1])
        window = np.ascontiguousarray(passable[top : bottom + 1, west : east + 1])
        (row_a, col_a), (row_b, col_b) = ends - (top, west)
        span = window.shape[1]
        source, target = np.array([row_a * span + col_a]), int(row_b * span + col_b)
        straight, diagonal, _ = spread(window.ravel(), span, source, target)
        found = straight[target] + diagonal[target] * np.sqrt(2.0) if straight[target] >= 0 else np.inf
        if found <= _least_outside(ends, (top, west), (bottom, east), (height, width)):
            break
        pad *= 4
    if not np.isfinite(found):
        raise InfeasibleProblemError(
            f"no way leads from cell {list(grid.cell(start))} to {list(grid.cell(goal))}: obstacles part them"
        )
    rows, cols = np.divmod(trace(window.ravel(), span, straight, diagonal, target), span)
    return np.asarray((rows + top) * width + cols + west, np.int64)


def _least_outside(
    ends: NDArray[np.int64], low: tuple[int, int], high: tuple[int, int], shape: tuple[int, int]
) -> float:
    """Octile length, in cells, that a way between `ends` has at least if it leaves the window; inf if it cannot."""
    least = np.inf
    for axis in (0, 1):
        across = abs(int(ends[0, 1 - axis] - ends[1, 1 - axis]))
        sides = []
        if low[axis] > 0:
            sides.append(int((ends[:, axis] - (low[axis] - 1)).sum()))
        if high[axis] < shape[axis] - 1:
            sides.append(int((high[axis] + 1 - ends[:, axis]).sum()))
        for along in sides:
            least = min(least, max(along, across) + (np.sqrt(2.0) - 1.0) * min(along, across))
    return float(least)


def distances_m(grid: Grid, source: int) -> NDArray[np.float64]:
    """(N,) float: metres from a cell to every cell over 8 neighbours, corners not cut; inf where there is no way.

    >>> distances_m(Grid((2, 3), cell_m=2.0), 0).round(3)
    array([0.   , 2.   , 4.   , 2.   , 2.828, 4.828])
    """
    return geodesic(grid, [source])[1]


def geodesic(grid: Grid, sources: ArrayLike) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The nearest source of every cell around obstacles, and how far it is.

    distance_i = min over sources s of the length of `shortest_path(s, i)`

    Parameters
    ----------
    grid : Grid
    sources : (S,) int         cell numbers

    Returns
    -------
    owner : (N,) int32         index into `sources`, the lowest of those equally near; -1 where there is no way
    distance_m : (N,) float    metres; inf where there is no way

    Examples
    --------
    >>> owner, distance = geodesic(Grid((1, 5)), [0, 4])
    >>> owner, distance
    (array([0, 0, 0, 1, 1], dtype=int32), array([0., 1., 2., 1., 0.]))
    """
    _, width = _squares(grid)
    cells = np.asarray(sources, np.int64).reshape(-1)
    _check_cells(grid, cells)
    straight, diagonal, owner = spread(grid.passable, width, cells, -1)
    metres = grid.cell_m * (straight + np.sqrt(2.0) * diagonal)
    return owner, np.where(straight >= 0, metres, np.inf)


def line_is_clear(grid: Grid, a: ArrayLike, b: ArrayLike) -> bool:
    """Whether the straight line between two points stays on the map and touches no obstacle.

    An obstacle is its whole square, edges and corners included (to 1e-9 of a cell), so that a clear line never cuts the
    corner of an obstacle, as no diagonal step does.

    Parameters
    ----------
    grid : Grid
    a, b : (2,) float          metres east and north in the frame of `Grid.centres_m`

    Examples
    --------
    >>> grid = Grid((2, 2), obstacles=np.array([[False, True], [False, False]]))
    >>> line_is_clear(grid, (0, 0), (1, 0)), line_is_clear(grid, (0, 1), (1, 0))
    (True, False)
    """
    height, width = _squares(grid)
    ends = rows_and_cols(grid, np.array([a, b], np.float64))
    if not _on_map(ends, height, width):
        return False
    return bool(clear(grid.passable, width, *ends[0], *ends[1]))


def turns_rad(points: ArrayLike) -> NDArray[np.float64]:
    """(n - 2,) float: angle in [0, pi] by which the way turns at every inner point; 0 where a leg has no length.

    >>> turns_rad([[0, 0], [1, 0], [1, 1], [1, 0]]).round(3)
    array([1.571, 3.142])
    """
    steps = np.diff(np.asarray(points, np.float64), axis=0)
    before, after = steps[:-1], steps[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(np.arctan2(np.abs(cross), (before * after).sum(axis=1)))


def pruned(path: ArrayLike, degrees: float = 5.0) -> NDArray[np.float64]:
    """The waypoints at which a way turns.

    keep r_i  only if  angle(r_i - r_(i-1), r_(i+1) - r_i) > threshold    [Kuhlman2017, sec. 5.3]

    where r_(i-1) is the waypoint kept last. Staircases stay, as every step of theirs turns by 45 degrees;
    `string_pulled` takes them out. Over cells every turn is 45 degrees or more; so the legs of a pruned way are clear.

    Parameters
    ----------
    path : (n, 2) float        metres
    degrees : float            threshold

    Examples
    --------
    >>> pruned([[0, 0], [1, 0], [2, 0], [3, 1]])
    array([[0., 0.],
           [2., 0.],
           [3., 1.]])
    """
    points = np.asarray(path, np.float64)
    return np.asarray(points[turning(points, np.radians(degrees))])


def string_pulled(grid: Grid, path: ArrayLike) -> NDArray[np.float64]:
    """A way pulled taut between its ends, like a string around the obstacles.

    Three steps take turns until none of them shortens the way: keep the shortest sequence of waypoints in which each
    sees the next (exact, by dynamic programming); move waypoints by single cells; let bends become several, by the
    first step over cell centres along a few legs at a time. So the result is never longer, is clear, and pulling it
    again changes nothing. It is taut, not the shortest of all: it may stay on the longer side of an obstacle.

    Parameters
    ----------
    grid : Grid
    path : (n, 2) float        metres in the frame of `Grid.centres_m`, n >= 1; its legs are clear

    Raises
    ------
    InvalidProblemError        if a leg of the path is not clear

    Examples
    --------
    >>> grid = Grid((3, 9))
    >>> string_pulled(grid, centres_of(grid, shortest_path(grid, 0, 26)))
    array([[0., 2.],
           [8., 0.]])
    """
    height, width = _squares(grid)
    points = np.asarray(path, np.float64)
    places = rows_and_cols(grid, points)
    for k in range(len(places) - 1):
        if not line_is_clear(grid, points[k], points[k + 1]):
            raise InvalidProblemError(
                f"leg {k} of the path, {points[k].tolist()} to {points[k + 1].tolist()}, touches an obstacle or leaves"
                " the map; expected a path whose legs are clear"
            )
    changed = False
    while len(places) > 2:
        taut = _tightened(grid.passable.reshape(height, width), places)
        if _length(taut) > _length(places) - TOUCH and len(taut) >= len(places):
            break
        places, changed = taut, True
    return _metres(grid, places) if changed else points


def way(grid: Grid, start: int, goal: int, taut: bool = False) -> NDArray[np.float64]:
    """Waypoints between two cells: a straight line if that is clear, else a shortest way over cells.

    Parameters
    ----------
    grid : Grid
    start, goal : int          cell numbers
    taut : bool                False: the paper's rule, `pruned`; True: `string_pulled`, which is shorter

    Returns
    -------
    (n, 2) float               metres in the frame of `Grid.centres_m`, both centres included; (1, 2) if they are one

    Examples
    --------
    >>> grid = Grid((3, 3), obstacles=np.array([[0, 0, 0], [0, 1, 0], [0, 0, 0]], bool))
    >>> way(grid, 0, 2)
    array([[0., 2.],
           [2., 2.]])
    >>> len(way(grid, 3, 5))
    4
    """
    _check_cells(grid, [start, goal])
    ends = centres_of(grid, [start, goal])
    if start == goal:
        return ends[:1]
    if line_is_clear(grid, *ends):
        return ends
    points = centres_of(grid, shortest_path(grid, start, goal))
    return string_pulled(grid, points) if taut else pruned(points)


def centres_of(grid: Grid, cells: ArrayLike) -> NDArray[np.float64]:
    """(n, 2) float: metres east and north of square cells; rows of `Grid.centres_m` without making that table."""
    height, width = _squares(grid)
    rows, cols = np.divmod(np.asarray(cells, np.int64), width)
    return np.stack([cols, height - 1 - rows], axis=-1) * float(grid.cell_m)


def rows_and_cols(grid: Grid, points: ArrayLike) -> NDArray[np.float64]:
    """(n, 2) float: row and column, as fractions, of points in metres; whole at the centres of square cells."""
    height, _ = _squares(grid)
    east, north = np.moveaxis(np.asarray(points, np.float64), -1, 0) / grid.cell_m
    return np.stack([height - 1 - north, east], axis=-1)


def _metres(grid: Grid, places: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([places[:, 1], grid.shape[0] - 1 - places[:, 0]], axis=-1) * grid.cell_m


def _length(places: NDArray[np.float64]) -> float:
    return float(np.hypot(*np.diff(places, axis=0).T).sum())


def _tightened(passable: NDArray[np.bool_], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """One round of `string_pulled` over (row, column) places."""
    flat, width = passable.ravel(), passable.shape[1]
    places = places[np.append(True, np.any(np.diff(places, axis=0) != 0, axis=1))]
    bends = places[np.concatenate([[True], turns_rad(places) > TOUCH, [True]])] if len(places) > 1 else places
    kept = shortcut(flat, width, bends)
    places = bends[kept] if kept[0] == 0 else places[shortcut(flat, width, places)]  # 0: each sees the next still
    slide(flat, width, places)
    for k in range(len(places)):
        stop = _stretch(places, k)
        legs = places[k:stop]
        marks = _marked_out(passable, legs)
        taut = marks[shortcut(flat, width, marks)]
        if len(taut) < len(legs) or _length(taut) < _length(legs) - TOUCH:
            places = np.concatenate([places[:k], taut, places[stop:]])
        if stop >= len(places):
            break
    return places


def _stretch(places: NDArray[np.float64], k: int) -> int:
    """End of the longest run of places from k on with at most 3 MARKS marks between, or else of the next two legs."""
    counts = np.minimum(np.ceil(np.hypot(*np.diff(places[k:], axis=0).T)), MARKS)
    return k + max(int(np.searchsorted(np.cumsum(counts), 3 * MARKS, "right")) + 1, min(3, len(places) - k))


def _marked_out(passable: NDArray[np.bool_], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """The places of a way, and between them free cell centres nearest to it, one a cell and at most MARKS a leg."""
    marks = [places[:1]]
    for a, b in pairwise(places):
        count = min(int(np.ceil(np.hypot(*(b - a)))), MARKS)
        between = np.rint(a + (b - a) * (np.arange(1, count)[:, None] / max(count, 1)))
        rows, cols = np.clip(between.astype(np.int64), 0, np.array(passable.shape) - 1).T
        marks += [between[passable[rows, cols]], b[None]]
    return np.concatenate(marks)


def _on_map(places: NDArray[np.float64], height: int, width: int) -> bool:
    edge = 0.5 + TOUCH
    inside = (places >= -edge) & (places <= np.array([height, width]) - 1.0 + edge)
    return bool(inside.all())


def _squares(grid: Grid) -> tuple[int, int]:
    if grid.connectivity == "hex":
        raise UnsupportedProblemError("a hexagonal grid came; ways between cells are known on square cells only")
    return grid.shape


def _check_cells(grid: Grid, cells: ArrayLike) -> None:
    for cell in np.asarray(cells, np.int64).reshape(-1):
        if not 0 <= cell < grid.n_cells:
            raise InvalidProblemError(f"cell number {cell} came; expected 0 to {grid.n_cells - 1}")
        if not grid.passable[cell]:
            raise InvalidProblemError(f"cell {list(grid.cell(int(cell)))} is an obstacle; expected one to fly over")
