"""GPX: waypoints as points, routes and tracks as lines."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sooner.io.markup import Element, tree
from sooner.io.vectors import build
from sooner.io.vectors.feature import Drawn, refusal

__all__ = ["gpx"]

EXPECTED = "expected GPX with waypoints, routes or tracks"
KINDS = {"wpt": "waypoint", "rte": "route", "trk": "track"}


def gpx(path: Path, data: bytes) -> list[Drawn]:
    """Every waypoint, route and track; routes and tracks of less than two places are passed over."""
    root = tree(path, data, EXPECTED)
    if root.tag != "gpx":
        raise refusal(path, "", f"a root <{root.tag[:40]}> came", EXPECTED)
    drawn = []
    for number, each in enumerate(root.all(*KINDS)):
        name = each.said("name")
        key = f"{each.tag} {number + 1}" + (f" ({name[:40]})" if name else "")
        try:
            geometry = _geometry(each)
        except ValueError as error:
            raise refusal(path, key, str(error), EXPECTED) from None
        if geometry is not None:
            drawn.append(Drawn(key, name, KINDS[each.tag], geometry, dict(_properties(each))))
    return drawn


def _properties(each: Element) -> Iterator[tuple[str, Any]]:
    for part in each.parts:
        if not part.parts and part.tag != "name" and part.text:
            yield part.tag, part.text


def _geometry(each: Element) -> Any | None:
    if each.tag == "wpt":
        return build.point(_place(each))
    lines = [each.all("rtept")] if each.tag == "rte" else [part.all("trkpt") for part in each.all("trkseg")]
    places = [[_place(place) for place in line] for line in lines]
    long_enough = [build.line(line) for line in places if len(line) > 1]
    return build.many(long_enough) if long_enough else None


def _place(each: Element) -> list[float]:
    try:
        return [float(each.attributes["lon"]), float(each.attributes["lat"])]
    except (KeyError, ValueError):
        raise ValueError("a point without lat and lon in degrees came") from None
