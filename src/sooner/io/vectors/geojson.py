"""GeoJSON [RFC 7946], and what CalTopo writes in it: shapes, markers and assignments."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from sooner.errors import printable
from sooner.io.reading import text_of
from sooner.io.vectors import build
from sooner.io.vectors.feature import Drawn, refusal

__all__ = ["geojson"]

MOST_BRACKETS = 2_000_000
EXPECTED = "expected GeoJSON: a FeatureCollection, a Feature or a geometry"
_EPSG = re.compile(r"(?:urn:ogc:def:crs:EPSG:[0-9.]*:|EPSG:)(\d{1,6})", re.IGNORECASE)
_CRS84 = re.compile(r"urn:ogc:def:crs:OGC:[0-9.]*:CRS84|OGC:CRS84", re.IGNORECASE)


def geojson(path: Path, data: bytes) -> tuple[list[Drawn], str]:
    """The features of a file, and its projection: "" for longitude and latitude, else EPSG and a number."""
    if data.count(b"[") + data.count(b"{") > MOST_BRACKETS:
        raise refusal(path, "", f"more than {MOST_BRACKETS:,} brackets came", "expected a file of the search area")
    try:
        said = json.loads(text_of(path, data, EXPECTED), parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise refusal(path, "", f"it is not JSON ({error})"[:200], EXPECTED) from None
    if not isinstance(said, dict):
        raise refusal(path, "", "a list or a bare value came", EXPECTED)
    return list(_features(path, said)), _crs(path, said)


def _no_number(name: str) -> float:
    raise ValueError(f"{name} came, which is no number of JSON")


def _crs(path: Path, said: dict[str, Any]) -> str:
    """The projection of the older GeoJSON of 2008, which may name one."""
    crs = said.get("crs")
    if crs is None:
        return ""
    named = crs.get("properties") if isinstance(crs, dict) else None
    name = named.get("name") if isinstance(named, dict) else None
    found = _EPSG.fullmatch(name) if isinstance(name, str) else None
    if found is not None:
        return "" if found[1] == "4326" else f"EPSG:{found[1]}"
    if not isinstance(name, str) or not _CRS84.fullmatch(name):
        told = printable(str(crs if name is None else name))[:60]
        raise refusal(path, "crs", f"{told} came", "expected none, or one of EPSG's by its number")
    return ""


def _features(path: Path, said: dict[str, Any]) -> Iterator[Drawn]:
    if said.get("type") == "FeatureCollection":
        features = said.get("features")
    else:
        features = [said if said.get("type") == "Feature" else {"geometry": said}]
    if not isinstance(features, list):
        raise refusal(path, "features", "no list came", EXPECTED)
    for number, each in enumerate(features):
        if not isinstance(each, dict):
            raise refusal(path, f"features[{number}]", "something that is no feature came", EXPECTED)
        if each.get("geometry") is not None:
            yield _drawn(path, f"features[{number}]", each)


def _drawn(path: Path, key: str, each: dict[str, Any]) -> Drawn:
    properties = each.get("properties")
    properties = properties if isinstance(properties, dict) else {}
    name, kind = title(properties), properties.get("class")
    key = f"{key} ({name[:40]})" if name else key
    try:
        geometry = _geometry(each["geometry"])
    except ValueError as error:
        raise refusal(path, key, str(error), EXPECTED) from None
    return Drawn(key, name, kind if isinstance(kind, str) else "", geometry, properties)


def title(properties: dict[str, Any]) -> str:
    """What a feature is called; of CalTopo's assignments, their letter and number where they have no title."""
    named = {str(key).lower(): value for key, value in reversed(properties.items())}
    for key in ("title", "name", "label"):
        if isinstance(named.get(key), str | int) and str(named[key]).strip():
            return str(named[key]).strip()
    return " ".join(str(named[key]).strip() for key in ("letter", "number") if named.get(key) not in (None, "")).strip()


def _geometry(said: Any, within: bool = False) -> Any:
    if not isinstance(said, dict):
        raise ValueError("a geometry that is no object came")
    kind = said.get("type")
    if kind == "GeometryCollection" and not within:
        return build.many(_geometry(each, True) for each in _list(said.get("geometries")))
    make = _KINDS.get(kind) if isinstance(kind, str) else None
    if make is None:
        raise ValueError(f"a geometry of type {printable(str(kind))[:40]} came")
    return make(_list(said.get("coordinates")))


def _list(said: Any) -> list[Any]:
    if not isinstance(said, list) or not said:
        raise ValueError("a geometry without coordinates came")
    return said


_KINDS: dict[str, Callable[[list[Any]], Any]] = {
    "Point": build.point,
    "MultiPoint": lambda said: build.many(map(build.point, said)),
    "LineString": build.line,
    "MultiLineString": lambda said: build.many(build.line(_list(each)) for each in said),
    "Polygon": build.polygon,
    "MultiPolygon": lambda said: build.many(build.polygon(_list(each)) for each in said),
}
