"""What is hidden from a flight over cells or regions, by one seed, and what looks at it have answered."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator, SeedSequence, default_rng
from numpy.typing import NDArray

from sooner.belief import BetaGrid
from sooner.simulation.answers import AnswerModel

__all__ = ["Hidden", "Noise"]

# Of the random numbers of a seed. `world.Purpose` has this number too, for links of a search over streets, where nobody
# is `Hidden`: no flight draws both. It stays, as published trials have their hidden people by it.
PURPOSE = 4

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Noise:
    """Random numbers of a seed: a stream for what is hidden, and one number for each look at each cell."""

    def __init__(self, seed: int) -> None:
        self._sequence = SeedSequence(entropy=seed, spawn_key=(PURPOSE,))
        self._word = self._sequence.spawn(1)[0].generate_state(1, np.uint64)[0]

    def stream(self) -> Generator:
        """Of what is hidden."""
        return default_rng(self._sequence)

    def of_looks(self, cells: Ints, numbers: Ints) -> Floats:
        """(n,) float in [0, 1): for the look of that number at each cell, by SplitMix64 (Steele, Lea, Flood 2014)."""
        word = _mixed(_mixed(np.full(len(cells), self._word), cells.astype(np.uint64)), numbers.astype(np.uint64))
        return np.asarray((word >> np.uint64(11)) * 2.0**-53)


class Hidden:
    """Who is hidden where, as a seed has it, and what looks have come to so far.

    What the k-th look at a cell answers is settled by (seed, cell, k) alone: two plans of one seed meet the same
    people and the same errors, however they come to look there. Where looks correlate, answers after the first yes at
    the person's cell mean nothing.

    truth : (N,) float      1 where somebody is; where targets come and go, P(one is in view)
    looks, hits : (N,)      looks taken so far, and those that said yes
    first : (N,) float      when a look first said yes where somebody is; inf never
    false_alarms : int      looks that said yes where nobody is
    """

    def __init__(self, model: AnswerModel, seed: int) -> None:
        self.model, self.noise = model, Noise(seed)
        self.truth = model.truth(self.noise.stream())
        self.looks, self.hits = np.zeros(self.truth.size, np.int64), np.zeros(self.truth.size, np.int64)
        self.first: Floats = np.full(self.truth.size, np.inf)
        self.false_alarms = 0

    @property
    def there(self) -> Ints:
        """Cells that hold somebody who stays."""
        return np.zeros(0, np.int64) if isinstance(self.model.known, BetaGrid) else np.flatnonzero(self.truth)

    def look(self, cells: Ints, times: Floats) -> NDArray[np.bool_]:
        """Take these looks, in order of time; a cell may come more than once. (n,) bool: which of them say yes."""
        order = np.argsort(cells, kind="stable")
        grouped = cells[order]
        counts = np.bincount(cells, minlength=self.looks.size)
        rank = np.arange(len(cells)) - np.repeat(np.cumsum(counts) - counts, counts)
        numbers = self.looks[grouped] + rank
        yes = self.noise.of_looks(grouped, numbers) < self._chance(grouped, numbers)
        np.add.at(self.hits, grouped[yes], 1)
        self.looks += counts
        right = yes & (self.truth[grouped] > 0)
        np.minimum.at(self.first, grouped[right], times[order][right])
        self.false_alarms += int((yes & ~right).sum())
        answers = np.empty(len(cells), bool)
        answers[order] = yes
        return answers

    def _chance(self, cells: Ints, numbers: Ints) -> Floats:
        chance = self.model.chance(cells, self.truth[cells])
        own = np.flatnonzero(self.truth[cells] > 0) if self.model.correlation else cells[:0]
        if len(own):
            chance[own] = self.model.first_chance(int(cells[own[0]]), int(numbers[own].max()) + 1)[numbers[own]]
        return chance


def _mixed(word: NDArray[np.uint64], number: NDArray[np.uint64]) -> NDArray[np.uint64]:
    z = (word ^ number) + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(z ^ (z >> np.uint64(31)))
