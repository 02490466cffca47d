"""Numbers as people read them."""

from __future__ import annotations

import math

from sooner.missions import Mission

__all__ = ["clock", "percent", "steps"]


def percent(share: float) -> str:
    """As `12.34 %`, right-aligned."""
    return f"{100 * share:6.2f} %"


def clock(seconds: float) -> str:
    """As `12:05`, or `1:02:05`.

    >>> clock(725), clock(3725)
    ('12:05', '1:02:05')
    """
    hours, rest = divmod(round(seconds), 3600)
    minutes, left = divmod(rest, 60)
    return f"{hours}:{minutes:02d}:{left:02d}" if hours else f"{minutes}:{left:02d}"


def steps(mission: Mission, count: float) -> str:
    """Steps, and the time they take where the mission says how fast the drone flies."""
    if not math.isfinite(count):
        return "never"
    told = f"{count:.0f} steps" if float(count).is_integer() else f"{count:.1f} steps"
    return told if mission.step_s is None else f"{told} ({clock(count * mission.step_s)})"
