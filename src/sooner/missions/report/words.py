"""Numbers and places as people at a command post read them."""

from __future__ import annotations

from math import isfinite

__all__ = ["amount", "clock", "coordinates", "metres", "percent", "when"]


def percent(share: float) -> str:
    """As `12.3 %`.

    >>> percent(0.1234)
    '12.3 %'
    """
    return f"{100 * share:.1f} %"


def amount(unit: str, value: float) -> str:
    """A value of a mission whose unit is "probability", "bits" or "targets".

    >>> amount("probability", 0.25), amount("bits", 1234.5)
    ('25.0 %', '1,234.5 bits')
    """
    return percent(value) if unit == "probability" else f"{value:,.{1 if abs(value) >= 100 else 3}f} {unit}"


def clock(seconds: float) -> str:
    """As minutes and seconds, with hours where there are some.

    >>> clock(725), clock(3725)
    ('12:05', '1:02:05')
    """
    hours, rest = divmod(round(seconds), 3600)
    minutes, left = divmod(rest, 60)
    return f"{hours}:{minutes:02d}:{left:02d}" if hours else f"{minutes}:{left:02d}"


def when(time: float, unit_s: float | None) -> str:
    """A time of the judge's, whose unit is so many seconds; steps where nobody knows.

    >>> when(300, 2.0), when(300, None), when(float("inf"), None)
    ('10:00', '300 steps', 'never')
    """
    if not isfinite(time):
        return "never"
    return f"{time:g} steps" if unit_s is None else clock(time * unit_s)


def metres(length: float) -> str:
    """As `850 m`, or `12.3 km`.

    >>> metres(849.6), metres(12_345.0)
    ('850 m', '12.3 km')
    """
    return f"{length:.0f} m" if length < 10_000 else f"{length / 1000:.1f} km"


def coordinates(lat: float, lon: float) -> str:
    """Latitude and longitude, WGS 84, to about a metre.

    >>> coordinates(46.123456, 11.2)
    '46.12346, 11.20000'
    """
    return f"{lat:.5f}, {lon:.5f}"
