"""Trials of a plan over cells or over regions: what is hidden is drawn, the plan is flown, and looks may err."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import nan
from typing import Any

import numpy as np
from numpy.random import Generator, SeedSequence, default_rng
from numpy.typing import NDArray

from sooner.belief import Belief, BetaGrid, EvidenceGrid
from sooner.belief.evidence import binary_entropy
from sooner.errors import UnsupportedProblemError
from sooner.missions.estimates import Mean
from sooner.missions.hidden import PURPOSE, HiddenTargets, theta_after
from sooner.missions.processes import for_each_seed
from sooner.missions.score import Score
from sooner.missions.sight import Sight
from sooner.problem import Plan, SearchProblem
from sooner.problem.regions import RegionMoves
from sooner.sensors import miss_after_looks

__all__ = ["COLUMNS", "Flyover", "PlanTrial", "PlanTrials", "fly_plan", "looks_of"]

COLUMNS = ("seed", "value", "found", "there", "first_s", "mean_s", "false_alarms")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Flyover:
    """Every look of a plan, in order of time: what a flight amounts to for those who are hidden.

    Parameters
    ----------
    sight : Sight                  what may be hidden where, and what a look sees of it
    cells : (n,) int64             that are looked at
    times : (n,) float             when, in the unit of the judge: steps over cells, seconds over regions
    """

    sight: Sight
    cells: Ints
    times: Floats

    @classmethod
    def of(cls, score: Score) -> Flyover:
        """The looks of a plan, cell by cell, without atoms and gains: as a camera would take them."""
        return cls(score.mission.sight, *looks_of(score.mission.problem, score.plan))

    @cached_property
    def counts(self) -> Ints:
        """(N,) int64: looks at each cell."""
        return np.bincount(self.cells, minlength=self.sight.theta.size)

    @cached_property
    def by_cell(self) -> tuple[Ints, Ints]:
        """Looks cell by cell, in order of time, and where those of each cell begin, (N + 1,)."""
        return np.argsort(self.cells, kind="stable"), np.append(0, np.cumsum(self.counts))

    def flown(self, seed: int) -> PlanTrial:
        """One flight against what this seed hides."""
        rng = default_rng(SeedSequence(entropy=seed, spawn_key=(PURPOSE,)))
        known = self.sight.known
        if isinstance(known, Belief):
            return self._person(seed, known, rng)
        if isinstance(known, EvidenceGrid):
            return self._targets(seed)
        return self._rates(seed, known, rng)

    def _person(self, seed: int, belief: Belief, rng: Generator) -> PlanTrial:
        """One person in one cell, or outside the map."""
        ends = np.cumsum(belief.poc.ravel())
        cell = int(np.searchsorted(ends, rng.random(), side="right"))
        there = cell < len(ends)
        order, starts = self.by_cell
        own = order[starts[cell] : starts[cell + 1]] if there else order[:0]
        seen = rng.random(len(own)) < self._chances(cell, len(own)) if there else np.zeros(0, bool)
        found = bool(seen.any())
        time = float(self.times[own[np.argmax(seen)]]) if found else nan
        value = float(found)
        if self.sight.objective.kind == "information":
            hits = np.zeros(self.counts.size, np.int64)
            if there:
                hits[cell] = seen.sum()
            value = self._learnt(np.minimum(belief.poc.ravel(), 1.0), hits)
        return PlanTrial(seed, value, int(found), int(there), time, time)

    def _chances(self, cell: int, looks: int) -> Floats:
        """(looks,) float: P(a look detects who is in the cell | all before have missed)."""
        misses = miss_after_looks(np.array([self._detect[cell]]), looks, self.sight.correlation)[0]
        return np.asarray(1.0 - np.divide(misses[1:], misses[:-1], out=np.ones(looks), where=misses[:-1] > 0))

    def _targets(self, seed: int) -> PlanTrial:
        """In each cell a target or none."""
        hidden = HiddenTargets(self.sight, seed)
        hidden.look(self.cells, self.times)
        return self.told(seed, hidden)

    def told(self, seed: int, hidden: HiddenTargets) -> PlanTrial:
        """What looks have come to."""
        times = hidden.first[np.isfinite(hidden.first)]
        found = len(times)
        value = float(found)
        if self.sight.objective.kind == "information":
            value = self._learnt(self.sight.theta.ravel(), hidden.hits)
        first, mean = (float(times.min()), float(times.mean())) if found else (nan, nan)
        return PlanTrial(seed, value, found, int(hidden.there.sum()), first, mean, hidden.false_alarms)

    def _rates(self, seed: int, known: BetaGrid, rng: Generator) -> PlanTrial:
        """In each cell targets that come and go, in view at a rate of the cell's own."""
        seen = np.flatnonzero(self.counts)
        alpha, beta, looks = known.alpha.ravel()[seen], known.beta.ravel()[seen], self.counts[seen]
        hits = rng.binomial(looks, rng.beta(alpha, beta))
        learnt = _beta_entropy(alpha, beta) - _beta_entropy(alpha + hits, beta + looks - hits)
        return PlanTrial(seed, float(learnt.sum()), int(hits.sum()), 0, nan, nan)

    def _learnt(self, theta: Floats, hits: Ints) -> float:
        """Bits by which cells are less uncertain after so many looks that said yes; it may be less than nothing."""
        seen = np.flatnonzero(self.counts)
        prior, looks = theta[seen], self.counts[seen]
        posterior = theta_after(prior, self._detect[seen], self.sight.false_alarm, looks, hits[seen])
        return float((binary_entropy(prior) - binary_entropy(posterior)).sum())

    @cached_property
    def _detect(self) -> Floats:
        return self.sight.glimpse.ravel()


