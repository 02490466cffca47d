"""MAVLink telemetry (.tlog): packets as a ground station heard them, each behind the microseconds since 1970.

Of them GLOBAL_POSITION_INT (33) is read: u32 boot ms, i32 lat and lon in 1e-7 degrees, i32 mm above the sea, i32 mm
above home, and more. It counts where its checksum is right. No other packet is looked into, so that no dialect is
needed and no file takes longer than its bytes.
"""

from __future__ import annotations

import struct
from pathlib import Path

from sooner.io.reading import bytes_of
from sooner.io.tracks.fixes import Fixes, Recorded, refusal

__all__ = ["read_telemetry"]

MOST_BYTES = 500_000_000
MOST_LOST = 1_000_000  # bytes between packets that are passed over
POSITION, POSITION_SEED = 33, 104  # GLOBAL_POSITION_INT, and what its checksum ends with
FIRST, SECOND = 0xFE, 0xFD  # how packets of MAVLink 1 and 2 begin
_BODY = struct.Struct("<Iiiii")
_EXPECTED = "expected a telemetry log (.tlog) of MAVLink packets"


def read_telemetry(path: Path) -> list[Recorded]:
    """The tracks of a telemetry log, one for each vehicle."""
    data = bytes_of(path, MOST_BYTES, "500 MB", _EXPECTED)
    vehicles: dict[int, Fixes] = {}
    at = lost = packets = 0
    while at + 16 <= len(data):
        size = _size(data, at + 8)
        end = at + 8 + size
        position = _position(data, at + 8, end) if size else None
        if position is None and not (size and _follows(data, end)):
            lost, at = lost + 1, at + 1
            if lost > MOST_LOST:
                raise refusal(path, "", f"more than {MOST_LOST:,} bytes that are no packet came", _EXPECTED)
            continue
        if position is not None:
            system, lat, lon, above_m = position
            seconds = int.from_bytes(data[at : at + 8], "big") / 1e6
            vehicles.setdefault(system, Fixes(path)).add(lat, lon, seconds, above_m)
        packets, at = packets + 1, end
    if not packets:
        raise refusal(path, "", "a file without a packet came", _EXPECTED)
    notes = (f"{lost:,} bytes between packets passed over",) if lost else ()
    several = len(vehicles) > 1
    return [
        fixes.recorded(f"vehicle {system}" if several else path.stem, "home", "utc", notes)
        for system, fixes in sorted(vehicles.items())
    ]


def _size(data: bytes, begin: int) -> int:
    """Bytes of the packet that begins here; 0 where none does."""
    if data[begin] == FIRST:
        return data[begin + 1] + 8
    if data[begin] == SECOND and begin + 2 < len(data):
        return data[begin + 1] + 12 + (13 if data[begin + 2] & 1 else 0)
    return 0


def _follows(data: bytes, end: int) -> bool:
    """The file ends here, or another packet comes, or what is left of one that was cut off."""
    return end <= len(data) and (end + 8 >= len(data) or data[end + 8] in (FIRST, SECOND))


def _position(data: bytes, begin: int, end: int) -> tuple[int, float, float, float] | None:
    """The vehicle, its latitude and longitude, and metres above home; None if the packet is none that says so."""
    head, system = (6, begin + 3) if data[begin] == FIRST else (10, begin + 5)
    kind = data[begin + 5 : begin + 6] if head == 6 else data[begin + 7 : begin + 10]
    ends = begin + head + data[begin + 1]
    if end > len(data) or int.from_bytes(kind, "little") != POSITION:
        return None
    if _checksum(data[begin + 1 : ends]) != int.from_bytes(data[ends : ends + 2], "little"):
        return None
    body = data[begin + head : ends].ljust(_BODY.size, b"\0")  # MAVLink 2 does not send zeros at its end
    _, lat, lon, _, above_mm = _BODY.unpack(body[: _BODY.size])
    if abs(lat) > 900_000_000 or abs(lon) > 1_800_000_000:
        return None
    return data[system], lat / 1e7, lon / 1e7, above_mm / 1000.0


def _checksum(data: bytes) -> int:
    """CRC-16/MCRF4XX of a packet's bytes and of its message's own."""
    found = 0xFFFF
    for byte in (*data, POSITION_SEED):
        turned = byte ^ (found & 0xFF)
        turned = (turned ^ (turned << 4)) & 0xFF
        found = (found >> 8) ^ (turned << 8) ^ (turned << 3) ^ (turned >> 4)
    return found & 0xFFFF
