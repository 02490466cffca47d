"""What may be said of many trials: an estimate with its interval, a rate, a paired difference.

All intervals are of 95 %. An estimate of few trials is bootstrapped, always with the same resamples; an estimate of
many has a closed form, so that a million trials cost little more than to read them. Trials of one seed in several
places are drawn together, because they are not independent of each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.campaigns.results import Results
from sooner.errors import InvalidProblemError

__all__ = [
    "BySeed",
    "Estimate",
    "Paired",
    "across",
    "differences",
    "differences_by_seed",
    "estimate",
    "paired",
    "pooled",
    "rate",
    "sign_test",
]

Floats = NDArray[np.float64]
BySeed = tuple[NDArray[np.int64], Floats]  # seeds, each once, and a number of each

BOOTSTRAP_MOST = 1000  # trials, or seeds where they are drawn together; above that the closed forms
STATISTICS = ("mean", "median", "deviation")
RESAMPLES = 4000
Z = 1.959963984540054  # of the standard normal, 2.5 % lie above
_AT_ONCE = 2**17  # resampled values held at a time: they fit in a cache


@dataclass(frozen=True)
class Estimate:
    """A statistic of n trials, with its 95 % interval."""

    value: float
    low: float
    high: float
    n: int


def estimate(sample: ArrayLike, statistic: str = "mean", resamples: int = RESAMPLES) -> Estimate:
    """Mean, median or standard deviation of a sample, with its 95 % interval.

    Up to 1000 trials by a bootstrap (B. Efron 1979, Annals of Statistics 7, 1-26), always with the same resamples: the
    statistic of `resamples` samples drawn from the sample with replacement, between its points a/2 and 1 - a/2. With
    a = 5 % that is too narrow for few trials, whose resamples spread by sqrt((n - 1) / n) too little, and as a normal
    law does where a t law is due. So it is expanded (T. C. Hesterberg 2015, The American Statistician 69, 371-386):

        a/2 = Phi(-sqrt(n / (n - 1)) t),      t the 97.5 % point of Student's law of n - 1

    How often it holds the truth, in percent of 2000 samples, with a = 5 % and expanded (one standard error is 0.5):

        law            n = 3          5              10             20             50
        normal         mean      75 -> 75       84 -> 92       91 -> 94       93 -> 96       94 -> 95
                       median    75 -> 75       94 -> 94       94 -> 96       94 -> 96       95 -> 96
                       deviation 44 -> 44       68 -> 72       78 -> 82       87 -> 90       91 -> 92
        exponential    mean      69 -> 69       77 -> 86       86 -> 91       89 -> 92       92 -> 93
                       median    73 -> 73       93 -> 93       94 -> 96       94 -> 96       95 -> 96
                       deviation 32 -> 32       47 -> 50       60 -> 64       70 -> 72       82 -> 82

    A paired difference is a mean or median too. Of three trials no resample is more extreme than the trials
    themselves; a deviation wants fifty trials, and more where the tail is long. One trial has no interval: low and high
    are its value.

    Above 1000 trials, with s the deviation, x_(k) the k-th smallest, and q the least number for which
    P(B <= q) >= 2.5 %, B binomial of n and 1/2:

        mean      m -/+ 1.96 s / sqrt(n)
        median    x_(q) to x_(n+1-q)             (H. A. David, Order Statistics, 2nd ed. 1981, section 2.5)
        deviation s -/+ 1.96 sqrt((m4 - s^4) / n) / (2 s), m4 the fourth central moment

    Parameters
    ----------
    sample : (n,) float        all finite
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
            f"{strange} of {len(values)} values are NaN or infinite; leave those trials out, and say of how many it is"
        )
    return values


def _bootstrapped(values: Floats, statistic: str, resamples: int) -> Estimate:
    of = {"mean": _row_means, "median": _row_medians, "deviation": _row_deviations}[statistic]
    value = float(of(values[None].copy())[0])
    if (values == values[0]).all():  # every resample is the sample
        return Estimate(value, value, value, len(values))
    low, high = _between(np.concatenate([of(drawn) for drawn in _resampled(values, resamples)]), len(values))
    return Estimate(value, low, high, len(values))


