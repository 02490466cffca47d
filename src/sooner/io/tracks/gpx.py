"""GPX: tracks of segments of points. Routes are what is planned, not what was flown."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from pathlib import Path

from sooner.io.markup import read_markup
from sooner.io.reading import bytes_of
from sooner.io.tracks.fixes import Fixes, Recorded, moment, number, place, refusal

__all__ = ["read_gpx"]

MOST_BYTES = 200_000_000
_EXPECTED = "expected GPX with a track (trk)"


def read_gpx(path: Path) -> list[Recorded]:
    """The tracks of a GPX file; between segments of a track nothing is known."""
    reader = _Tracks(path)
    read_markup(path, bytes_of(path, MOST_BYTES, "200 MB", _EXPECTED), reader, _EXPECTED)
    if not reader.found and reader.routes:
        raise refusal(
            path, "", f"{reader.routes} routes and no track came", f"{_EXPECTED}: a route is planned, a track was flown"
        )
    return reader.found


class _Tracks:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.found: list[Recorded] = []
        self.routes = 0
        self.within: list[str] = []
        self.fixes = Fixes(path)
        self.name = ""
        self.point = (nan, nan)
        self.seconds, self.altitude_m = nan, nan

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        self.within.append(tag)
        if tag == "trk":
            self.fixes, self.name = Fixes(self.path), ""
        elif tag == "trkseg":
            self.fixes.begin()
        elif tag == "trkpt":
            self.point = place(self.path, self._here(), attributes.get("lat", ""), attributes.get("lon", ""))
            self.seconds, self.altitude_m = nan, nan

    def end(self, tag: str, text: str) -> None:
        self.within.pop()
        above = self.within[-1] if self.within else ""
        if above == "trkpt" and tag == "time" and text:
            self.seconds = moment(self.path, self._here(), text)
        elif above == "trkpt" and tag == "ele" and text:
            self.altitude_m = number(self.path, self._here(), text, "expected metres above the sea")
        elif above == "trk" and tag == "name":
            self.name = text
        elif tag == "trkpt":
            self.fixes.add(*self.point, self.seconds, self.altitude_m)
        elif tag == "trk":
            self.found.append(self.fixes.recorded(self.name, "sea", "utc"))
        elif tag == "rte":
            self.routes += 1

    def _here(self) -> str:
        return f"trk[{len(self.found)}], point {len(self.fixes.rows)}"
