"""Trials of a plan along legs: who is hidden is drawn, and each pass detects by what it is worth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import nan

import numpy as np
from numpy.typing import NDArray

from sooner.missions.plan_trials import PlanTrial
from sooner.missions.score import Score
from sooner.missions.sight import Sight
from sooner.sensors.swath import pod
from sooner.simulation.hidden import Noise

__all__ = ["LegFlyover"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LegFlyover:
    """A plan along legs as those who are hidden meet it: passes over each cell, in order of time.

    P(a pass detects | there) = 1 - exp(-e), e its effort; passes err by themselves, so that all of them together detect
    with 1 - exp(-sum of e), which is what the judge promises.

    Parameters
    ----------
    sight : Sight              where people may be
    cells : (n,) int64         that are passed
    times : (n,) float         seconds, rising
    chances : (n,) float       P(that pass detects who is there)
    """

    sight: Sight
    cells: Ints
    times: Floats
    chances: Floats

    @classmethod
    def of(cls, score: Score) -> LegFlyover:
        """The passes of a plan that has been scored."""
        problem = score.mission.problem
        flown = zip(problem.searchers, score.plan.actions, strict=True)
        looks = [searcher.moves.looks(problem.grid, searcher, actions) for searcher, actions in flown]
        cells, times = (np.concatenate([getattr(each, name) for each in looks]) for name in ("items", "times"))
        worth = np.concatenate([np.zeros(len(each.items)) if each.worth is None else each.worth for each in looks])
        order = np.argsort(times, kind="stable")
        return cls(score.mission.sight, cells[order].astype(np.int64), times[order], pod(worth[order]))

    def flown(self, seed: int) -> PlanTrial:
        """One flight against what this seed hides."""
        noise = Noise(seed)
        there = np.flatnonzero(self.sight.answers.truth(noise.stream()))
        times = np.array([time for cell in there.tolist() if (time := self._found_at(noise, cell)) is not None])
        first, mean = (float(times.min()), float(times.mean())) if len(times) else (nan, nan)
        return PlanTrial(seed, float(len(times)), len(times), len(there), first, mean)

    def _found_at(self, noise: Noise, cell: int) -> float | None:
        """When a pass first detects who is in a cell."""
        order, starts = self._by_cell
        own = order[starts[cell] : starts[cell + 1]]
        seen = noise.of_looks(np.full(len(own), cell), np.arange(len(own))) < self.chances[own]
        return float(self.times[own[np.argmax(seen)]]) if seen.any() else None

    @cached_property
    def _by_cell(self) -> tuple[Ints, Ints]:
        """Passes cell by cell, in order of time, and where those of each cell begin, (N + 1,)."""
        counts = np.bincount(self.cells, minlength=self.sight.theta.size)
        return np.argsort(self.cells, kind="stable"), np.append(0, np.cumsum(counts))
