"""Geometry from numbers: points, lines and polygons, or a ValueError that says what is wrong with them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

__all__ = ["line", "many", "places_of", "point", "polygon"]

Floats = NDArray[np.float64]


def places_of(coordinates: Any) -> Floats:
    """(n, 2) float: the first two numbers of each place."""
    try:
        places = np.asarray(coordinates, np.float64)
    except (ValueError, TypeError, OverflowError):
        try:  # some places have heights, others none
            places = np.array([[float(place[0]), float(place[1])] for place in coordinates])
        except (ValueError, TypeError, IndexError, KeyError, OverflowError):
            raise ValueError("coordinates that are not pairs of numbers came") from None
    if places.ndim != 2 or not 2 <= places.shape[1] <= 4:
        raise ValueError("coordinates that are not pairs of numbers came")
    if not np.isfinite(places[:, :2]).all():
        raise ValueError("a coordinate that is not a finite number came")
    return np.ascontiguousarray(places[:, :2])


def point(coordinates: Any) -> Any:
    """A point."""
    return shapely.Point(places_of([coordinates])[0])


def line(coordinates: Any) -> Any:
    """A line, of at least two places."""
    places = places_of(coordinates)
    if len(places) < 2:
        raise ValueError(f"a line of {len(places)} place came")
    return shapely.LineString(places)


def polygon(rings: Sequence[Any]) -> Any:
    """A polygon: its border, then its holes. Borders are closed where the file leaves that out."""
    closed = [_ring(ring) for ring in rings]
    if not closed:
        raise ValueError("a polygon without a border came")
    return shapely.Polygon(closed[0], closed[1:])


def _ring(coordinates: Any) -> Floats:
    places = places_of(coordinates)
    away = places[(places != places[:1]).any(axis=1)]
    if not len(away) or not (away != away[0]).any():
        raise ValueError(f"a border of {len(places)} places came, and it takes three apart")
    return places


def many(parts: Iterable[Any]) -> Any:
    """Points, lines or polygons as one; of several kinds, the polygons, or else the lines."""
    found = [part for part in parts if not part.is_empty]
    for kind, join in (("Polygon", shapely.multipolygons), ("LineString", shapely.multilinestrings)):
        alike = [piece for part in found for piece in shapely.get_parts(part) if piece.geom_type == kind]
        if alike:
            return alike[0] if len(alike) == 1 else join(alike)
    if not found:
        raise ValueError("an empty geometry came")
    pieces = [piece for part in found for piece in shapely.get_parts(part)]
    return pieces[0] if len(pieces) == 1 else shapely.multipoints(pieces)
