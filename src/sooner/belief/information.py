"""Information: how many bits further looks are expected to teach, by number of looks.

Three ways to one number: binomials over the number of hits (compiled, for maps), the chain rule over counts (the
paper's table), and one look in closed form, on which the chain rule stands. Cells whose rate is Beta have their own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebvander
from numpy.typing import ArrayLike, NDArray

from sooner.belief.evidence import binary_entropy, log_odds_from_counts, probabilities
from sooner.errors import InvalidProblemError

__all__ = ["beta_information", "beta_information_table", "information", "information_table", "look_information"]

Floats = NDArray[np.float64]
CHUNK = 16_384  # cells at a time, where memory is what counts
MANY = 4_096  # distinct cells from which on interpolation is the faster
NODES = 14  # of a polynomial over one unit of log-odds, on which information is analytic within pi: error 1e-15


def look_information(theta: ArrayLike, detect: ArrayLike, false_alarm: ArrayLike = 0.0) -> Floats:
    """Bits that one look is expected to teach.

    I(Z; X) = h(theta p_d + (1 - theta) p_f) - theta h(p_d) - (1 - theta) h(p_f)      [Kuhlman2017, eq. (15), q = 1]

    Arguments are probabilities of any shapes that broadcast; h is the entropy of a yes or no.

    Examples
    --------
    >>> look_information([0.5, 0.85, 1.0], 0.85, 0.15).round(3)
    array([0.39 , 0.209, 0.   ])
    """
    t, d, f = (np.asarray(values, np.float64) for values in (theta, detect, false_alarm))
    if t.size > CHUNK and d.ndim == f.ndim == 0:
        parts = (t.reshape(-1)[first : first + CHUNK] for first in range(0, t.size, CHUNK))
        return np.concatenate([look_information(part, d, f) for part in parts]).reshape(t.shape)
    bits = binary_entropy(t * d + (1.0 - t) * f) - t * binary_entropy(d) - (1.0 - t) * binary_entropy(f)
    return np.asarray(np.maximum(bits, 0.0))


def information(theta: ArrayLike, looks: int, detect: ArrayLike, false_alarm: ArrayLike = 0.0) -> Floats:
    """Bits that the first, second, ... look at each cell adds: I(k) - I(k - 1) for k = 1, ..., looks.

    I(k) = sum_{m, x} f(m | x) P(x) log2(f(m | x) / f(m)),  M | X binomial of k looks    [Kuhlman2017, eq. (15)]

    Parameters
    ----------
    theta : (N,) float         P(a target is there), in [0, 1]
    looks : int                L, at least 1
    detect, false_alarm        p_d and p_f, floats or (N,), in [0, 1]

    Returns
    -------
    (N, L) float               no row rises, none is negative, and none totals more than the entropy of its theta

    Raises
    ------
    InvalidProblemError        if a probability lies outside [0, 1], shapes differ or there are no looks

    Notes
    -----
    Computed as h(theta) less the entropy that k looks are expected to leave, which is the same sum and keeps its
    relative precision where little is left to learn: near theta = 0 and 1, for p_f = 0 and for p_d = 1. Equal cells
    are computed once, in time L^2 each. Thousands of different thetas under one sensor are read off polynomials
    through exact values, 14 for each unit of log-odds, which differ from the sum by rounding only.

    Examples
    --------
    >>> information([0.5, 0.03, 0.0], 3, 0.85, 0.15).round(3)
    array([[0.39 , 0.209, 0.137],
           [0.05 , 0.043, 0.031],
           [0.   , 0.   , 0.   ]])
    """
    columns = [np.ravel(probabilities(v, n)) for v, n in ((theta, "theta"), (detect, "p_d"), (false_alarm, "p_f"))]
    size = columns[0].size
    if any(values.size not in (1, size) for values in columns):
        raise InvalidProblemError(
            f"{size} cells came with {columns[1].size} p_d and {columns[2].size} p_f; expected one each, or as many"
        )
    if looks < 1:
        raise InvalidProblemError(f"{looks} looks came; expected at least 1")
    first, inverse = _distinct(columns)
    if len(first) < size:
        columns = [values[first] if values.size > 1 else values for values in columns]
    rows = _of_distinct(columns, looks)
    return rows if len(first) == size else np.asarray(rows[inverse])


def information_table(
    prior: float, misses: int, hits: int, looks: int, detect: float, false_alarm: float = 0.0
) -> Floats:
    """The paper's table I[nz0, nz1, q]: bits in q more looks, after nz0 misses and nz1 hits.

    I[n0, n1, q] = I(Z; X | n0, n1) + P(miss | n0, n1) I[n0 + 1, n1, q - 1] + P(hit | n0, n1) I[n0, n1 + 1, q - 1]

    The chain rule over counts, as looks are exchangeable         [Kuhlman2017, sections 5 and 6.3, Table 1].

    Parameters
    ----------
    prior : float              theta before any look; the paper has 0.5
    misses, hits, looks : int  the largest nz0, nz1 and q; the paper has 20, 20, 10
    detect, false_alarm        p_d and p_f

    Returns
    -------
    (misses + 1, hits + 1, looks + 1) float    zero where q = 0, and where such counts cannot be

    Notes
    -----
    All of Table 1 is this to its printed digits, but for I[1, 0, 2] and its mirror images: 0.3464, printed 0.347.

    Examples
    --------
    >>> information_table(0.5, 2, 2, 3, 0.85, 0.15)[:, 0, 1:].round(4)
    array([[0.3902, 0.5994, 0.7365],
           [0.2093, 0.3464, 0.4323],
           [0.0505, 0.0941, 0.1252]])
    """
    rows, cols = np.indices((misses + looks + 1, hits + looks + 1))
    log_odds = log_odds_from_counts(prior, rows, cols, detect, false_alarm)
    theta = np.exp(-np.logaddexp(0.0, -np.where(np.isnan(log_odds), -np.inf, log_odds)))
    one = look_information(theta, detect, false_alarm)
    return _chain_rule(one, theta * detect + (1.0 - theta) * false_alarm, looks)[: misses + 1, : hits + 1]


def beta_information(alpha: ArrayLike, beta: ArrayLike, looks: int) -> Floats:
    """Bits that each look adds about a rate X ~ Beta(alpha, beta), where Z ~ Bernoulli(X): I(k) - I(k - 1).

    I(k) - I(k - 1) = sum_m P(m) I1(alpha + m, beta + k - 1 - m),  m hits in k - 1 looks, beta-binomial
    I1(a, b) = log2 n - psi(n + 1) / ln 2 + [phi(a) + phi(b)] / n,  phi(u) = u [psi(u + 1) / ln 2 - log2 u],  n = a + b

    The chain rule of the second model of [Kuhlman2017, section 3]; I1 is h(E X) - E h(X), with the digamma psi.
    A rate is a real number, so that the information grows without limit, as log2(k) / 2.

    Parameters
    ----------
    alpha, beta : (N,) float   above 0
    looks : int                L, at least 1

    Returns
    -------
    (N, L) float               no row rises, none is negative

    Examples
    --------
    >>> beta_information([1.0, 20.0], [1.0, 20.0], 3).round(3)
    array([[0.279, 0.197, 0.153],
           [0.018, 0.017, 0.017]])
    """
    a, b = np.broadcast_arrays(*(np.ravel(np.asarray(values, np.float64)) for values in (alpha, beta)))
    if not ((a > 0) & (b > 0) & np.isfinite(a + b)).all():
        raise InvalidProblemError("alpha or beta came not above 0 or not finite")
    if looks < 1:
        raise InvalidProblemError(f"{looks} looks came; expected at least 1")
    first, inverse = _distinct([a, b])
    chunks = (first[start : start + CHUNK] for start in range(0, max(len(first), 1), CHUNK))
    return np.asarray(np.concatenate([_beta_rows(a[chunk], b[chunk], looks) for chunk in chunks])[inverse])


def beta_information_table(alpha: float, beta: float, misses: int, hits: int, looks: int) -> Floats:
    """As `information_table`, of a rate that was Beta(alpha, beta) before any look.

    Returns
    -------
    (misses + 1, hits + 1, looks + 1) float    bits in q more looks, after nz0 misses and nz1 hits
    """
    rows, cols = np.indices((misses + looks + 1, hits + looks + 1)).astype(np.float64)
    a, b = alpha + cols, beta + rows
    return _chain_rule(_beta_look(a, b), a / (a + b), looks)[: misses + 1, : hits + 1]


def _chain_rule(one: Floats, hit: Floats, looks: int) -> Floats:
    """I[n0, n1, q] from the information of one look and P(hit), both by counts; the last `looks` rows are not told."""
    table = np.zeros((*one.shape, looks + 1))
    for q in range(1, looks + 1):
        before = table[..., q - 1]
        table[..., q] = one
        table[:-1, :, q] += (1.0 - hit[:-1]) * before[1:]
        table[:, :-1, q] += hit[:, :-1] * before[:, 1:]
    return table


def _beta_look(a: Floats, b: Floats) -> Floats:
    """I1(a, b) of `beta_information`, in bits."""
    from scipy.special import psi

    n = a + b
    shares = [u * (psi(u + 1.0) - np.log(u)) / n for u in (a, b)]
    return np.asarray(np.maximum(np.log(n) - psi(n + 1.0) + shares[0] + shares[1], 0.0) / np.log(2.0))


def _beta_rows(a: Floats, b: Floats, looks: int) -> Floats:
    """`beta_information` of a few cells, (n, L); hits by Pólya's urn."""
    rows = np.empty((len(a), looks))
    chance = np.ones((len(a), 1))  # P(m hits in k looks), one column for each m
    for k in range(looks):
        more_a, more_b = a[:, None] + np.arange(k + 1), b[:, None] + np.arange(k, -1, -1)
        rows[:, k] = (chance * _beta_look(more_a, more_b)).sum(axis=1)
        hit = chance * more_a / (a + b + k)[:, None]
        chance = np.pad(chance - hit, ((0, 0), (0, 1))) + np.pad(hit, ((0, 0), (1, 0)))
    return np.asarray(np.minimum.accumulate(rows, axis=1))


