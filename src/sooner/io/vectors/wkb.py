"""Well-known binary: the geometry of GeoPackages, read number by number, so that no count in it is believed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.io.vectors import build

__all__ = ["wkb"]

_PARTS = {4: 1, 5: 2, 6: 3}  # of what kind the parts of a geometry of many are


def wkb(data: bytes) -> Any | None:
    """The geometry of these bytes; None where it is empty.

    Raises
    ------
    ValueError              another kind of geometry, or bytes that end too soon

    Examples
    --------
    >>> import shapely
    >>> wkb(shapely.to_wkb(shapely.Point(11.0, 46.0)))
    <POINT (11 46)>
    """
    found, _ = _geometry(data, 0, None)
    return found


def _geometry(data: bytes, at: int, expected: int | None) -> tuple[Any | None, int]:
    order = "<" if data[at : at + 1] == b"\x01" else ">"
    code, at = _count(data, at + 1, order)
    kind, numbers = (code & 0xFFFF) % 1000, _numbers(code)
    if kind not in (1, 2, 3, 4, 5, 6) or (expected is not None and kind != expected):
        raise ValueError(f"a geometry of type {code} came: points, lines and polygons are read, or many of one")
    if kind == 1:
        places, at = _places(data, at, order, 1, numbers)
        return (None if np.isnan(places).all() else build.point(places[0])), at
    count, at = _count(data, at, order)
    if kind == 2:
        places, at = _places(data, at, order, count, numbers)
        return (build.line(places) if count else None), at
    parts: list[Any] = []
    part: Any
    for _ in range(count):  # each takes bytes, so that a count too high soon ends
        if kind == 3:
            within, at = _count(data, at, order)
            part, at = _places(data, at, order, within, numbers)
        else:
            part, at = _geometry(data, at, _PARTS[kind])
        parts += [] if part is None else [part]
    if not parts:
        return None, at
    return (build.polygon(parts) if kind == 3 else build.many(parts)), at


def _numbers(code: int) -> int:
    """Of a place: two, and a height or a measure more."""
    iso = (code & 0xFFFF) // 1000
    flagged = bool(code & 0x80000000) + bool(code & 0x40000000)
    return 2 + max(flagged, {0: 0, 1: 1, 2: 1, 3: 2}.get(iso, 9))


def _count(data: bytes, at: int, order: str) -> tuple[int, int]:
    if len(data) < at + 4:
        raise ValueError("a geometry that ends too soon came")
    return int.from_bytes(data[at : at + 4], "little" if order == "<" else "big"), at + 4


def _places(data: bytes, at: int, order: str, count: int, numbers: int) -> tuple[NDArray[np.float64], int]:
    ends = at + count * numbers * 8
    if numbers > 4 or ends > len(data):
        raise ValueError("a geometry that ends too soon came")
    places = np.frombuffer(data, f"{order}f8", count * numbers, at).reshape(count, numbers)
    return np.asarray(places[:, :2], np.float64), ends
