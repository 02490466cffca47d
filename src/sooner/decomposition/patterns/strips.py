"""Strips of ground and the leg that sees all of each: lanes that leave no gap between them."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.decomposition.patterns.legs import MAX_LEGS, Tracks, clipped
from sooner.errors import InvalidProblemError

__all__ = ["strip_legs"]


def strip_legs(ground: Any, free: Any, radius: float, spacing: float) -> Tracks:
    """Legs to the east, one or more for each strip of the ground, from which a disc sees all of the strip.

    The ground is cut into the fewest strips of equal width s, at most the spacing. From the middle of a strip the disc
    sees its edges a = sqrt(R^2 - s^2 / 4) ahead, so that a leg may begin and end by that much inside of what lies in
    the strip. Where the free ground does not reach so far, it ends there, and a gap is left.

    Parameters
    ----------
    ground : (Multi)Polygon    what is to be seen, metres
    free : (Multi)Polygon      where the drone may be
    radius : float             R, metres
    spacing : float            metres, at most 2 R

    Returns
    -------
    tuple of (2, 2) float      legs, from south to north and west to east; some may be one place

    Examples
    --------
    >>> field = shapely.box(0, 0, 100, 30)
    >>> [leg.tolist() for leg in strip_legs(field, field, radius=12.5, spacing=15.0)]
    [[[10.0, 7.5], [90.0, 7.5]], [[10.0, 22.5], [90.0, 22.5]]]
    """
    if ground.is_empty:
        return ()
    west, south, east, north = ground.bounds
    count = max(1, np.ceil((north - south) / spacing - 1e-9))
    if not count <= MAX_LEGS:
        raise InvalidProblemError(f"{count:.0f} strips would come of a spacing of {spacing} m; expected fewer")
    edges = np.linspace(south, north, int(count) + 1)
    width = float(edges[1] - edges[0])
    shapely.prepare(ground)
    inside = shapely.intersection(ground, shapely.box(west, edges[:-1], east, edges[1:]))
    ahead = np.sqrt(max(radius**2 - width**2 / 4, 0.0))
    legs = [_leg(part, free, width, ahead) for strip in inside for part in _parts(strip)]
    return tuple(piece for leg in legs for piece in _flown(leg, free))


def _parts(strip: Any) -> list[Any]:
    """Polygons of a strip, from the west."""
    parts = [part for part in shapely.get_parts(strip) if part.geom_type == "Polygon" and part.area > 0]
    return sorted(parts, key=lambda part: float(part.bounds[0]))


def _leg(part: Any, free: Any, width: float, ahead: float) -> NDArray[np.float64]:
    """(2, 2): the leg that sees a part of a strip; of those that do, the one that lies most in free ground."""
    west, south, east, north = part.bounds
    west, east = (west + ahead, east - ahead) if east - west > 2 * ahead else ((west + east) / 2,) * 2
    lowest, highest = north - width / 2, south + width / 2
    heights = np.linspace(lowest, highest, 5)[[2, 1, 3, 0, 4]] if highest - lowest > 1e-6 * width else [lowest]
    legs = [np.array([(west, height), (east, height)]) for height in heights]
    inside = [shapely.intersection(_line(leg), free).length for leg in legs] if east > west else _holds(legs, free)
    return legs[int(np.argmax(inside))]


def _holds(legs: list[NDArray[np.float64]], free: Any) -> NDArray[np.bool_]:
    x, y = np.array([leg[0] for leg in legs]).T
    out: NDArray[np.bool_] = shapely.intersects_xy(free, x, y)
    return out


def _flown(leg: NDArray[np.float64], free: Any) -> Tracks:
    """What of a leg is free."""
    if np.array_equal(leg[0], leg[1]):
        return (leg,) if _holds([leg], free)[0] else ()
    return clipped(leg, free)


def _line(leg: NDArray[np.float64]) -> Any:
    return shapely.linestrings(leg)
