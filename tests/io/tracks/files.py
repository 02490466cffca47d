"""Tracks written as others write them."""

import struct

from pymavlink.dialects.v20 import ardupilotmega as v2

NOON = 1714737600.0  # 3 May 2024, 12:00:00 UTC


def gpx(*segments, name="Ridge", head="") -> str:
    """Each segment a list of (lat, lon, seconds since noon, metres)."""
    parts = []
    for segment in segments:
        points = "".join(
            f'<trkpt lat="{lat}" lon="{lon}"><ele>{up}</ele><time>{stamp(when)}</time></trkpt>'
            for lat, lon, when, up in segment
        )
        parts.append(f"<trkseg>{points}</trkseg>")
    space = 'xmlns="http://www.topografix.com/GPX/1/1" version="1.1" creator="test"'
    return f"<?xml version='1.0'?>{head}<gpx {space}><trk><name>{name}</name>{''.join(parts)}</trk></gpx>"


def stamp(when: float) -> str:
    minutes, seconds = divmod(when, 60.0)
    return f"2024-05-03T{12 + int(minutes // 60):02d}:{int(minutes % 60):02d}:{seconds:06.3f}Z"


def straight(n: int, step_s: float = 1.0, begin: float = 0.0):
    """A drone that flies north at 11 m/s."""
    return [(46.0 + 1e-4 * k, 9.0, begin + step_s * k, 1000.0 + k) for k in range(n)]


def tlog(fixes, first=False, key=None, system=1) -> bytes:
    """A telemetry log, its packets made by pymavlink: of MAVLink 1 with `first`, signed with a key."""
    link = v2.MAVLink(None, srcSystem=system, srcComponent=1)
    if key is not None:
        link.signing.secret_key, link.signing.sign_outgoing, link.signing.timestamp = key, True, 1
    out = b""
    for lat, lon, when, up in fixes:
        messages = [
            v2.MAVLink_heartbeat_message(2, 3, 81, 4, 4, 3),
            v2.MAVLink_global_position_int_message(
                int(1000 * when), round(lat * 1e7), round(lon * 1e7), 900_000, round(1000 * up), 0, 0, 0, 0
            ),
        ]
        for message in messages:
            out += struct.pack(">Q", round((NOON + when) * 1e6)) + message.pack(link, force_mavlink1=first)
    return out


FORMATS = {
    128: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns", "BB4s16s64s"),
    1: ("POS", "QLLfff", "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt", "Qiifff"),
    2: ("GPS", "QBIHBcLLe", "TimeUS,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt", "QBIHBhiii"),
    3: ("MSG", "QZ", "TimeUS,Message", "Q64s"),
}
GPS_WEEK, GPS_MS = 2312, (5 * 86_400 + 12 * 3600 + 18) * 1000  # noon of that Friday, and the leap seconds since 1980


def dataflash(fixes, kinds=(1, 2, 3)) -> bytes:
    """A dataflash log: its formats, then a POS, a GPS and a text for each fix."""

    def message(kind, *values):
        return b"\xa3\x95" + bytes([kind]) + struct.pack("<" + FORMATS[kind][3], *values)

    out = b""
    for kind, (name, letters, columns, layout) in FORMATS.items():
        size = struct.calcsize("<" + layout) + 3
        out += message(128, kind, size, name.encode(), letters.encode(), columns.encode())
    for lat, lon, when, up in fixes:
        place = round(lat * 1e7), round(lon * 1e7)
        us = 5_000_000 + round(1e6 * when)
        rows = {
            1: (us, *place, 900.0 + up, up, up),
            2: (us, 3, GPS_MS + round(1000 * when), GPS_WEEK, 12, 80, *place, round(100 * (900 + up))),
            3: (us, b"a text"),
        }
        out += b"".join(message(kind, *rows[kind]) for kind in kinds)
    return out
