"""What may be said of planner against planner: their differences, seed by seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sooner.campaigns.results import Results
from sooner.campaigns.statistics import BySeed, Estimate, Floats, estimate
from sooner.errors import InvalidProblemError

__all__ = ["Paired", "differences", "differences_by_seed", "paired", "sign_test"]


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
