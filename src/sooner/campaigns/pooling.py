"""What may be said of trials in several places: all as one sample, or the mean of the places' means.

Trials of one seed in several places are drawn together, because they are not independent of each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from sooner.campaigns.statistics import (
    AT_ONCE,
    BOOTSTRAP_MOST,
    RESAMPLES,
    BySeed,
    Estimate,
    Floats,
    Z,
    checked,
    estimate,
    interval_ends,
    rate,
    wilson,
)
from sooner.errors import InvalidProblemError

__all__ = ["across", "pooled"]


def pooled(parts: Sequence[BySeed], statistic: str = "mean", resamples: int = RESAMPLES) -> Estimate:
    """A statistic, or "rate", of the trials of several places as one sample; of one place as `estimate`, or `rate`.

    Trials of one seed are not independent: they may share the luck of the seed. The interval is therefore a bootstrap
    over seeds, in which all trials of a seed are drawn together (A. C. Davison & D. V. Hinkley, Bootstrap Methods and
    their Application, 1997, section 3.8), expanded as in `estimate` by the number of seeds. The places are those asked
    for: the interval says how far other seeds may lead, not other places. With N trials, r_s the sum over a seed's
    trials of what each adds to the statistic (below), the variance of the statistic is v = sum r_s^2; then

        above 1000 seeds   mean and deviation -/+ 1.96 sqrt(v); of the median, the ranks
                           N (1/2 -/+ 1.96 sqrt(v')), v' that of the share of trials below it
                           (R. S. Woodruff 1952, JASA 47, 635-646)
        rate               Wilson's of min(N, p (1 - p) / v) trials, of as many as there are seeds if p is 0 or 1
                           (as E. L. Korn & B. I. Graubard 1998, Survey Methodology 24, 193-201, do for Clopper's)

        mean and rate (x - m) / N,      deviation ((x - m)^2 - s^2) / (2 s N),      share below (1{x <= m} - 1/2) / N

    Parameters
    ----------
    parts : sequence of (seeds, values)    of each place; both (n,), seeds each once, values finite

    Examples
    --------
    >>> here = np.arange(6), np.array([0.1, 0.9, 0.4, 0.3, 0.2, 0.5])
    >>> alone, eight = pooled([here]), pooled([here] * 8)
    >>> (eight.n, round(eight.low, 9), round(eight.high, 9)) == (48, round(alone.low, 9), round(alone.high, 9))
    True
    """
    parts = [(seeds, values) for seeds, values in parts if len(values)]
    whole = checked(np.concatenate([values for _, values in parts]) if parts else [])
    yes_no = statistic == "rate"
    if len(parts) == 1:
        return rate(int(whole.sum()), len(whole)) if yes_no else estimate(whole, statistic, resamples)
    table = _table(parts)
    seeds, n = len(table), len(whole)
    if yes_no:
        p = float(whole.mean())
        return wilson(p, _worth(p, n, np.nansum(table - p, axis=1) / n), n)
    plain = estimate(whole, statistic, 1)
    if seeds == 1 or (whole == whole[0]).all():
        return Estimate(plain.value, plain.value, plain.value, n)
    if seeds > BOOTSTRAP_MOST:
        return _pooled_closed(table, whole, statistic, plain.value)
    ends = np.concatenate([_OF_ROWS[statistic](drawn) for drawn in _resampled_seeds(table, resamples)])
    low, high = interval_ends(ends, seeds)
    return Estimate(plain.value, low, high, n)


def across(parts: Sequence[BySeed], yes_no: bool = False, resamples: int = RESAMPLES) -> Estimate:
    """The mean of the places' means, each place counting the same, with the interval of `pooled`; n counts seeds.

    Parameters
    ----------
    parts : sequence of (seeds, values)    of each place, none of them empty
    yes_no : bool                          then values are 0 and 1, and the interval is Wilson's

    Examples
    --------
    >>> across([(np.arange(4), np.full(4, 1.0)), (np.arange(2), np.full(2, 2.0))])
    Estimate(value=1.5, low=1.5, high=1.5, n=4)
    """
    table = _table(parts)
    seeds, there = len(table), ~np.isnan(table)
    count = there.sum(axis=0)
    if not len(parts) or not count.all():
        raise InvalidProblemError("a place without a number came; expected a number of every place")
    means = np.nansum(table, axis=0) / count
    value = float(means.mean())
    influence = np.nansum((table - means) / count, axis=1) / len(parts)
    if yes_no:
        return wilson(value, _worth(value, int(count.sum()), influence), seeds)
    if seeds == 1 or not np.nanmax(np.nanmax(table, axis=0) - np.nanmin(table, axis=0)):
        return Estimate(value, value, value, seeds)
    if seeds > BOOTSTRAP_MOST:
        half = Z * float((influence**2).sum()) ** 0.5
        return Estimate(value, value - half, value + half, seeds)
    sums, held = np.nan_to_num(table - means), there.astype(np.float64)
    with np.errstate(invalid="ignore"):  # a resample may lack all seeds of a place: it says nothing
        often = _how_often(seeds, resamples)
        ends = ((often @ sums) / (often @ held)).mean(axis=1)
    low, high = interval_ends(ends[~np.isnan(ends)], seeds)
    return Estimate(value, value + low, value + high, seeds)


def _table(parts: Sequence[BySeed]) -> Floats:
    """(seeds, places), NaN where a place has no such seed."""
    seeds = np.unique(np.concatenate([seeds for seeds, _ in parts])) if parts else np.zeros(0, np.int64)
    table = np.full((len(seeds), len(parts)), np.nan)
    for column, (own, values) in enumerate(parts):
        table[np.searchsorted(seeds, own), column] = values
    return table


def _worth(p: float, n: int, influence: Floats) -> float:
    """How many independent trials n of them are worth for a rate."""
    variance = float((influence**2).sum())
    if p in (0.0, 1.0):
        return len(influence)
    return min(n, p * (1.0 - p) / variance) if variance else n


def _resampled_seeds(table: Floats, resamples: int) -> Iterator[Floats]:
    """(rows, seeds * places), NaN where a place has no such seed: as `_resampled`, whole seeds at a time."""
    rng, (seeds, places) = np.random.default_rng(0), table.shape
    rows = max(AT_ONCE // table.size, 1)
    for first in range(0, resamples, rows):
        some = min(rows, resamples - first)
        yield table[rng.integers(0, seeds, (some, seeds))].reshape(some, seeds * places)


@lru_cache(maxsize=1)
def _how_often(seeds: int, resamples: int) -> Floats:
    """(resamples, seeds): how often each seed is in each resample; kept, as most tables have as many seeds."""
    rng, often = np.random.default_rng(0), np.empty((resamples, seeds))
    for row in often:
        row[:] = np.bincount(rng.integers(0, seeds, seeds), minlength=seeds)
    often.flags.writeable = False
    return often


def _pooled_medians(drawn: Floats) -> Floats:
    drawn.sort(axis=1)  # NaN last
    n = (~np.isnan(drawn)).sum(axis=1)
    middle = np.stack([(n - 1) // 2, n // 2], axis=1)
    return np.asarray(np.take_along_axis(drawn, middle, axis=1).mean(axis=1))


def _pooled_deviations(drawn: Floats) -> Floats:
    """Of n - 1; a resample of one value has none, and deviates by 0."""
    n = (~np.isnan(drawn)).sum(axis=1)
    return np.asarray(np.nanstd(drawn, axis=1) * (n / np.maximum(n - 1, 1)) ** 0.5)


def _pooled_means(drawn: Floats) -> Floats:
    return np.asarray(np.nanmean(drawn, axis=1))


_OF_ROWS = {"mean": _pooled_means, "median": _pooled_medians, "deviation": _pooled_deviations}


def _pooled_closed(table: Floats, whole: Floats, statistic: str, value: float) -> Estimate:
    """Of very many seeds."""
    n = len(whole)
    if statistic == "median":
        below = np.where(np.isnan(table), np.nan, table <= value)
        half = Z * float((np.nansum(below - 0.5, axis=1) ** 2).sum()) ** 0.5
        ranks = np.clip([int(n / 2 - half) - 1, int(np.ceil(n / 2 + half))], 0, n - 1)
        low, high = np.partition(whole, ranks)[ranks]
        return Estimate(value, float(low), float(high), n)
    mean = whole.mean()
    adds = table - mean if statistic == "mean" else ((table - mean) ** 2 - value**2) / (2.0 * value)
    half = Z * float((np.nansum(adds, axis=1) ** 2).sum()) ** 0.5 / n
    return Estimate(value, value - half if statistic == "mean" else max(value - half, 0.0), value + half, n)
