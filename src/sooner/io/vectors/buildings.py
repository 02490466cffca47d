"""Buildings of OpenStreetMap extracts, .osm and .pbf: what stands in the way of a drone that flies low."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from sooner.errors import DataFormatError
from sooner.io.reading import opened
from sooner.io.vectors.feature import MOST_FEATURES, Drawn, Feature, checked, refusal
from sooner.io.vectors.wkb import wkb

__all__ = ["buildings"]

MOST_BYTES = 500_000_000
_EXPECTED = "expected an OpenStreetMap extract, .osm or .pbf"


def buildings(path: Path) -> tuple[Feature, ...]:
    """Every closed way and multipolygon with a tag `building`; those that the extract cuts are left out.

    Raises
    ------
    DataFormatError         missing, unreadable, too large, no buildings, or pyosmium not installed
    """
    with opened(path) as file:
        if file.seek(0, 2) > MOST_BYTES:
            told = "expected an extract of the search area: osmium extract --bbox"
            raise refusal(path, "", "a file of more than 500 MB came", told)
    try:
        import osmium
    except ImportError:
        told = "expected pyosmium: pip install 'sooner[openstreetmap]'"
        raise refusal(path, "", "an OpenStreetMap extract came, which is not read here", told) from None
    drawn: list[Drawn] = []
    try:
        make = osmium.geom.WKBFactory()
        built = osmium.filter.KeyFilter("building")
        found: Iterable[Any] = osmium.FileProcessor(str(path)).with_areas(built).with_filter(built)
        for area in found:
            if not area.is_area():
                continue
            geometry = wkb(bytes.fromhex(make.create_multipolygon(area)))
            if geometry is None or not geometry.is_valid:
                continue
            drawn.append(Drawn(f"building {area.orig_id()}", area.tags.get("name", ""), "building", geometry, {}))
            if len(drawn) > MOST_FEATURES:
                raise refusal(path, "", f"more than {MOST_FEATURES:,} buildings came", "expected a smaller extract")
    except DataFormatError:
        raise
    except (RuntimeError, ValueError, OverflowError) as error:
        raise refusal(path, "", f"it cannot be read ({error})"[:300], _EXPECTED) from None
    if not drawn:
        raise refusal(path, "", "an extract without buildings came", "expected some, or obstacles left out")
    return checked(path, drawn)
