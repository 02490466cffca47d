"""Settings of patterns, refused where they make no sense."""

from __future__ import annotations

import numpy as np

from sooner.errors import InvalidProblemError

__all__ = ["check_datum", "check_overlap", "check_positive"]


def check_positive(name: str, value: float | None) -> None:
    """None, or a finite number above 0."""
    if value is not None and not (np.isfinite(value) and value > 0):
        raise InvalidProblemError(f"{name} = {value} came; expected metres above 0, or None")


def check_overlap(overlap: float) -> None:
    """A share that leaves something."""
    if not 0 <= overlap <= 0.9:
        raise InvalidProblemError(f"overlap = {overlap} came; expected 0 to 0.9")


def check_datum(datum: tuple[float, float] | None) -> None:
    """None, or two finite numbers."""
    if datum is not None and not (len(datum) == 2 and np.isfinite(datum).all()):
        raise InvalidProblemError(f"datum = {datum} came; expected metres east and north, or None")
