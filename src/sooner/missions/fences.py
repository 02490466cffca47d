"""Fences: the ground that a flight must stay in and the obstacles that it must stay out of, as few plain polygons."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.io.flights import Fence
from sooner.io.georeference import Georeference
from sooner.missions.places import components

__all__ = ["CLEAR_M", "MOST_CORNERS", "fences"]

CLEAR_M = 5.0  # satellites place an aircraft to within a few metres: a fence nearer to its line would stop the flight
MOST_CORNERS = 100  # of all fences together; autopilots have memory for about as many
MOST_TURNS = 16  # of an obstacle that is fenced as it is
MOST_TRIED = 40  # fences
MOST_TRACED = 100_000  # turns of borders that are followed
AT_ONCE = 1 << 18  # pairs of points and legs whose distances are worked out together

Ring = NDArray[np.float64]


def fences(
    grid: Grid, ground: Georeference, line: NDArray[np.float64], closed: bool
) -> tuple[tuple[Fence, ...], tuple[str, ...]]:
    """Fences that a flight does not come near, and what is left out.

    The outline of the free ground that hangs together with the flight is to stay in, the obstacles within it are to
    stay out of, the largest first; for one that turns often the convex line around it stands, if the flight keeps clear
    of that. A fence is left out that has more corners than are left of `MOST_CORNERS`, and one that the flight comes
    within `CLEAR_M` of. Without obstacles there is none: the edge of a map forbids nothing.

    Parameters
    ----------
    grid : Grid             of square cells
    line : (n, 2) float     rows and columns that the flight passes, on free ground
    closed : bool           it comes straight back from the last to the first
    """
    if grid.obstacles is None:
        return (), ()
    free = grid.passable.reshape(grid.shape)
    if _turns(free) > MOST_TRACED:
        return (), (f"no fences: the borders of the obstacles turn more than {MOST_TRACED:,} times",)
    outline, holes = _outlines(free, line)
    rings = [(outline, True), *((hole, False) for hole in sorted(holes, key=_area, reverse=True))]
    flown = np.concatenate([line, line[:1]]) if closed else line
    kept, near, corners = [], 0, 0
    for ring, inclusion in rings[:MOST_TRIED]:
        fitting = [shape for shape in _shapes(ring, inclusion) if corners + len(shape) <= MOST_CORNERS]
        clear = next((shape for shape in fitting if _apart(flown, shape) * grid.cell_m >= CLEAR_M), None)
        if clear is not None:
            kept.append(Fence(_places(ground, clear), inclusion))
            corners += len(clear)
        elif fitting:
            near += 1
    return tuple(kept), _told(len(rings), near, len(rings) - len(kept) - near)


def _shapes(ring: Ring, inclusion: bool) -> list[Ring]:
    """What may stand for a border: itself, and for an obstacle that turns often first the convex line around it."""
    if inclusion or len(ring) <= MOST_TURNS:
        return [ring]
    from scipy.spatial import ConvexHull

    return [ring[ConvexHull(ring).vertices], ring]


def _places(ground: Georeference, ring: Ring) -> tuple[tuple[float, float], ...]:
    return tuple((float(lat), float(lon)) for lat, lon in ground.places(ring))


def _turns(free: NDArray[np.bool_]) -> int:
    """How often the borders of free ground turn: once where four cells that meet are one and three."""
    padded = np.pad(free, 1).astype(np.int8)
    return int(((padded[1:, 1:] + padded[1:, :-1] + padded[:-1, 1:] + padded[:-1, :-1]) % 2 == 1).sum())


def _told(count: int, near: int, many: int) -> tuple[str, ...]:
    told = []
    if near:
        told.append(f"{near} of {count} fences are left out: the flight comes within {CLEAR_M:g} m of them")
    if many:
        told.append(f"{many} of {count} fences are left out: they have more than {MOST_CORNERS} corners in all")
    return tuple(told)


def _outlines(free: NDArray[np.bool_], line: NDArray[np.float64]) -> tuple[Ring, list[Ring]]:
    """The outer border of the free ground around a flight, and the borders of what lies within."""
    from rasterio.features import shapes

    pieces = components(free)
    row, col = np.rint(line[0]).astype(int)
    held = pieces == pieces[row, col]
    ((polygon, _),) = shapes(held.astype(np.uint8), mask=held, connectivity=4)
    rings = [_corners(np.asarray(ring, np.float64)) for ring in polygon["coordinates"]]
    return rings[0], rings[1:]


def _corners(ring: Ring) -> Ring:
    """(m, 2) float: rows and columns where a border turns; GDAL tells columns and rows of the corners of pixels."""
    points = ring[:-1, ::-1] - 0.5
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    return np.asarray(points[before[:, 0] * after[:, 1] != before[:, 1] * after[:, 0]])


def _area(ring: Ring) -> float:
    ahead = np.roll(ring, -1, axis=0)
    return float(abs((ring[:, 0] * ahead[:, 1] - ring[:, 1] * ahead[:, 0]).sum()) / 2)


def _apart(line: NDArray[np.float64], ring: Ring) -> float:
    """Cells between a line and a border; 0 where it crosses it. Who does not cross and is near is near at an end."""
    border = np.concatenate([ring, ring[:1]])
    return 0.0 if _crosses(line, border) else min(_nearest(line, border), _nearest(border, line))


def _crosses(line: NDArray[np.float64], border: NDArray[np.float64]) -> bool:
    """Whether a leg of one has both ends of a leg of the other on different sides, and the other way round."""
    at_once = max(1, AT_ONCE // len(border))
    for first in range(0, len(line) - 1, at_once):
        part = line[first : first + at_once + 1]
        before, after = _sides(border, part)
        begins, ends = _sides(part, border)
        if ((before * after < 0) & (begins * ends < 0).T).any():
            return True
    return False


def _sides(points: NDArray[np.float64], line: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(l, p - 1) twice: how far to the side of each of l legs the first and the last of two neighbouring points lie."""
    legs, away = np.diff(line, axis=0)[:, None], points - line[:-1, None]
    aside = legs[..., 0] * away[..., 1] - legs[..., 1] * away[..., 0]
    return aside[:, :-1], aside[:, 1:]


def _nearest(points: NDArray[np.float64], line: NDArray[np.float64]) -> float:
    """Cells between a line and the nearest of these points, a few legs at a time, so that memory stays small."""
    least, at_once = float(np.hypot(*(points - line[0]).T).min()), max(1, AT_ONCE // len(points))
    for first in range(0, len(line) - 1, at_once):
        ends = line[first : first + at_once + 1]
        legs, away = np.diff(ends, axis=0), points[:, None] - ends[:-1]
        squares = np.maximum((legs**2).sum(axis=1), np.finfo(float).tiny)
        along = np.clip((away * legs).sum(axis=2) / squares, 0.0, 1.0)
        away -= along[:, :, None] * legs
        least = min(least, float((away**2).sum(axis=2).min()) ** 0.5)
    return least
