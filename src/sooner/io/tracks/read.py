"""Reading flown tracks, by the suffix of their file."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from pathlib import Path

from sooner.errors import InvalidProblemError
from sooner.io.reading import opened
from sooner.io.tracks.cleaning import cleaned, flights_of
from sooner.io.tracks.dataflash import read_dataflash, read_dataflash_text
from sooner.io.tracks.fixes import Recorded, refusal
from sooner.io.tracks.flight_record import read_flight_record
from sooner.io.tracks.geojson import read_geojson
from sooner.io.tracks.gpx import read_gpx
from sooner.io.tracks.kml import read_kml
from sooner.io.tracks.telemetry import read_telemetry
from sooner.io.tracks.track import Track

__all__ = ["GAP_S", "TRACKS", "read_tracks"]

GAP_S = 15.0
MOST_TRACKS = 1000
_READERS: dict[str, Callable[[Path], list[Recorded]]] = {
    ".gpx": read_gpx,
    ".geojson": read_geojson,
    ".json": read_geojson,
    ".kml": read_kml,
    ".csv": read_flight_record,
    ".tlog": read_telemetry,
    ".bin": read_dataflash,
    ".log": read_dataflash_text,
}
TRACKS: dict[str, str] = {
    ".gpx": "GPX tracks",
    ".geojson": "GeoJSON lines, with times as CalTopo and others write them, or without",
    ".json": "likewise",
    ".kml": "KML tracks (gx:Track), or lines",
    ".csv": "DJI flight records as CSV",
    ".tlog": "MAVLink telemetry of a ground station",
    ".bin": "dataflash logs of ArduPilot",
    ".log": "likewise, as text",
}
"""What is read, by suffix."""


def read_tracks(path: Path, gap_s: float = GAP_S, speed_mps: float | None = None) -> tuple[Track, ...]:
    """The flights that a file of tracks holds.

    Fixes that cannot be true are dropped and counted: without a place, at latitude 0 and longitude 0, with times that
    stand still or go back, and farther from the others than 100 m/s could be. Five minutes without a fix part two
    flights.

    Parameters
    ----------
    path : Path
    gap_s : float                 between fixes more than so many seconds apart nothing is known; lines without times
                                  have no gaps
    speed_mps : float or None     lines without times are told as if flown at that speed; None: they have no times

    Raises
    ------
    DataFormatError               missing, unreadable, too large, of no known kind, or without a fix that can be true
    InvalidProblemError           if the gap or the speed is not a number above 0

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "flown.geojson"
    >>> _ = path.write_text('{"type": "LineString", "coordinates": [[9.0, 46.0], [9.0, 46.001]]}')
    >>> [track] = read_tracks(path, speed_mps=10.0)
    >>> round(track.length_m), round(track.duration_s)
    (111, 11)
    """
    for name, said in (("gap", gap_s), ("speed", 1.0 if speed_mps is None else speed_mps)):
        if not (isfinite(said) and said > 0.0):
            raise InvalidProblemError(f"a {name} of {said} came; expected a number above 0")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        came = f"the suffix {path.suffix!r} came"
        raise refusal(path, "", came, f"expected a track named {', '.join(_READERS)}")
    with opened(path):
        pass
    recorded = reader(path)
    if len(recorded) > MOST_TRACKS:
        raise refusal(path, "", f"{len(recorded):,} lines came", f"expected at most {MOST_TRACKS:,} tracks")
    clean = [cleaned(each) for each in recorded]
    found = [track for each in clean if len(each.lat) for track in flights_of(each, str(path), gap_s, speed_mps)]
    if not found:
        why = "; ".join(note for each in clean for note in each.notes)
        raise refusal(path, "", f"no fix came that can be true{f' ({why})' if why else ''}", "expected a flown track")
    return tuple(found)
