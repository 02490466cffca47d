"""Targets that are hidden in the cells of an evidence grid, what looks at them answer, and what answers teach."""

from __future__ import annotations

import numpy as np
from numpy.random import SeedSequence, default_rng
from numpy.typing import NDArray

from sooner.missions.sight import Sight

__all__ = ["PURPOSE", "HiddenTargets", "theta_after"]

PURPOSE = 4  # of the random numbers of a seed; a simulation over streets has 0 to 3

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


class HiddenTargets:
    """In each cell a target or none, as the evidence has it.

    What the k-th look at a cell answers is settled by (seed, cell, k) alone: two plans of one seed meet the same
    targets and the same errors, however they come to look there.

    there : (N,) bool       cells with a target
    looks, hits : (N,)      looks taken so far, and those that said yes
    first : (N,) float      when a look first said yes where a target is; inf never
    false_alarms : int      looks that said yes where none is
    """

    def __init__(self, sight: Sight, seed: int) -> None:
        sequence = SeedSequence(entropy=seed, spawn_key=(PURPOSE,))
        theta = sight.theta.ravel()
        self.there: Flags = default_rng(sequence).random(theta.size) < theta
        self.looks, self.hits = np.zeros(theta.size, np.int64), np.zeros(theta.size, np.int64)
        self.first: Floats = np.full(theta.size, np.inf)
        self.false_alarms = 0
        self._chance = np.where(self.there, sight.glimpse.ravel(), sight.false_alarm)
        self._noise = sequence.spawn(1)[0].generate_state(1, np.uint64)[0]

    def look(self, cells: Ints, times: Floats) -> None:
        """Take these looks, in order of time; a cell may come more than once."""
        order = np.argsort(cells, kind="stable")
        grouped = cells[order]
        counts = np.bincount(cells, minlength=self.looks.size)
        rank = np.arange(len(cells)) - np.repeat(np.cumsum(counts) - counts, counts)
        yes = self._uniform(grouped, self.looks[grouped] + rank) < self._chance[grouped]
        np.add.at(self.hits, grouped[yes], 1)
        self.looks += counts
        right = yes & self.there[grouped]
        np.minimum.at(self.first, grouped[right], times[order][right])
        self.false_alarms += int((yes & ~right).sum())

    def _uniform(self, cells: Ints, numbers: Ints) -> Floats:
        """(n,) float in [0, 1): for the look of that number at each cell, by SplitMix64 (Steele, Lea, Flood 2014)."""
        word = _mixed(_mixed(np.full(len(cells), self._noise), cells.astype(np.uint64)), numbers.astype(np.uint64))
        return np.asarray((word >> np.uint64(11)) * 2.0**-53)


def _mixed(word: NDArray[np.uint64], number: NDArray[np.uint64]) -> NDArray[np.uint64]:
    z = (word ^ number) + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(z ^ (z >> np.uint64(31)))


def theta_after(theta: Floats, detect: Floats, alarm: float, looks: Ints, hits: Ints) -> Floats:
    """P(a target is in each cell) after looks, of which `hits` said yes.

    odds = theta / (1 - theta)  (d / f)^hits  ((1 - d) / (1 - f))^(looks - hits)        [Kuhlman2017, section 3]

    Examples
    --------
    >>> one, two = np.array([1]), np.array([2])
    >>> theta_after(np.array([0.5]), np.array([0.8]), 0.2, two, one), theta_after(np.array([0.5]), 0.8, 0.2, one, one)
    (array([0.5]), array([0.8]))
    """
    from scipy.special import expit, logit, xlog1py, xlogy

    there = xlogy(hits, detect) + xlog1py(looks - hits, -np.asarray(detect))
    empty = xlogy(hits, alarm) + xlog1py(looks - hits, -alarm)
    return np.asarray(expit(logit(theta) + there - empty))
