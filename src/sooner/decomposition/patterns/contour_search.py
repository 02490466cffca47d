"""The contour search (OS), around mountains and along valleys [IAMSAR2019, vol. III, sec. 12]."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from sooner.decomposition.patterns.contour_lines import contour_lines
from sooner.decomposition.patterns.legs import (
    Tracks,
    checked_ground,
    checked_number,
    checked_place,
    joined,
)
from sooner.errors import InvalidProblemError

__all__ = ["contour_search"]

_SHORT = 0.5  # track spacings: lines that are shorter are left out, as those round every stone
_MAX_HEIGHTS = 1000  # each of them walks over the whole raster


def contour_search(
    free: Any,
    elevation: ArrayLike,
    cell_m: float,
    *,
    rise: float | None = None,
    spacing: float | None = None,
    origin: ArrayLike = (0.0, 0.0),
) -> Tracks:
    """Along contour lines from the highest to the lowest, circuit after circuit.

    The first line lies half an interval below the highest free ground; what is shorter than half a track spacing is
    left out. Of the lines of one height, the nearest comes first, and a circuit begins where it is nearest.

    Parameters
    ----------
    free : (Multi)Polygon      where the drone may be, metres; lines that leave it are cut
    elevation : (H, W) float   metres at cells' centres, row 0 in the north; NaN where nobody knows, no line there
    cell_m : float             metres
    rise : float               metres of height between lines; the manual's aircraft fly 150 to 300 m
    spacing : float            or metres over the ground between lines in the mean: rise = spacing times mean slope,
                               as lines of an area A with mean slope s are s A / rise long in all (coarea formula)
    origin : (2,) float        the centre of the south-west cell, metres

    Returns
    -------
    tuple of (n, 2) float      tracks in the order of flight

    Raises
    ------
    InvalidProblemError        if not one of rise and spacing came, the ground is level or without elevation, the raster
                               is not one, or a number makes no sense

    Examples
    --------
    >>> south = np.repeat(np.arange(5.0)[:, None], 6, axis=1) * 10
    >>> contour_search(shapely.box(0, 0, 50, 40), south, 10.0, rise=20.0)
    (array([[ 0., 10.],
           [50., 10.],
           [50., 30.],
           [ 0., 30.]]),)
    """
    free, cell_m = checked_ground(free), checked_number("cell", cell_m)
    heights, place = _checked_heights(elevation), checked_place("origin", origin)
    known = _free_heights(free, heights, cell_m, place)
    rise, spacing = _interval(heights, known, cell_m, rise, spacing)
    low, high = float(heights[known].min()), float(heights[known].max())
    count = int(np.ceil((high - low) / rise - 1e-9))
    if count > _MAX_HEIGHTS:
        raise InvalidProblemError(f"{count} heights would come of an interval of {rise} m; expected fewer")
    flown: list[NDArray[np.float64]] = []
    for level in high - rise * (np.arange(max(count, 1)) + 0.5):
        parts = _inside(contour_lines(heights, cell_m, float(level), place), free, _SHORT * spacing)
        flown += _nearest_first(parts, flown[-1][-1] if flown else None)
    return joined(flown, free)


def _inside(lines: list[NDArray[np.float64]], free: Any, shortest: float) -> list[NDArray[np.float64]]:
    """What of the lines is free, without short parts; none of them crosses itself, so that they are cut whole."""
    if not lines:
        return []
    shapely.prepare(free)
    whole = np.array([shapely.linestrings(line) for line in lines])
    whole = whole[shapely.length(whole) > shortest]
    inside = shapely.covers(free, whole)
    cut = shapely.get_parts(shapely.line_merge(shapely.intersection(whole[~inside], free)))
    parts = np.concatenate([whole[inside], cut])
    return [shapely.get_coordinates(part) for part in parts[shapely.length(parts) > shortest]]


def _nearest_first(parts: list[NDArray[np.float64]], here: NDArray[np.float64] | None) -> list[NDArray[np.float64]]:
    """Lines of one height, each from the end, or if it is closed the corner, that is nearest to where one is."""
    if not parts:
        return []
    ends = np.array([(part[0], part[-1]) for part in parts])
    closed = (ends[:, 0] == ends[:, 1]).all(axis=1)
    lines = np.array([shapely.linestrings(part) for part in parts])
    here = parts[0][0] if here is None else here
    flown, left = [], np.full(len(parts), True)
    for _ in parts:
        apart = np.where(closed, shapely.distance(lines, shapely.points(here)), np.hypot(*(ends - here).T).min(axis=0))
        nearest = int(np.argmin(np.where(left, apart, np.inf)))
        flown.append(_from_nearest(parts[nearest], here))
        left[nearest], here = False, flown[-1][-1]
    return flown


def _from_nearest(part: NDArray[np.float64], here: NDArray[np.float64]) -> NDArray[np.float64]:
    if np.array_equal(part[0], part[-1]):
        first = int(np.argmin(np.hypot(*(part[:-1] - here).T)))
        return np.concatenate([part[first:-1], part[:first], part[first : first + 1]])
    return part if np.hypot(*(part[0] - here)) <= np.hypot(*(part[-1] - here)) else part[::-1]


def _interval(
    heights: NDArray[np.float64], known: NDArray[np.bool_], cell_m: float, rise: float | None, spacing: float | None
) -> tuple[float, float]:
    """Metres of height between lines, and in the mean over the ground."""
    if (rise is None) == (spacing is None):
        raise InvalidProblemError(f"rise {rise} and spacing {spacing} came; expected one of them")
    if np.ptp(heights[known]) <= 0:
        raise InvalidProblemError("level ground came, which has no contour lines; expected slopes")
    north, east = np.gradient(heights, cell_m)
    slopes = np.hypot(north, east)[known]
    slopes = slopes[np.isfinite(slopes)]
    slope = float(slopes.mean()) if len(slopes) else 0.0
    if not slope > 0:
        raise InvalidProblemError("elevation of single cells came; expected slopes between neighbours")
    if spacing is None:
        rise = checked_number("rise", float(rise or 0.0))
        return rise, rise / slope
    return checked_number("track spacing", spacing) * slope, float(spacing)


def _free_heights(
    free: Any, heights: NDArray[np.float64], cell_m: float, origin: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(H, W): cells whose centre is free and whose height is known."""
    rows, cols = np.indices(heights.shape)
    shapely.prepare(free)
    x, y = origin[0] + cols * cell_m, origin[1] + (heights.shape[0] - 1 - rows) * cell_m
    known: NDArray[np.bool_] = shapely.intersects_xy(free, x, y) & np.isfinite(heights)
    if not known.any():
        raise InvalidProblemError("no elevation came for the free ground; expected some at cells' centres")
    return known


def _checked_heights(elevation: ArrayLike) -> NDArray[np.float64]:
    heights = np.asarray(elevation, float)
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise InvalidProblemError(f"elevation of shape {heights.shape} came; expected two rows and columns or more")
    if np.isinf(heights).any():
        raise InvalidProblemError("an infinite elevation came; expected metres, or NaN where nobody knows")
    return heights
