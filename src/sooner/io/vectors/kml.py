"""KML and KMZ: placemarks with their borders, lines and points. Links to other files are not followed."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sooner.io.markup import Element, tree
from sooner.io.vectors import build
from sooner.io.vectors.feature import Drawn, refusal

__all__ = ["kml", "kmz"]

MOST_MEMBERS = 1_000
EXPECTED = "expected KML with placemarks"
EXPECTED_ZIP = "expected a KMZ: a ZIP archive with doc.kml"
_END = b"PK\x05\x06"  # the record that ends a ZIP archive: 22 bytes, and at most 65,535 of a comment
_GEOMETRIES = ("Point", "LineString", "LinearRing", "Polygon", "MultiGeometry", "Track", "MultiTrack")


def kml(path: Path, data: bytes) -> list[Drawn]:
    """Every placemark with a geometry, in the file's order."""
    root = tree(path, data, EXPECTED)
    if root.tag != "kml":
        raise refusal(path, "", f"a root <{root.tag[:40]}> came", EXPECTED)
    drawn = []
    for number, mark in enumerate(root.below("Placemark")):
        name = mark.said("name")
        key = f"Placemark {number + 1}" + (f" ({name[:40]})" if name else "")
        try:
            geometries = [_geometry(each) for each in mark.all(*_GEOMETRIES)]
        except ValueError as error:
            raise refusal(path, key, str(error), EXPECTED) from None
        if geometries:
            drawn.append(Drawn(key, name, "", build.many(geometries), dict(_properties(mark))))
    return drawn


def _properties(mark: Element) -> Iterator[tuple[str, Any]]:
    if described := mark.said("description"):
        yield "description", described
    for data in mark.below("Data"):
        yield data.attributes.get("name", ""), data.said("value")
    for data in mark.below("SimpleData"):
        yield data.attributes.get("name", ""), data.text


def _geometry(element: Element) -> Any:
    if element.tag in ("MultiGeometry", "MultiTrack"):
        return build.many(_geometry(each) for each in element.all(*_GEOMETRIES))
    if element.tag == "Track":
        return build.line([_numbers(each.text.split()) for each in element.all("coord")])
    if element.tag == "Polygon":
        borders = [*element.all("outerBoundaryIs"), *element.all("innerBoundaryIs")]
        return build.polygon([_places(ring) for border in borders for ring in border.all("LinearRing")])
    places = _places(element)
    if element.tag == "Point":
        return build.point(places[0])
    return build.polygon([places]) if element.tag == "LinearRing" else build.line(places)


def _places(element: Element) -> list[list[float]]:
    places = [_numbers(place.split(",")) for place in element.said("coordinates").split()]
    if not places:
        raise ValueError(f"a {element.tag} without coordinates came")
    return places


def _numbers(fields: list[str]) -> list[float]:
    try:
        lon, lat = float(fields[0]), float(fields[1])
    except (ValueError, IndexError):
        raise ValueError(f"{','.join(fields)[:40]!r} came, which is no longitude and latitude") from None
    return [lon, lat]


def kmz(path: Path, data: bytes, most_bytes: int) -> list[Drawn]:
    """The placemarks of every .kml in a KMZ, doc.kml first; nothing else of it is unpacked."""
    _check_members(path, data)
    left, unpacked = most_bytes, []
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".kml")]
            if not names:
                raise refusal(path, "", "an archive without a .kml came", EXPECTED_ZIP)
            for name in sorted(names, key=lambda name: name != "doc.kml"):
                with archive.open(name) as member:
                    unpacked.append(member.read(left + 1))
                left -= len(unpacked[-1])
                if left < 0:
                    break
    except (zipfile.BadZipFile, zlib.error, OSError, RuntimeError, NotImplementedError, EOFError, ValueError) as error:
        if isinstance(error, ValueError) and hasattr(error, "faults"):
            raise
        raise refusal(path, "", f"it cannot be unpacked ({error})"[:200], EXPECTED_ZIP) from None
    if left < 0:
        expected = f"expected at most {most_bytes / 1e6:g} MB: cut it to the search area"
        raise refusal(path, "", f".kml files that unpack to more than {most_bytes / 1e6:g} MB came", expected)
    return [each for member in unpacked for each in kml(path, member)]


def _check_members(path: Path, data: bytes) -> None:
    """Refuse a long list of contents before it is read: each entry takes 46 bytes there, and ten times that here."""
    ends = data.rfind(_END, max(0, len(data) - 22 - 0xFFFF))
    size = int.from_bytes(data[ends + 12 : ends + 16], "little") if ends >= 0 else 0
    if ends < 0 or len(data) < ends + 22:
        raise refusal(path, "", "something that is no ZIP archive came", EXPECTED_ZIP)
    if size > MOST_MEMBERS * 200:
        raise refusal(path, "", f"an archive of more than {MOST_MEMBERS} files came", EXPECTED_ZIP)
