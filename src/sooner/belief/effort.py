"""Search effort: how long people on the ground will search a cell, after the drone's looks [Kuhlman2017, section 5.5].

They search until they find somebody or are sure enough that nobody is there. Looks from the air spare them ground.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.belief.evidence import log_odds_from_counts
from sooner.errors import InvalidProblemError

__all__ = ["Variant", "effort_by_looks", "expected_effort", "expected_search_time", "search_time_limit"]

Variant = Literal["corrected", "printed"]
Floats = NDArray[np.float64]


def search_time_limit(prior: ArrayLike, threshold: float, tau: float = 1.0) -> Floats:
    """How long a cell is searched in vain before it is given up.

    P(D | X = 1, t) = 1 - e^(-t / tau)                                                   [Kuhlman2017, eq. (8)]
    P(X = 1 | no D, t) = P0 e^(-t / tau) / (1 - P0 + P0 e^(-t / tau))                    [Kuhlman2017, eq. (9)]
    T_neg = -tau log(P_neg (1 - P0) / (P0 (1 - P_neg))), and 0 where P0 < P_neg          [Kuhlman2017, eq. (10)]

    Parameters
    ----------
    prior                    P0, probabilities of any shape
    threshold : float        P_neg, in (0, 1): give up when the target is there with less than this probability
    tau : float              time constant of detection; T_neg has its unit

    Examples
    --------
    >>> search_time_limit([0.005, 0.5], threshold=0.01).round(3)
    array([0.   , 4.595])
    """
    _check(prior, threshold, tau)
    p = np.asarray(prior, np.float64)
    with np.errstate(divide="ignore"):
        log_odds = np.log(p) - np.log1p(-p)
    return _limit(log_odds, threshold, tau)


def expected_search_time(
    prior: ArrayLike, threshold: float, tau: float = 1.0, variant: Variant = "corrected"
) -> Floats:
    """E[T | P0]: how long a cell is searched, expected over whether somebody is there and when they are found.

    corrected:  E[T | P0] = T_neg (1 - P0) + tau (1 - e^(-T_neg / tau)) P0
    printed:    E[T | P0] = T_neg (1 - P0) + (tau - e^(-T_neg / tau) (T_neg + tau)) P0   [Kuhlman2017, eq. (11)]

    Parameters
    ----------
    prior, threshold, tau    as for `search_time_limit`
    variant                  "corrected" or "printed"

    Notes
    -----
    The printed equation integrates t e^(-t / tau) / tau up to T_neg and stops: targets that are there but not found
    in time, of probability P0 e^(-T_neg / tau), are searched for T_neg as well, and are left out. The difference is
    T_neg (1 - P0) P_neg / (1 - P_neg), 0.023 of 2.793 at P0 = 0.5 and P_neg = 1 %.

    Examples
    --------
    >>> float(expected_search_time(0.5, 0.01)), float(expected_search_time(0.5, 0.01, variant="printed"))
    (2.7925..., 2.7693...)
    """
    _check(prior, threshold, tau)
    p = np.asarray(prior, np.float64)
    with np.errstate(divide="ignore"):
        log_odds = np.log(p) - np.log1p(-p)
    return _time(log_odds, threshold, tau, variant)


def effort_by_looks(
    theta: ArrayLike,
    looks: int,
    detect: float,
    false_alarm: float = 0.0,
    *,
    threshold: float = 0.01,
    tau: float = 1.0,
    variant: Variant = "corrected",
) -> Floats:
    """Expected search time of each cell after 0, 1, ..., `looks` looks that are still to come.

    E[T | k looks] = sum_m P(M_k = m) E[T | P0 = P(X = 1 | M_k = m)],  M_k hits in k looks    [Kuhlman2017, eq. (12)]

    Parameters
    ----------
    theta : (N,) float           P(a target is there) before the looks
    looks : int                  K
    detect, false_alarm : float  p_d and p_f of a look
    threshold, tau, variant      as for `expected_search_time`

    Returns
    -------
    (N, K + 1) float             in units of tau. Times (K + 1,) shares of cells with so many looks: what a flight
                                 leaves to the ground on average

    Notes
    -----
    Equation (12) prints the posterior as a factor, which would make the sum a probability of presence; it is meant as
    the outcomes p = P(X = 1 | K = k, M_k = m), each with probability P(M_k = m | k) P(K = k). Above the threshold
    E[T | P0] is concave, so that looks spare effort while no outcome leads below it; a cell below the threshold costs
    nothing unsearched, and there a look can only raise the effort.

    Examples
    --------
    The paper's sensor and threshold, at 0, 1, 2 and 3 looks:

    >>> effort_by_looks([0.5], 3, 0.85, 0.15, variant="printed").round(3)
    array([[2.769, 2.168, 1.567, 1.153]])
    """
    _check(theta, threshold, tau)
    if looks < 0:
        raise InvalidProblemError(f"{looks} looks came; expected at least 0")
    distinct, inverse = np.unique(np.ravel(np.asarray(theta, np.float64)), return_inverse=True)
    columns = [_after(distinct, k, detect, false_alarm, threshold, tau, variant) for k in range(looks + 1)]
    return np.stack(columns, axis=1)[inverse]


def expected_effort(
    theta: ArrayLike,
    looks: ArrayLike,
    detect: float,
    false_alarm: float = 0.0,
    *,
    threshold: float = 0.01,
    tau: float = 1.0,
    variant: Variant = "corrected",
) -> Floats:
    """Expected search time of each cell after as many looks as a flight gives it.

    Parameters
    ----------
    theta : (N,) float           P(a target is there) before the flight
    looks : (N,) int             K, looks of the flight at each cell
    detect, false_alarm, ...     as for `effort_by_looks`

    Returns
    -------
    (N,) float                   in units of tau; its mean over the free cells is the paper's effort

    Examples
    --------
    >>> expected_effort([0.5, 0.5], [0, 2], 0.85, 0.15, variant="printed").round(3)
    array([2.769, 1.567])
    """
    counts = np.ravel(np.asarray(looks))
    cells = np.ravel(np.asarray(theta, np.float64))
    if counts.shape != cells.shape or counts.dtype.kind not in "iu" or (counts < 0).any():
        raise InvalidProblemError(
            f"{counts.size} numbers of looks of type {counts.dtype} came for {cells.size} cells; expected whole "
            "numbers of at least 0, one for each cell"
        )
    effort = np.empty(cells.size)
    for k in np.unique(counts):
        here = counts == k
        distinct, inverse = np.unique(cells[here], return_inverse=True)
        _check(distinct, threshold, tau)
        effort[here] = _after(distinct, int(k), detect, false_alarm, threshold, tau, variant)[inverse]
    return effort


def _after(
    theta: Floats, k: int, detect: float, false_alarm: float, threshold: float, tau: float, variant: Variant
) -> Floats:
    """(N,): expected search time after k looks."""
    present, absent = _binomial(k, detect), _binomial(k, false_alarm)  # (k + 1,), by number of hits
    chance = theta[:, None] * present + (1.0 - theta)[:, None] * absent
    hits = np.arange(k + 1)
    log_odds = log_odds_from_counts(theta[:, None], k - hits, hits, detect, false_alarm)
    time = _time(np.where(np.isnan(log_odds), -np.inf, log_odds), threshold, tau, variant)
    return np.asarray((chance * time).sum(axis=1))


def _binomial(k: int, p: float) -> Floats:
    """P(m of k), m = 0, ..., k."""
    chance = np.ones(1)
    for _ in range(k):
        chance = np.pad(chance * (1.0 - p), (0, 1)) + np.pad(chance * p, (1, 0))
    return chance


def _limit(log_odds: Floats, threshold: float, tau: float) -> Floats:
    """T_neg: log-odds fall by one in each time constant, until they are those of the threshold."""
    return np.asarray(tau * np.maximum(log_odds - (np.log(threshold) - np.log1p(-threshold)), 0.0))


def _time(log_odds: Floats, threshold: float, tau: float, variant: Variant) -> Floats:
    """E[T | P0] of log-odds; somebody certainly there is searched for until found, tau on average."""
    if variant not in ("corrected", "printed"):
        raise InvalidProblemError(f"variant {variant!r} came; expected 'corrected' or 'printed'")
    certain = np.isposinf(log_odds)
    limit = _limit(np.where(certain, 0.0, log_odds), threshold, tau)
    present, absent = np.exp(-np.logaddexp(0.0, -log_odds)), np.exp(-np.logaddexp(0.0, log_odds))
    unfound = np.where(certain, 0.0, np.exp(-limit / tau))
    found = tau * (1.0 - unfound) if variant == "corrected" else tau - unfound * (limit + tau)
    return np.asarray(limit * absent + found * present)


def _check(prior: ArrayLike, threshold: float, tau: float) -> None:
    p = np.asarray(prior, np.float64)
    if not ((p >= 0) & (p <= 1)).all():
        raise InvalidProblemError("a prior came outside [0, 1]; expected probabilities")
    if not 0.0 < threshold < 1.0:
        raise InvalidProblemError(f"threshold = {threshold} came; expected a probability above 0 and below 1")
    if not 0.0 < tau < np.inf:
        raise InvalidProblemError(f"tau = {tau} came; expected a time above 0")
