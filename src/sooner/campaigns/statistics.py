"""What may be said of many trials: an estimate with its interval, a rate, a paired difference.

All intervals are of 95 %. An estimate of few trials is bootstrapped, always with the same resamples; an estimate of
many has a closed form, so that a million trials cost little more than to read them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.campaigns.results import Results
from sooner.errors import InvalidProblemError

__all__ = ["Conditional", "Estimate", "Paired", "conditional", "differences", "estimate", "paired", "rate", "sign_test"]

Floats = NDArray[np.float64]

BOOTSTRAP_MOST = 1000  # trials; above that the closed forms
STATISTICS = ("mean", "median", "deviation")
Z = 1.959963984540054  # of the standard normal, 2.5 % lie above
_AT_ONCE = 2**17  # resampled values held at a time: they fit in a cache


@dataclass(frozen=True)
class Estimate:
    """A statistic of n trials, with its 95 % interval."""

    value: float
    low: float
    high: float
    n: int


def estimate(sample: ArrayLike, statistic: str = "mean", resamples: int = 4000) -> Estimate:
    """Mean, median or standard deviation of a sample, with its 95 % interval.

    Up to 1000 trials by a percentile bootstrap (B. Efron 1979, Annals of Statistics 7, 1-26), always with the same
    resamples: between the 2.5 % and the 97.5 % point of the statistic of `resamples` samples drawn from the sample
    with replacement. With fewer than about 10 trials that is too narrow: no resample is more extreme than the sample
    itself, and its deviation lacks the factor sqrt(n / (n - 1)). Three trials cannot tell more than three trials.

    Above 1000 trials, with s the deviation, x_(k) the k-th smallest, and q the least number for which
    P(B <= q) >= 2.5 %, B binomial of n and 1/2:

        mean      m -/+ 1.96 s / sqrt(n)
        median    x_(q) to x_(n+1-q)             (H. A. David, Order Statistics, 2nd ed. 1981, section 2.5)
        deviation s -/+ 1.96 sqrt((m4 - s^4) / n) / (2 s), m4 the fourth central moment

    Parameters
    ----------
    sample : (n,) float        all finite; see `conditional` for a measure that some trials lack
    statistic : str            "mean", "median" or "deviation", for which two trials are the least

    Raises
    ------
    InvalidProblemError        if the sample is empty or holds what is no finite number

    Examples
    --------
    >>> estimate([2.0, 2.0, 2.0])
    Estimate(value=2.0, low=2.0, high=2.0, n=3)
    >>> estimate(range(1, 2002), "median")
    Estimate(value=1001.0, low=957.0, high=1045.0, n=2001)
    """
    values = _sample(sample)
    if statistic not in STATISTICS:
        raise InvalidProblemError(f"statistic {statistic!r} came; expected one of {', '.join(STATISTICS)}")
    if statistic == "deviation" and len(values) < 2:
        raise InvalidProblemError("one trial came for a deviation; expected at least two")
    if len(values) <= BOOTSTRAP_MOST:
        return _bootstrapped(values, statistic, resamples)
    return {"mean": _normal_mean, "median": _ranked_median, "deviation": _normal_deviation}[statistic](values)


def _sample(sample: ArrayLike) -> Floats:
    values = np.asarray(sample, np.float64)
    if values.ndim != 1 or not len(values):
        raise InvalidProblemError(f"a sample of shape {values.shape} came; expected (n,) with at least one trial")
    if strange := int((~np.isfinite(values)).sum()):
        raise InvalidProblemError(
            f"{strange} of {len(values)} values are NaN or infinite; "
            "leave those trials out and say so, as conditional does"
        )
    return values


def _bootstrapped(values: Floats, statistic: str, resamples: int) -> Estimate:
    of = {"mean": _row_means, "median": _row_medians, "deviation": _row_deviations}[statistic]
    value = float(of(values[None].copy())[0])
    if (values == values[0]).all():  # every resample is the sample
        return Estimate(value, value, value, len(values))
    low, high = np.percentile(np.concatenate([of(drawn) for drawn in _resampled(values, resamples)]), [2.5, 97.5])
    return Estimate(value, float(low), float(high), len(values))


def _resampled(values: Floats, resamples: int) -> Iterator[Floats]:
    """Resamples, (rows, n) at a time; the same numbers as if they were drawn at once."""
    rng, n = np.random.default_rng(0), len(values)
    rows = max(_AT_ONCE // n, 1)
    for first in range(0, resamples, rows):
        yield values[rng.integers(0, n, (min(rows, resamples - first), n))]


def _row_means(drawn: Floats) -> Floats:
    return np.asarray(np.mean(drawn, axis=1))


def _row_deviations(drawn: Floats) -> Floats:
    return np.asarray(np.std(drawn, axis=1, ddof=1))


def _row_medians(drawn: Floats) -> Floats:
    """As np.median, five times as fast."""
    n = drawn.shape[1]
    drawn.sort(axis=1)
    return np.asarray(np.mean(drawn[:, [(n - 1) // 2, n // 2]], axis=1))


def _normal_deviation(values: Floats) -> Estimate:
    s, fourth = float(values.std(ddof=1)), float(((values - values.mean()) ** 4).mean())
    half = Z * (max(fourth - s**4, 0.0) / len(values)) ** 0.5 / (2.0 * s) if s else 0.0
    return Estimate(s, max(s - half, 0.0), s + half, len(values))


def _normal_mean(values: Floats) -> Estimate:
    mean, half = float(values.mean()), Z * float(values.std(ddof=1)) / len(values) ** 0.5
    return Estimate(mean, mean - half, mean + half, len(values))


def _ranked_median(values: Floats) -> Estimate:
    from scipy.special import bdtrik

    n = len(values)
    q = int(np.ceil(bdtrik(0.025, n, 0.5)))
    ranks = [q - 1, (n - 1) // 2, n // 2, n - q]
    low, below, above, high = np.partition(values, ranks)[ranks]
    return Estimate(float((below + above) / 2), float(low), float(high), n)


def rate(successes: int, n: int) -> Estimate:
    """A share of n trials, with its Wilson interval.

    (p + z^2/2n -/+ z sqrt(p (1 - p) / n + z^2/4n^2)) / (1 + z^2/n)      (E. B. Wilson 1927, JASA 22, 209-212)

    It stays within [0, 1] and has a width even where all trials succeed or all fail, as a bootstrap has not.

    Raises
    ------
    InvalidProblemError        if there is no trial, or not 0 <= successes <= n

    Examples
    --------
    >>> none = rate(0, 20)
    >>> none.value, none.low, round(none.high, 3)
    (0.0, 0.0, 0.161)
    """
    if n < 1 or not 0 <= successes <= n:
        raise InvalidProblemError(f"{successes} successes of {n} trials came; expected 0 <= successes <= n, n >= 1")
    p, share = successes / n, Z**2 / n
    centre = (p + share / 2) / (1 + share)
    half = (p * (1 - p) * share + share**2 / 4) ** 0.5 / (1 + share)
    low, high = max(min(centre - half, p), 0.0), min(max(centre + half, p), 1.0)
    return Estimate(p, low if successes else 0.0, high if successes < n else 1.0, n)


@dataclass(frozen=True)
class Conditional:
    """An estimate over the trials that have the number: to be read as `n` out of `trials`.

    Parameters
    ----------
    estimate : Estimate or None    None where no trial has it
    trials : int                   all of them
    """

    estimate: Estimate | None
    trials: int

    @property
    def n(self) -> int:
        """How many trials have the number."""
        return 0 if self.estimate is None else self.estimate.n


def conditional(values: ArrayLike, statistic: str = "mean") -> Conditional:
    """An estimate over those trials that have the number, with how many that are.

    The mean time to find of the trials that found somebody says little alone: who finds only what is near is quick.
    It is read beside n out of all trials, which is why the two come together.

    Parameters
    ----------
    values : (n,) float        NaN where a trial has no such number

    Examples
    --------
    >>> conditional([3.0, float("nan"), 3.0])
    Conditional(estimate=Estimate(value=3.0, low=3.0, high=3.0, n=2), trials=3)
    """
    given = np.asarray(values, np.float64)
    there = given[~np.isnan(given)]
    return Conditional(estimate(there, statistic) if len(there) else None, len(given))


@dataclass(frozen=True)
class Paired:
    """Ours less theirs, seed by seed.

    Parameters
    ----------
    measure : str
    mean, median : Estimate    of the differences
    wins, ties, losses : int   seeds where ours is higher, the same, lower: for a time, a win is no praise
    p_value : float            of the sign test, two-sided and exact
    """

    measure: str
    mean: Estimate
    median: Estimate
    wins: int
    ties: int
    losses: int
    p_value: float

    @property
    def n(self) -> int:
        """Seeds that both have, where both have the number."""
        return self.wins + self.ties + self.losses


def paired(ours: Results, theirs: Results, measure: str) -> Paired:
    """Two cases compared over the seeds that they share.

    A shared seed is shared luck: the same hidden person, the same weather. In the difference that luck cancels, so the
    interval of the mean difference is narrower than two intervals side by side, often by much: planners whose
    intervals overlap may yet differ on every seed. Below about 10 seeds the percentile bootstrap is too narrow, see
    `estimate`; the sign test stays exact, and with 5 seeds cannot fall below 0.0625.

    Only trials where both have the number count. Where a number is missing because a planner failed, that favours it;
    compare the rates first.

    Raises
    ------
    InvalidProblemError        if the instances differ, either lacks the measure, or no seed has both numbers

    Examples
    --------
    >>> from sooner.campaigns.results import collect
    >>> ours = collect("hills", "climb", 90, [(seed, {"pos": 0.5 + seed / 10}) for seed in range(4)])
    >>> theirs = collect("hills", "greedy", 90, [(seed, {"pos": 0.5}) for seed in range(9)])
    >>> found = paired(ours, theirs, "pos")
    >>> found.n, round(found.mean.value, 3), (found.wins, found.ties, found.losses), found.p_value
    (4, 0.15, (3, 1, 0), 0.25)
    """
    found = differences(ours, theirs, measure)
    if not len(found):
        raise InvalidProblemError(
            f"{ours.planner} and {theirs.planner} share no seed where both have {measure}; "
            "fly both under the same seeds"
        )
    wins, losses = int((found > 0).sum()), int((found < 0).sum())
    return Paired(
        measure,
        estimate(found),
        estimate(found, "median"),
        wins,
        len(found) - wins - losses,
        losses,
        sign_test(wins, losses),
    )


def differences(ours: Results, theirs: Results, measure: str) -> Floats:
    """Ours less theirs over the shared seeds where both have the number, (n,), by ascending seed."""
    if ours.instance != theirs.instance:
        raise InvalidProblemError(
            f"{ours.instance} and {theirs.instance} came; seeds are shared luck on one instance only"
        )
    _, here, there = np.intersect1d(ours.seeds, theirs.seeds, assume_unique=True, return_indices=True)
    found = ours.measure(measure)[here] - theirs.measure(measure)[there]
    return np.asarray(found[~np.isnan(found)], np.float64)


def sign_test(wins: int, losses: int) -> float:
    """How probable is a split at least this uneven, were either as likely to win? Ties say nothing.

    min(1, 2 P(B <= min(wins, losses))), B binomial of wins + losses and 1/2      (J. Arbuthnot 1710, Phil. Trans. 27)

    For a measure that is yes or no this is the exact form of McNemar's test.

    Examples
    --------
    >>> sign_test(5, 0), sign_test(3, 3)
    (0.0625, 1.0)
    """
    from scipy.special import bdtr

    if wins < 0 or losses < 0:
        raise InvalidProblemError(f"{wins} wins and {losses} losses came; expected counts of at least 0")
    return min(1.0, 2 * float(bdtr(min(wins, losses), wins + losses, 0.5))) if wins != losses else 1.0
