"""Bayes over cells: what a miss teaches, and where a drifting person goes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import ImpossibleObservationError

__all__ = ["predict", "update_on_miss"]


def update_on_miss(belief: NDArray[np.float64], glimpse: NDArray[np.float64]) -> NDArray[np.float64]:
    """Posterior over cells after one look that found nothing.

    b'_i = b_i (1 - g_i) / (1 - sum_j b_j g_j)              [Koopman1956; Stone1975, ch. 1]

    Parameters
    ----------
    belief : (N,) float        POC per cell; what is missing from one lies outside the map
    glimpse : (N,) float       P(detect | in cell i), in [0, 1]; zero outside the footprint

    Returns
    -------
    (N,) float                 cells and outside still total one; no larger where glimpse is largest

    Raises
    ------
    ImpossibleObservationError  if every place with mass had glimpse 1: no posterior exists

    Examples
    --------
    >>> update_on_miss(np.array([0.5, 0.5]), np.array([1.0, 0.0]))
    array([0., 1.])
    """
    miss = 1.0 - float(belief @ glimpse)
    if miss <= 1e-300:
        raise ImpossibleObservationError(
            f"a miss came, but the look detects with probability {1.0 - miss:.12g} wherever the person may be"
        )
    return belief * (1.0 - glimpse) / miss


def predict(belief: NDArray[np.float64], transition: Any) -> NDArray[np.float64]:
    """Belief one step later, when the person moves as a Markov chain.

    b'_j = sum_i b_i P_ij                                    [Stone1975, ch. 6]

    Parameters
    ----------
    belief : (N,) float        POC per cell
    transition : (N, N)        P(to j | from i), dense or scipy.sparse; what is missing from one in a row leaves the map

    Examples
    --------
    >>> predict(np.array([1.0, 0.0]), np.array([[0.25, 0.75], [0.0, 1.0]]))
    array([0.25, 0.75])
    """
    moved: NDArray[np.float64] = np.asarray(belief @ transition)
    return moved
