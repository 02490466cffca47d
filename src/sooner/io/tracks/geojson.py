"""GeoJSON: lines whose points have times beside them, as their fourth number, or none.

Times stand in `properties` as `coordTimes`, `times`, `time` or `coordinateProperties.times`, in the geometry as
`times`, or, as CalTopo records tracks, behind longitude, latitude and altitude.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import nan
from pathlib import Path
from typing import Any, NoReturn

from sooner.io.reading import bytes_of, text_of
from sooner.io.tracks.fixes import Fixes, Recorded, moment, number, place, refusal

__all__ = ["read_geojson"]

MOST_BYTES = 50_000_000  # in memory it takes ten times as much
MILLISECONDS = 1e11  # numbers above count them: as seconds they would lie beyond the year 5000
_KEYS = ("coordTimes", "times", "time")
_EXPECTED = "expected GeoJSON with a LineString or a MultiLineString"


def read_geojson(path: Path) -> list[Recorded]:
    """The lines of a GeoJSON file; between lines of a MultiLineString nothing is known."""
    text = text_of(path, bytes_of(path, MOST_BYTES, "50 MB", _EXPECTED), _EXPECTED)

    def refuse(said: str) -> NoReturn:
        raise refusal(path, "", f"{said} came, which is no number", _EXPECTED)

    try:
        said = json.loads(text, parse_constant=refuse)
    except (json.JSONDecodeError, RecursionError) as error:
        raise refusal(path, "", f"it is not JSON ({error})", _EXPECTED) from None
    except ValueError as error:
        if hasattr(error, "faults"):
            raise
        raise refusal(path, "", f"it is not JSON ({error})", _EXPECTED) from None  # a number of thousands of digits
    return [_recorded(path, f"feature {number}", *each) for number, each in enumerate(_lines(path, said))]


def _lines(path: Path, said: Any) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Properties and geometry of every line."""
    if not isinstance(said, dict):
        raise refusal(path, "", "something else than an object came", _EXPECTED)
    features = said.get("features") if said.get("type") == "FeatureCollection" else [said]
    if not isinstance(features, list):
        raise refusal(path, "features", "no list came", _EXPECTED)
    for feature in features:
        if not isinstance(feature, dict):
            raise refusal(path, "features", "something else than an object came", _EXPECTED)
        geometry = feature.get("geometry") if feature.get("type") == "Feature" else feature
        properties = feature.get("properties") or {}
        if isinstance(geometry, dict) and geometry.get("type") in ("LineString", "MultiLineString"):
            yield properties if isinstance(properties, dict) else {}, geometry


def _recorded(path: Path, key: str, properties: dict[str, Any], geometry: dict[str, Any]) -> Recorded:
    single = geometry["type"] == "LineString"
    parts = _list(path, key, [geometry.get("coordinates")] if single else geometry.get("coordinates"))
    times = _times(properties, geometry)
    parted = [times] if single or times is None else _list(path, key, times)
    if times is not None and len(parted) != len(parts):
        raise refusal(path, key, f"{len(parts)} lines and {len(parted)} lists of times came", "expected as many")
    fixes = Fixes(path)
    for which, part in enumerate(parts):
        fixes.begin()
        _add(path, key, fixes, _list(path, key, part), None if times is None else parted[which])
    name = properties.get("title") or properties.get("name") or ""
    return fixes.recorded(str(name)[:200], "sea", "utc")


def _times(properties: dict[str, Any], geometry: dict[str, Any]) -> Any:
    """What stands where times stand; None where nothing does."""
    nested = properties.get("coordinateProperties")
    places = (properties, nested if isinstance(nested, dict) else {}, geometry)
    return next((place[key] for place in places for key in _KEYS if isinstance(place.get(key), list)), None)


def _add(path: Path, key: str, fixes: Fixes, points: list[Any], times: Any) -> None:
    if times is not None and len(_list(path, key, times)) != len(points):
        raise refusal(path, key, f"{len(points)} points and {len(times)} times came", "expected as many")
    for which, point in enumerate(points):
        if not (isinstance(point, list) and len(point) >= 2):
            raise refusal(path, key, f"{str(point)[:60]} came for a point", "expected [longitude, latitude]")
        when = times[which] if times is not None else next(iter(point[3:4]), None) or None  # 0: not known
        up = nan if len(point) < 3 or point[2] is None else number(path, key, point[2])
        fixes.add(*place(path, key, point[1], point[0]), _seconds(path, key, when), up)


def _seconds(path: Path, key: str, said: Any) -> float:
    if said is None:
        return nan
    if isinstance(said, str):
        return moment(path, key, said)
    found = number(path, key, said, "expected a time: a text, or seconds or milliseconds since 1970")
    return found / 1000.0 if abs(found) > MILLISECONDS else found


def _list(path: Path, key: str, said: Any) -> list[Any]:
    if not isinstance(said, list):
        raise refusal(path, key, f"{str(said)[:60]} came", "expected a list")
    return said
