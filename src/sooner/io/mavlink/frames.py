"""MAVLink's messages among bytes, some of which may be garbage."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

__all__ = ["VERSION_2", "messages"]

VERSION_1, VERSION_2 = 0xFE, 0xFD  # first byte of a message
HEADERS = {VERSION_1: 6, VERSION_2: 10}
CHECKSUM, SIGNATURE, SIGNED = 2, 13, 1


def messages(mavlink: Any, parser: Any, buffer: bytearray, whole: bool) -> Iterator[Any]:
    """Messages in a buffer, which keeps what is not complete yet.

    What only looks like a message costs one byte: pymavlink's own reader would pass over all that it claims to be,
    and over the true message within. So a beginning counts only where a message of this number can be so long.

    Parameters
    ----------
    mavlink : module        pymavlink's messages
    parser : MAVLink        which decodes them
    buffer : bytearray      emptied as far as it is read
    whole : bool            nothing more belongs to it
    """
    at = 0
    while at < len(buffer):
        size = _size(mavlink, buffer, at)
        if size and at + size <= len(buffer):
            try:
                message = parser.decode(buffer[at : at + size])
            except mavlink.MAVError:
                at += 1
                continue
            at += size
            yield message
        elif size and not whole:
            break
        else:
            at += 1
    del buffer[:at]


def _size(mavlink: Any, buffer: bytearray, at: int) -> int:
    """Bytes of the message that begins here, 0 if none does; at least those of its header while that is incomplete."""
    header = HEADERS.get(buffer[at], 0)
    if not header or len(buffer) < at + header:
        return header
    if header == HEADERS[VERSION_1]:
        length, flags, number = buffer[at + 1], 0, buffer[at + 5]
    else:
        length, flags, number = buffer[at + 1], buffer[at + 2], int.from_bytes(buffer[at + 7 : at + 10], "little")
    known = mavlink.mavlink_map.get(number)
    if known is None or length > known.unpacker.size or flags & ~SIGNED:
        return 0
    return header + length + CHECKSUM + (SIGNATURE if flags & SIGNED else 0)