def _distinct(columns: list[Floats]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where each distinct row first stands, and which of these every cell is."""
    codes = np.zeros(columns[0].size, np.int64)
    first = np.zeros(min(codes.size, 1), np.intp)
    for values in columns:
        if values.size > 1:
            _, own = np.unique(values, return_inverse=True)
            _, first, codes = np.unique(codes * (own.max() + 1) + own, return_index=True, return_inverse=True)
    return first, codes


def _of_distinct(columns: list[Floats], looks: int) -> Floats:
    """(N, L) of theta, p_d and p_f, each (N,) or (1,)."""
    theta, detect, false_alarm = columns
    if theta.size > MANY and detect.size == 1 and false_alarm.size == 1 and false_alarm[0] > 0:
        return _interpolated(theta, looks, float(detect[0]), float(false_alarm[0]))
    return _exact(theta, looks, detect, false_alarm)


def _exact(theta: Floats, looks: int, detect: ArrayLike, false_alarm: ArrayLike) -> Floats:
    from sooner.belief import _information_kernels

    kernel: Any = _information_kernels.information
    out = np.empty((len(theta), looks))
    rates = (np.ascontiguousarray(np.broadcast_to(values, len(theta)), np.float64) for values in (detect, false_alarm))
    kernel(np.ascontiguousarray(theta), *rates, out)
    return out


def _interpolated(theta: Floats, looks: int, detect: float, false_alarm: float) -> Floats:
    """By Chebyshev interpolation in log-odds, one polynomial from each whole number to the next."""
    with np.errstate(divide="ignore"):
        log_odds = np.log(theta) - np.log1p(-theta)
    out = np.zeros((len(theta), looks))
    unsure = np.flatnonzero(np.isfinite(log_odds))
    below = np.floor(log_odds[unsure])
    order = np.argsort(below, kind="stable")
    panels, starts = np.unique(below[order], return_index=True)
    nodes = chebpts1(NODES)
    fit = chebvander(nodes, NODES - 1).T * np.where(np.arange(NODES) == 0, 1.0, 2.0)[:, None] / NODES
    values = _at_log_odds(np.ravel(panels[:, None] + (nodes + 1.0) / 2.0), looks, detect, false_alarm)
    coefficients = fit @ values.reshape(len(panels), NODES, looks)
    for panel, cells, polynomial in zip(panels, np.split(unsure[order], starts[1:]), coefficients, strict=True):
        out[cells] = chebvander(2.0 * (log_odds[cells] - panel) - 1.0, NODES - 1) @ polynomial
    np.maximum(out, 0.0, out=out)
    return np.asarray(np.minimum.accumulate(out, axis=1, out=out))


def _at_log_odds(log_odds: Floats, looks: int, detect: float, false_alarm: float) -> Floats:
    """(n, L); above zero with target and no target exchanged, as 1 - theta is then the number that is precise."""
    theta = np.exp(-np.logaddexp(0.0, np.abs(log_odds)))  # of the less likely answer
    likely = log_odds > 0
    rates = np.where(likely, false_alarm, detect), np.where(likely, detect, false_alarm)
    return _exact(theta, looks, *rates)
