"""What command lines give in several places, checked where its option can still be named."""

from __future__ import annotations

from math import isfinite

from sooner.errors import DataFormatError, Fault

__all__ = ["planning_time"]


def planning_time(seconds: float) -> float:
    """Seconds to plan for.

    Raises
    ------
    DataFormatError      where they are not a finite number above 0
    """
    if not (isfinite(seconds) and seconds > 0.0):
        raise DataFormatError(Fault("--seconds", "", f"{seconds:g} came", "expected a finite number above 0"))
    return seconds