def _between(drawn: Floats, n: int) -> tuple[float, float]:
    """The ends of the interval: of the statistic of resamples that were drawn from n."""
    low, high = np.quantile(drawn, [_tail(n), 1.0 - _tail(n)])
    return float(low), float(high)


@cache
def _tail(n: int) -> float:
    """The share of resamples below the interval, and above it, n >= 2.

    >>> [round(100 * _tail(n), 4) for n in (5, 20, 1000)]
    [0.0954, 1.5881, 2.4804]
    """
    from scipy.special import ndtr, stdtrit

    return float(ndtr(-((n / (n - 1)) ** 0.5) * stdtrit(n - 1, 0.975)))


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
    return _wilson(successes / n, n, n)


def _wilson(p: float, worth: float, n: int) -> Estimate:
    """Of a share of n trials that are worth so many independent ones."""
    share = Z**2 / worth
    centre = (p + share / 2) / (1 + share)
    half = (p * (1 - p) * share + share**2 / 4) ** 0.5 / (1 + share)
    low, high = max(min(centre - half, p), 0.0), min(max(centre + half, p), 1.0)
    return Estimate(p, low if p > 0 else 0.0, high if p < 1 else 1.0, n)


# ---------------------------------------------------------------- several places


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
    whole = _sample(np.concatenate([values for _, values in parts]) if parts else [])
    yes_no = statistic == "rate"
    if len(parts) == 1:
        return rate(int(whole.sum()), len(whole)) if yes_no else estimate(whole, statistic, resamples)
    table = _table(parts)
    seeds, n = len(table), len(whole)
    if yes_no:
        p = float(whole.mean())
        return _wilson(p, _worth(p, n, np.nansum(table - p, axis=1) / n), n)
    plain = estimate(whole, statistic, 1)
    if seeds == 1 or (whole == whole[0]).all():
        return Estimate(plain.value, plain.value, plain.value, n)
    if seeds > BOOTSTRAP_MOST:
        return _pooled_closed(table, whole, statistic, plain.value)
    ends = np.concatenate([_OF_ROWS[statistic](drawn) for drawn in _resampled_seeds(table, resamples)])
    low, high = _between(ends, seeds)
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
        return _wilson(value, _worth(value, int(count.sum()), influence), seeds)
    if seeds == 1 or not np.nanmax(np.nanmax(table, axis=0) - np.nanmin(table, axis=0)):
        return Estimate(value, value, value, seeds)
    if seeds > BOOTSTRAP_MOST:
        half = Z * float((influence**2).sum()) ** 0.5
        return Estimate(value, value - half, value + half, seeds)
    sums, held = np.nan_to_num(table - means), there.astype(np.float64)
    with np.errstate(invalid="ignore"):  # a resample may lack all seeds of a place: it says nothing
        often = _how_often(seeds, resamples)
        ends = ((often @ sums) / (often @ held)).mean(axis=1)
    low, high = _between(ends[~np.isnan(ends)], seeds)
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
    rows = max(_AT_ONCE // table.size, 1)
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


# ---------------------------------------------------------------- planner against planner


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

    Seed by seed is a fair comparison always. It is a sharper one where the seed decides something that both planners
    meet: the map that is drawn, the hidden person, the weather. In the difference that luck cancels, and planners
    whose intervals overlap may yet differ on every seed. Where the map is fixed and the seed drives nothing but each
    planner's own random numbers, the two share no luck, and the interval of the difference is as wide as that of two
    separate samples. The sign test is exact for any number of seeds; of 5 it cannot fall below 0.0625.

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
    return differences_by_seed(ours, theirs, measure)[1]


def differences_by_seed(ours: Results, theirs: Results, measure: str) -> BySeed:
    """The same, with their seeds."""
    if ours.instance != theirs.instance:
        raise InvalidProblemError(
            f"{ours.instance} and {theirs.instance} came; planners are compared on the same instance"
        )
    seeds, here, there = np.intersect1d(ours.seeds, theirs.seeds, assume_unique=True, return_indices=True)
    found = ours.measure(measure)[here] - theirs.measure(measure)[there]
    kept = ~np.isnan(found)
    return seeds[kept], np.asarray(found[kept], np.float64)


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
