"""Dataflash logs, as ArduPilot writes them on board: .bin, and .log, the same as text.

A log describes itself: FMT (type 128) gives the name, length and columns of each type of message, which begins with
0xA3 0x95 and its type. Read are POS (the place as the autopilot has it), or GPS where there is none.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path

from sooner.io.reading import bytes_of
from sooner.io.tracks.fixes import Fixes, Recorded, refusal

__all__ = ["read_dataflash", "read_dataflash_text"]

MOST_BYTES = 500_000_000
MOST_LOST = 1_000_000  # bytes between messages that are passed over
BEGIN, FORMAT, FORMAT_SIZE = b"\xa3\x95", 128, 89
SIZES = {letter: code for code, letters in (
    ("64s", "aZ"), ("b", "b"), ("B", "BM"), ("h", "hc"), ("H", "HC"), ("i", "ieL"), ("I", "IE"),
    ("f", "f"), ("d", "d"), ("4s", "n"), ("16s", "N"), ("q", "q"), ("Q", "Q"), ("e", "g"),
) for letter in letters}  # fmt: skip
SCALES = {"c": 0.01, "C": 0.01, "e": 0.01, "E": 0.01, "L": 1e-7}
EPOCH_S = 315_964_800 - 18  # 6 January 1980, when GPS weeks begin, less the leap seconds since
WEEK_S = 604_800
_WANTED = ("POS", "GPS")
_EXPECTED = "expected a dataflash log of ArduPilot"

Message = dict[str, float]


@dataclass(frozen=True)
class _Kind:
    """A type of message: its size with the three bytes before it, and, where it is read, how."""

    name: str
    size: int
    layout: struct.Struct | None = None
    letters: str = ""
    columns: tuple[str, ...] = ()

    def values(self, data: bytes, at: int) -> Message:
        """What a message says, in its units."""
        assert self.layout is not None
        said = self.layout.unpack_from(data, at + 3)
        named = zip(self.columns, self.letters, said, strict=True)
        return {name: value * SCALES.get(letter, 1) for name, letter, value in named if not isinstance(value, bytes)}


def read_dataflash(path: Path) -> list[Recorded]:
    """The track of a binary log."""
    data = bytes_of(path, MOST_BYTES, "500 MB", _EXPECTED)
    if data[:3] != BEGIN + bytes([FORMAT]):
        raise refusal(path, "", "a file that does not begin with a format came", _EXPECTED)
    return _recorded(path, _messages(path, data))


def _messages(path: Path, data: bytes) -> Iterator[tuple[str, Message]]:
    kinds: dict[int, _Kind] = {FORMAT: _Kind("FMT", FORMAT_SIZE)}
    at = lost = 0
    while at + 3 <= len(data):
        kind = kinds.get(data[at + 2]) if data[at : at + 2] == BEGIN else None
        if kind is None:
            following = data.find(BEGIN, at + 1)
            following = len(data) if following < 0 else following
            lost, at = lost + following - at, following
            if lost > MOST_LOST and at < len(data):
                raise refusal(path, "", f"more than {MOST_LOST:,} bytes that are no message came", _EXPECTED)
            continue
        if at + kind.size > len(data):
            return  # the log was cut off
        if data[at + 2] == FORMAT:
            number, made = _kind(path, data[at : at + FORMAT_SIZE])
            if number != FORMAT:
                kinds[number] = made
        elif kind.layout is not None:
            yield kind.name, kind.values(data, at)
        at += kind.size


def _kind(path: Path, said: bytes) -> tuple[int, _Kind]:
    number, size = said[3], said[4]
    name, letters, columns = (
        part.partition(b"\0")[0].decode("ascii", "replace") for part in (said[5:9], said[9:25], said[25:89])
    )
    if size < 3:
        raise refusal(path, f"FMT {name}", f"messages of {size} bytes came", _EXPECTED)
    if name not in _WANTED:
        return number, _Kind(name, size)
    names = tuple(columns.split(","))
    try:
        layout = struct.Struct("<" + "".join(SIZES[letter] for letter in letters))
    except KeyError as error:
        raise refusal(path, f"FMT {name}", f"values of type {error} came", _EXPECTED) from None
    if layout.size + 3 != size or len(names) != len(letters):
        raise refusal(path, f"FMT {name}", f"columns {columns[:60]!r} of {letters!r} in {size} bytes came", _EXPECTED)
    return number, _Kind(name, size, layout, letters, names)


def read_dataflash_text(path: Path) -> list[Recorded]:
    """The track of a log as text."""
    data = bytes_of(path, MOST_BYTES, "500 MB", _EXPECTED)
    if not data.lstrip().startswith(b"FMT"):
        raise refusal(path, "", "a file that does not begin with a format came", _EXPECTED)
    return _recorded(path, _lines(data))


def _lines(data: bytes) -> Iterator[tuple[str, Message]]:
    columns: dict[str, list[str]] = {}
    for line in data.splitlines():
        if not line.startswith((b"FMT", b"POS", b"GPS")):
            continue
        name, *said = (part.strip() for part in line.decode("ascii", "replace").split(","))
        if name == "FMT" and len(said) > 4:
            columns[said[2]] = said[4:]
        elif name in _WANTED and len(said) == len(columns.get(name, ())):
            yield name, {key: _value(value) for key, value in zip(columns[name], said, strict=True)}


def _value(said: str) -> float:
    try:
        return float(said)
    except ValueError:
        return nan


# ---------------------------------------------------------------- messages to a track


def _recorded(path: Path, messages: Iterator[tuple[str, Message]]) -> list[Recorded]:
    """From POS, or where there is none from GPS; GPS tells when it was."""
    found = {name: Fixes(path) for name in _WANTED}
    began = nan
    for name, said in messages:
        seconds = said.get("TimeUS", nan) / 1e6 if "TimeUS" in said else said.get("TimeMS", nan) / 1e3
        if name == "GPS" and (said.get("Status", 3) < 3 or said.get("I", 0) > 0):
            continue  # no place yet, or a second receiver
        if name == "GPS" and not isfinite(began):
            began = EPOCH_S + WEEK_S * said.get("GWk", nan) + said.get("GMS", nan) / 1e3 - seconds
        lat, lon = said.get("Lat", nan), said.get("Lng", nan)
        within = abs(lat) <= 90.0 and abs(lon) <= 180.0
        up = said.get("RelHomeAlt", nan) if name == "POS" else said.get("Alt", nan)
        found[name].add(*((lat, lon) if within else (nan, nan)), seconds, up)
    chosen = next((name for name in _WANTED if found[name].rows), "GPS")
    fixes, above = found[chosen], "home" if chosen == "POS" else "sea"
    if isfinite(began):
        fixes.rows = [(lat, lon, seconds + began, up) for lat, lon, seconds, up in fixes.rows]
    return [fixes.recorded(path.stem, above, "utc" if isfinite(began) else "")]
