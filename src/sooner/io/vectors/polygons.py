"""The polygons among features, as one area; a border that crosses itself is refused, and said where."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import shapely

from sooner.errors import InvalidProblemError
from sooner.io.vectors.feature import Feature

__all__ = ["crossing", "polygons_of"]

_PLACE = re.compile(r"\[(-?[0-9.eE+]+) (-?[0-9.eE+]+)\]")


def crossing(geometry: Any) -> str:
    """What is wrong with a polygon's borders and where, in words; "" for what is right.

    >>> crossing(shapely.Polygon([(0, 0), (2, 2), (2, 0), (0, 2)]))
    'a border that crosses itself at longitude 1, latitude 1 came'
    """
    for part in shapely.get_parts(geometry):
        if part.geom_type != "Polygon" or part.is_valid:
            continue
        reason = str(shapely.is_valid_reason(part))
        place = _PLACE.search(reason)
        where = f" at longitude {float(place[1]):.6g}, latitude {float(place[2]):.6g}" if place else ""
        what = reason.partition("[")[0].strip().lower()
        if "self-intersection" in what or "ring" in what:
            return f"a border that crosses itself{where} came"
        return f"a polygon that is none ({what}{where}) came"
    return ""


def polygons_of(features: Iterable[Feature]) -> Any:
    """All polygons of these features, joined; holes are kept. Points and lines are passed over.

    Where there is no polygon at all, lines that end where they begin are borders: GPX has no polygons.

    Returns
    -------
    Polygon or MultiPolygon     empty where there is none

    Raises
    ------
    InvalidProblemError         if a border crosses itself, or two polygons cannot be joined
    """
    parts = [(feature.name, part) for feature in features for part in shapely.get_parts(feature.geometry)]
    named = [(name, part) for name, part in parts if part.geom_type == "Polygon"]
    named = named or [
        (name, shapely.Polygon(part)) for name, part in parts if part.geom_type == "LineString" and _is_border(part)
    ]
    for name, part in named:
        if wrong := crossing(part):
            raise InvalidProblemError(f"{name}: {wrong}" if name else wrong)
    found = [part for _, part in named]
    if not found:
        return shapely.MultiPolygon()
    return found[0] if len(found) == 1 else shapely.union_all(np.array(found, dtype=object))


def _is_border(line: Any) -> bool:
    return bool(line.is_closed) and shapely.get_num_coordinates(line) > 3
