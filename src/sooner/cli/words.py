"""Numbers as people read them."""

from __future__ import annotations

import math

from sooner.missions import Mission
from sooner.missions.report.words import clock

__all__ = ["amount", "clock", "flight", "percent", "steps", "times"]


def percent(share: float) -> str:
    """As `12.34 %`, right-aligned."""
    return f"{100 * share:6.2f} %"


def amount(mission: Mission, value: float) -> str:
    """A value of the mission's objective: `12.34 %`, `1,234.5 bits` or `3.210 targets`."""
    unit = mission.sight.unit
    if unit == "probability":
        return percent(value)
    return f"{value:,.{1 if abs(value) >= 100 else 3}f} {unit}"


def steps(mission: Mission, count: float) -> str:
    """Steps, and the time they take where the mission says how fast the drone flies."""
    if not math.isfinite(count):
        return "never"
    told = f"{count:.0f} steps" if float(count).is_integer() else f"{count:.1f} steps"
    return told if mission.step_s is None else f"{told} ({clock(count * mission.step_s)})"


def times(mission: Mission, time: float) -> str:
    """A time of the judge's: steps, or seconds as a clock shows them."""
    if not mission.timed:
        return steps(mission, time)
    return clock(time) if math.isfinite(time) else "never"


def flight(mission: Mission, result: dict[str, object]) -> str:
    """How long the longest flight is, `result` being the score's."""
    if mission.timed:
        seconds = result["duration_s"]
        assert isinstance(seconds, float)
        return clock(seconds)
    counts = result["steps"]
    assert isinstance(counts, list)
    return steps(mission, max(counts))
