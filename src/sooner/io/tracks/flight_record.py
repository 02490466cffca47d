"""DJI flight records as CSV, as those who decode them and log services write them.

Read are, whatever their case and whatever blanks stand around them:

- place: `OSD.latitude`, `OSD.longitude`; or `latitude`, `longitude`
- time: `time(millisecond)`; or `CUSTOM.date [local]` with `CUSTOM.updateTime [local]`; or `CUSTOM.updateTime`;
  or `OSD.flyTime [s]`; or `OSD.flyTime` as 3m 2.5s; or `datetime(utc)`. That of the flight is `datetime(utc)`'s
  where it stands beside.
- height above home: `OSD.height [ft]`, `OSD.height [m]`, `OSD.height`, `height_above_takeoff(feet)` or `(meters)`;
  else above the sea: `OSD.altitude [ft]`, `OSD.altitude [m]`, `altitude_above_seaLevel(feet)` or `(meters)`
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, datetime
from math import isfinite, nan
from pathlib import Path

from sooner.io.reading import bytes_of
from sooner.io.tracks.fixes import Fixes, Recorded, refusal

__all__ = ["read_flight_record"]

MOST_BYTES = 500_000_000
FOOT_M = 0.3048
PLACES = (("osd.latitude", "osd.longitude"), ("latitude", "longitude"))
HEIGHTS = {  # column: (metres of its unit, what it counts from), the best first
    "osd.height [m]": (1.0, "home"),
    "osd.height [ft]": (FOOT_M, "home"),
    "osd.height": (1.0, "home"),
    "height_above_takeoff(meters)": (1.0, "home"),
    "height_above_takeoff(feet)": (FOOT_M, "home"),
    "osd.altitude [m]": (1.0, "sea"),
    "osd.altitude [ft]": (FOOT_M, "sea"),
    "altitude_above_sealevel(meters)": (1.0, "sea"),
    "altitude_above_sealevel(feet)": (FOOT_M, "sea"),
}
_CLOCKS = ("%m/%d/%Y %I:%M:%S.%f %p", "%m/%d/%Y %I:%M:%S %p", "%m/%d/%Y %H:%M:%S.%f", "%m/%d/%Y %H:%M:%S")
_FLOWN = re.compile(r"(?:(\d+)h\s*)?(?:(\d+)m\s*)?(\d+(?:\.\d+)?)s")
_EXPECTED = "expected a flight record with the columns OSD.latitude and OSD.longitude, or latitude and longitude"

Row = list[str]
Clock = Callable[[Row], float]


def read_flight_record(path: Path) -> list[Recorded]:
    """The track of a flight record."""
    data = bytes_of(path, MOST_BYTES, "500 MB", _EXPECTED)
    text = data.replace(b"\0", b"").decode("utf-8-sig", "replace")
    rows = _rows(path, text)
    columns: dict[str, int] = {}
    for which, name in enumerate(next(rows, [])):
        columns.setdefault(" ".join(name.lower().split()), which)
    pair = next((pair for pair in PLACES if set(pair) <= set(columns)), None)
    if pair is None:
        raise refusal(path, "", f"the columns {', '.join(list(columns)[:5])} came", _EXPECTED)
    lat, lon = (columns[each] for each in pair)
    clock, told = _clock(columns)
    up = next((name for name in HEIGHTS if name in columns), "")
    unit_m, above = HEIGHTS.get(up, (nan, ""))
    fixes = Fixes(path)
    for row in rows:
        north, east = _value(row, lat), _value(row, lon)
        inside = abs(north) <= 90.0 and abs(east) <= 180.0
        height = unit_m * _value(row, columns[up]) if up else nan
        fixes.add(*((north, east) if inside else (nan, nan)), clock(row), height)
    return [fixes.recorded(path.stem, above, told)]


def _rows(path: Path, text: str) -> Iterator[Row]:
    """Lines that hold something, without the one that tells a spreadsheet the separator."""
    lines: Iterable[str] = (line for line in text.splitlines() if line.strip() and not line.startswith("sep="))
    try:
        yield from csv.reader(lines)
    except csv.Error as error:
        raise refusal(path, "", f"it is not CSV ({error})", _EXPECTED) from None


def _value(row: Row, column: int) -> float:
    try:
        found = float(row[column])
    except (IndexError, ValueError):
        return nan
    return found if isfinite(found) else nan


def _text(row: Row, column: int) -> str:
    return row[column].strip() if column < len(row) else ""


# ---------------------------------------------------------------- clocks


def _clock(columns: dict[str, int]) -> tuple[Clock, str]:
    """Seconds of a row, by the best clock there is, and what they count from."""
    utc = columns.get("datetime(utc)")
    if "time(millisecond)" in columns:
        since = columns["time(millisecond)"]
        if utc is None:
            return lambda row: _value(row, since) / 1000.0, ""
        return _Since(since, utc), "utc"
    day, time = columns.get("custom.date [local]"), columns.get("custom.updatetime [local]")
    if day is not None and time is not None:
        return lambda row: _local(f"{_text(row, day)} {_text(row, time)}"), "local"
    if "custom.updatetime" in columns:
        updated = columns["custom.updatetime"]
        return lambda row: _iso(_text(row, updated)), "local"
    if "osd.flytime [s]" in columns:
        flown_s = columns["osd.flytime [s]"]
        return lambda row: _value(row, flown_s), ""
    if "osd.flytime" in columns:
        flown = columns["osd.flytime"]
        return lambda row: _flown(_text(row, flown)), ""
    if utc is not None:
        return lambda row: _iso(_text(row, utc)), "utc"
    return lambda row: nan, ""


class _Since:
    """Milliseconds since some moment, which the first row with a time of day tells."""

    def __init__(self, since: int, utc: int) -> None:
        self.since, self.utc, self.began = since, utc, nan

    def __call__(self, row: Row) -> float:
        seconds = _value(row, self.since) / 1000.0
        if not isfinite(self.began) and isfinite(began := _iso(_text(row, self.utc)) - seconds):
            self.began = began
        return seconds + self.began


def _local(said: str) -> float:
    """As 11/25/2025 7:05:08.97 PM: month, day, year."""
    for form in _CLOCKS:
        try:
            return datetime.strptime(said, form).replace(tzinfo=UTC).timestamp()
        except (ValueError, OverflowError):
            continue
    return _iso(said)


def _iso(said: str) -> float:
    """As 2025-11-25 19:05:08.970, or with strokes."""
    try:
        found = datetime.fromisoformat(said.replace("/", "-"))
        return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError):
        return nan


def _flown(said: str) -> float:
    """As 3m 2.5s."""
    found = _FLOWN.fullmatch(said)
    if found is None:
        return nan
    hours, minutes, seconds = found.groups()
    return 3600.0 * int(hours or 0) + 60.0 * int(minutes or 0) + float(seconds)
