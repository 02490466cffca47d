"""The graded sensor: a look at a cell answers with one of several levels, higher where there is something to see."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from numbers import Integral

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["GradedSensor"]

BEYOND = 3.0  # how far, in standard deviations, the levels reach below the mean of noise and above that of a signal
MOST = 30.0  # the largest sensitivity: above it the probability of a level is too small for a double


@dataclass(frozen=True)
class GradedSensor:
    """A scalar that is normal with unit variance, about m where there is a signal and about 0 where there is none.

    p(z | noise) ~ exp(-z^2 / 2),  p(z | signal) ~ exp(-(z - m)^2 / 2)         [Wolek2020, eq. (3) to (6)]

    Both are normalised over n levels from -3 to m + 3, equally far apart. A mapping sensor sees a signal in cells that
    are not void, a target sensor in the target's. Without sensitivity (m = 0) it is blind, and its looks teach nothing.

    Parameters
    ----------
    sensitivity : float      m, from 0 to 30; the paper flies 4
    levels : int             n, at least 2

    Raises
    ------
    InvalidProblemError      if the sensitivity lies outside [0, 30], or there are fewer than two levels

    Notes
    -----
    The paper gives neither the levels nor how a draw becomes one; ours are 25, and a draw goes to the nearest. With
    few levels the two differ: of 3 levels with m = 4, noise is mostly reported as the middle one, which tells nothing.

    Examples
    --------
    >>> GradedSensor(4.0, 6).values
    array([-3., -1.,  1.,  3.,  5.,  7.])
    >>> GradedSensor(4.0, 6).p_noise.round(3)
    array([0.009, 0.491, 0.491, 0.009, 0.   , 0.   ])
    """

    sensitivity: float = 4.0
    levels: int = 25

    def __post_init__(self) -> None:
        if not 0.0 <= self.sensitivity <= MOST:
            raise InvalidProblemError(f"a sensitivity of {self.sensitivity} came; expected one in [0, {MOST:g}]")
        if not isinstance(self.levels, Integral) or self.levels < 2:
            raise InvalidProblemError(f"{self.levels} levels came; expected a whole number of at least 2")

    @cached_property
    def values(self) -> NDArray[np.float64]:
        """(n,) float: what each level says, ascending."""
        return np.linspace(-BEYOND, self.sensitivity + BEYOND, self.levels)

    @property
    def step(self) -> float:
        """How far one level is from the next."""
        return (self.sensitivity + 2.0 * BEYOND) / (self.levels - 1)

    @cached_property
    def p_noise(self) -> NDArray[np.float64]:
        """(n,) float: P(level | nothing to see)."""
        return _normalised(self.values)

    @cached_property
    def p_signal(self) -> NDArray[np.float64]:
        """(n,) float: P(level | something to see)."""
        return _normalised(self.values - self.sensitivity)

    @cached_property
    def p_levels(self) -> NDArray[np.float64]:
        """(2, n) float: `p_noise` and `p_signal`, as beliefs take them."""
        return np.stack([self.p_noise, self.p_signal])

    @cached_property
    def likelihood_ratios(self) -> NDArray[np.float64]:
        """(n,) float: P(level | signal) / P(level | noise)."""
        return self.p_signal / self.p_noise

    def draw(self, signals: ArrayLike, rng: Generator) -> NDArray[np.int64]:
        """Level that each look reports, from 0: a normal draw, rounded to the nearest level.

        Parameters
        ----------
        signals : (k,) bool      whether there is something to see

        Examples
        --------
        >>> GradedSensor().draw([False, True], np.random.default_rng(1))
        array([ 8, 19])
        """
        from sooner.sensors._graded_kernels import read_levels

        seen = np.ascontiguousarray(signals, bool)
        out = np.empty(seen.shape, np.int64)
        noise = rng.standard_normal(seen.shape)
        read_levels(seen, noise, float(self.sensitivity), -BEYOND, self.step, int(self.levels), out)
        return out


def _normalised(off: NDArray[np.float64]) -> NDArray[np.float64]:
    weights = np.exp(-(off**2) / 2.0)
    return np.asarray(weights / weights.sum())
