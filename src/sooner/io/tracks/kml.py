"""KML: tracks with times (gx:Track), or else lines without."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from pathlib import Path

from sooner.io.markup import read_markup
from sooner.io.reading import bytes_of
from sooner.io.tracks.fixes import Fixes, Recorded, moment, number, place, refusal

__all__ = ["read_kml"]

MOST_BYTES = 200_000_000
_EXPECTED = "expected KML with a track (gx:Track) or a line (LineString)"
_ABOVE = {"absolute": "sea", "relativeToGround": ""}


def read_kml(path: Path) -> list[Recorded]:
    """The tracks of a KML file; its lines where it has none."""
    reader = _Lines(path)
    read_markup(path, bytes_of(path, MOST_BYTES, "200 MB", _EXPECTED), reader, _EXPECTED)
    return reader.tracks or reader.lines


class _Lines:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.tracks: list[Recorded] = []
        self.lines: list[Recorded] = []
        self.within: list[str] = []
        self.name, self.mode = "", "clampToGround"
        self.times: list[float] = []
        self.places: list[str] = []

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        self.within.append(tag)
        if tag == "Placemark":
            self.name = ""
        elif tag in ("Track", "LineString"):
            self.times, self.places, self.mode = [], [], "clampToGround"

    def end(self, tag: str, text: str) -> None:
        self.within.pop()
        above = self.within[-1] if self.within else ""
        if above == "Track" and tag == "when":
            self.times.append(moment(self.path, self._here(), text) if text else nan)
        elif above == "Track" and tag == "coord":
            self.places.append(text)
        elif above == "LineString" and tag == "coordinates":
            self.places = [each.replace(",", " ") for each in text.split()]
        elif above == "Placemark" and tag == "name":
            self.name = text
        elif above in ("Track", "LineString") and tag == "altitudeMode":
            self.mode = text
        elif tag == "Track":
            self.tracks.append(self._recorded(self.times))
        elif tag == "LineString":
            self.lines.append(self._recorded([nan] * len(self.places)))

    def _recorded(self, times: list[float]) -> Recorded:
        if len(times) != len(self.places):
            came = f"{len(times)} times and {len(self.places)} places came"
            raise refusal(self.path, self._here(), came, "expected as many")
        fixes, known = Fixes(self.path), self.mode in _ABOVE
        for time, said in zip(times, self.places, strict=True):
            if not said:  # gx:Track: at this time there was no fix
                continue
            lon, lat, height, *_ = [*said.split(), "", "", ""]
            up = number(self.path, self._here(), height) if known and height else nan
            fixes.add(*place(self.path, self._here(), lat, lon), time, up)
        return fixes.recorded(self.name, _ABOVE.get(self.mode, ""), "utc")

    def _here(self) -> str:
        return f"line {len(self.tracks) + len(self.lines)}"
