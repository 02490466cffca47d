"""Means over trials, with how far off they may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

__all__ = ["Mean"]


@dataclass(frozen=True)
class Mean:
    """A mean of independent trials.

    Parameters
    ----------
    value : float or None     None where there was no trial
    error : float or None     its standard error, s / sqrt(n); None for a single trial
    n : int                   trials

    Examples
    --------
    >>> Mean.of([1.0, 2.0, 3.0])
    Mean(value=2.0, error=0.5773502691896258, n=3)
    """

    value: float | None
    error: float | None
    n: int

    @classmethod
    def of(cls, values: Sequence[float]) -> Mean:
        """The mean of some numbers."""
        numbers = np.array(values, float)
        n = len(numbers)
        if n == 0:
            return cls(None, None, 0)
        return cls(float(numbers.mean()), float(numbers.std(ddof=1)) / sqrt(n) if n > 1 else None, n)

    def result(self) -> dict[str, Any]:
        """For JSON."""
        return {"mean": self.value, "standard_error": self.error, "n": self.n}

    def told(self, digits: int = 3, unit: str = "") -> str:
        """As `0.512 +- 0.004`."""
        if self.value is None:
            return "-"
        error = "" if self.error is None else f" +- {self.error:.{digits}f}"
        return f"{self.value:.{digits}f}{error}{unit}"