@dataclass(frozen=True)
class PlanTrial:
    """What one flight came to.

    Parameters
    ----------
    seed : int
    value : float          1 if the person was found, else 0; or targets found, or bits learnt
    found : int            people or targets seen; of rates that are learnt, looks that said yes
    there : int            how many there were
    first, mean : float    when the first was found, and all of them on average; not a number where none was
    false_alarms : int     looks that said yes where nobody was
    """

    seed: int
    value: float
    found: int
    there: int
    first: float
    mean: float
    false_alarms: int = 0

    def row(self, unit_s: float | None) -> list[str]:
        """A line of `trials.csv`; times in seconds, empty where there is none or nobody knows how long a step takes."""
        times = ["" if unit_s is None or np.isnan(each) else f"{each * unit_s:.3f}" for each in (self.first, self.mean)]
        return [str(self.seed), f"{self.value:.6f}", str(self.found), str(self.there), *times, str(self.false_alarms)]


@dataclass(frozen=True, eq=False)
class PlanTrials:
    """What trials of a plan say, beside what the judge promised.

    Parameters
    ----------
    score : Score
    trials : tuple of PlanTrial
    """

    score: Score
    trials: tuple[PlanTrial, ...] = field(repr=False)

    @property
    def value(self) -> Mean:
        """What was collected; the judge promises `score.evaluation.total` of it."""
        return Mean.of([trial.value for trial in self.trials])

    @property
    def time_if_found(self) -> Mean:
        """When those who were found were found, on average over a flight; of flights that found somebody."""
        return Mean.of([trial.mean for trial in self.trials if trial.found and not np.isnan(trial.mean)])

    @property
    def false_alarms(self) -> Mean:
        """Looks that said yes where nobody was."""
        return Mean.of([trial.false_alarms for trial in self.trials])

    @property
    def off(self) -> float | None:
        """How many standard errors what was collected lies from what was promised; None where there is no error."""
        mean, promised = self.value, self.score.evaluation.total
        return None if not mean.error or mean.value is None else (mean.value - promised) / mean.error

    def result(self) -> dict[str, Any]:
        """What goes into the object that `sooner simulate --json` prints."""
        mission, evaluation = self.score.mission, self.score.evaluation
        promised = evaluation.mean_time_if_found
        timed = mission.sight.unit != "bits" and not np.isnan(promised)
        return {
            "mission": mission.name,
            "moves": "regions" if mission.over_regions else "cells",
            "trials": len(self.trials),
            "seed": self.trials[0].seed,
            "unit": mission.sight.unit,
            "value": self.value.result() | {"promised": evaluation.total, "off_by_errors": self.off},
            "time_unit": "seconds" if mission.over_regions else "steps",
            "step_s": mission.step_s,
            "found_after": self.time_if_found.result() | {"promised": promised if timed else None},
            "false_alarms": self.false_alarms.result(),
        }


def fly_plan(score: Score, seeds: range, workers: int = 1) -> Iterator[PlanTrial]:
    """Fly a plan once for each seed, to its end, whatever is seen; what comes does not depend on the workers.

    Looks at who is found already are not needed, but cost nothing: where they teach something they are counted.

    Raises
    ------
    UnsupportedProblemError    where the person moves
    """
    if score.mission.problem.drift is not None:
        raise UnsupportedProblemError("a person who moves came; plans are flown against those who stay")
    yield from for_each_seed(partial(_fly, Flyover.of(score)), seeds, workers)


def _fly(flyover: Flyover, seed: int) -> PlanTrial:
    return flyover.flown(seed)


def looks_of(problem: SearchProblem, plan: Plan) -> tuple[Ints, Floats]:
    """Cells that a plan looks at, in order of time, and when: without atoms, as a camera would see them."""
    parts = []
    for searcher, actions in zip(problem.searchers, plan.actions, strict=True):
        if isinstance(searcher.moves, RegionMoves):
            parts.append(_over_regions(searcher.moves, actions))
        else:
            looks = searcher.moves.looks(problem.grid, searcher, actions)
            parts.append((looks.items, looks.times))
    cells, times = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(times, kind="stable")
    return cells[order].astype(np.int64), times[order]


def _over_regions(moves: RegionMoves, actions: Ints) -> tuple[Ints, Floats]:
    """Cells as they come into view, and when."""
    footprints = moves.graph.footprints
    cells, times = [np.zeros(0, np.int64)], [np.zeros(0)]
    for action, begun, turned in moves.flown(actions):
        entries = slice(footprints.starts[action], footprints.starts[action + 1])
        cells.append(footprints.cells[entries].astype(np.int64))
        times.append(begun + (footprints.back_s if turned else footprints.seconds)[entries].astype(float))
    return np.concatenate(cells), np.concatenate(times)


def _beta_entropy(alpha: Floats, beta: Floats) -> Floats:
    """Differential entropy of Beta laws, bits."""
    from scipy.special import betaln, psi

    nats = (
        betaln(alpha, beta) - (alpha - 1.0) * psi(alpha) - (beta - 1.0) * psi(beta)
        + (alpha + beta - 2.0) * psi(alpha + beta)
    )  # fmt: skip
    return np.asarray(nats / np.log(2.0))
