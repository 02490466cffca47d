"""Belief: the probability of containment of every cell, and of the world beyond the map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["Belief"]


@dataclass(frozen=True, eq=False)
class Belief:
    """All cells' POC and the mass `outside` the map; together they total one.

    Parameters
    ----------
    poc : (H, W) float       probability of containment of each cell
    outside : float          probability that the person is not on the map

    Raises
    ------
    InvalidProblemError      if a probability is negative or not a number, or the total is not one

    Examples
    --------
    >>> belief = Belief.from_weights([[1, 3], [0, 4]], outside=0.2)
    >>> belief.poc
    array([[0.1, 0.3],
           [0. , 0.4]])
    """

    poc: NDArray[np.float64]
    outside: float = 0.0

    def __post_init__(self) -> None:
        poc = _checked_weights(self.poc)
        if not 0.0 <= self.outside < 1.0:
            raise InvalidProblemError(f"outside = {self.outside} came; expected a probability in [0, 1)")
        total = float(poc.sum()) + self.outside
        if abs(total - 1.0) > 1e-9:
            raise InvalidProblemError(
                f"POC and outside total {total:.12g}; expected 1 (Belief.from_weights normalises)"
            )
        object.__setattr__(self, "poc", poc)

    @classmethod
    def from_weights(cls, weights: ArrayLike, outside: float = 0.0) -> Belief:
        """POC proportional to `weights` (H, W), leaving `outside` for the world beyond the map."""
        checked = _checked_weights(weights)
        if not 0.0 <= outside < 1.0:
            raise InvalidProblemError(f"outside = {outside} came; expected a probability in [0, 1)")
        largest = float(checked.max())
        if largest == 0.0:
            raise InvalidProblemError("every weight is zero: the map says the person is nowhere on it")
        scaled = checked / largest  # first by the largest, so that huge or tiny weights neither overflow nor vanish
        return cls(scaled * ((1.0 - outside) / scaled.sum()), outside)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        height, width = self.poc.shape
        return height, width


def _checked_weights(weights: ArrayLike) -> NDArray[np.float64]:
    values = np.ascontiguousarray(weights, np.float64)
    if values.ndim != 2 or values.size == 0:
        raise InvalidProblemError(f"weights of shape {values.shape} came; expected rows and columns (H, W)")
    for wrong, name in ((~np.isfinite(values), "not a finite number"), (values < 0, "negative")):
        if wrong.any():
            row, col = np.argwhere(wrong)[0]
            raise InvalidProblemError(
                f"{int(wrong.sum())} weights are {name}, the first {values[row, col]} at [{row}, {col}]; "
                "expected finite numbers of at least 0"
            )
    return values
