"""Glimpse probability, from task difficulty, and the probability that several looks all miss."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["glimpse_from_difficulty", "miss_after_looks"]


def glimpse_from_difficulty(difficulty: ArrayLike) -> NDArray[np.float64]:
    """Glimpse probability of every cell from its level of task difficulty.

    g_i = 1 - d_i / (d_max + 1)                              [Lin2014, eq. (2)]

    Parameters
    ----------
    difficulty : (H, W)        levels of at least 0; 0 is easy, d_max the largest level of the whole map

    Raises
    ------
    InvalidProblemError        if a level is negative or not finite

    Examples
    --------
    >>> glimpse_from_difficulty([[0, 1, 3]])
    array([[1.  , 0.75, 0.25]])
    """
    levels = np.asarray(difficulty, np.float64)
    if levels.size == 0 or not np.isfinite(levels).all() or (levels < 0).any():
        raise InvalidProblemError(
            "difficulty levels came negative, empty or not finite; expected numbers of at least 0"
        )
    return np.asarray(1.0 - levels / (levels.max() + 1.0))


def miss_after_looks(glimpse: NDArray[np.float64], looks: int, correlation: float = 0.0) -> NDArray[np.float64]:
    """Probability that 0, 1, ..., `looks` looks at a cell all miss a person who is there.

    Independent looks:  M_k = (1 - g)^k                                      [Lin2014, eq. (6)]
    Correlated looks:   M_k = prod_{j<k} (b + j) / (a + b + j),  a = g s, b = (1 - g) s, s = 1 / rho - 1

    The second is the beta-binomial law: the place itself has an unknown glimpse probability, Beta distributed
    with mean g, and rho is the correlation between two looks at it. rho = 0 gives the first, at rho = 1 a second
    look sees nothing that the first did not. The gains M_(k-1) - M_k fall with k for every rho.

    Parameters
    ----------
    glimpse : (N,) float       mean glimpse probability, in [0, 1]
    looks : int                largest number of looks
    correlation : float        rho, in [0, 1]

    Returns
    -------
    (N, looks + 1) float       column k: P(k looks miss | there)

    Examples
    --------
    >>> miss_after_looks(np.array([0.5]), 2)
    array([[1.  , 0.5 , 0.25]])
    >>> miss_after_looks(np.array([0.5]), 2, correlation=0.5)
    array([[1.   , 0.5  , 0.375]])
    >>> miss_after_looks(np.array([0.5]), 2, correlation=1.0)
    array([[1. , 0.5, 0.5]])
    """
    if not 0.0 <= correlation <= 1.0:
        raise InvalidProblemError(f"correlation {correlation} came; expected a number in [0, 1]")
    j = np.arange(looks)
    # (b + j) / (a + b + j) with numerator and denominator times rho, so that rho = 0 and rho = 1 need no care
    numerator = (1.0 - glimpse)[:, None] * (1.0 - correlation) + correlation * j
    denominator = (1.0 - correlation) + correlation * j
    with np.errstate(invalid="ignore"):
        factors = np.where(denominator > 0, numerator / np.where(denominator > 0, denominator, 1.0), 0.0)
    if correlation == 1.0 and looks:
        factors[:, 0] = 1.0 - glimpse
    return np.concatenate([np.ones((len(glimpse), 1)), np.cumprod(factors, axis=1)], axis=1)
