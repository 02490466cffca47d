"""Trials of a plan: what is hidden is drawn, the plan is flown, and looks may err."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief, BetaGrid
from sooner.belief.evidence import binary_entropy, theta_from_counts
from sooner.errors import UnsupportedProblemError
from sooner.missions.estimates import Mean
from sooner.missions.processes import for_each_seed
from sooner.missions.score import Score
from sooner.missions.sight import Sight
from sooner.problem import Plan, SearchProblem
from sooner.problem.regions import RegionMoves
from sooner.simulation.answers import AnswerModel, rate_entropy
from sooner.simulation.hidden import Hidden, Noise

if TYPE_CHECKING:
    from sooner.missions.leg_trials import LegFlyover

__all__ = ["COLUMNS", "Flyover", "PlanLooks", "PlanTrial", "PlanTrials", "fly_plan"]

COLUMNS = ("seed", "value", "found", "there", "first_s", "mean_s", "false_alarms")
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PlanLooks:
    """Looks in order of time.

    Parameters
    ----------
    cells : (n,) int64         that are looked at
    times : (n,) float         when, in the unit of the judge: steps over cells, seconds over regions
    searchers : (n,) int64     by whom
    """

    cells: Ints
    times: Floats
    searchers: Ints

    @classmethod
    def of(cls, problem: SearchProblem, plan: Plan) -> PlanLooks:
        """The looks of a plan, cell by cell, without atoms and gains: as a camera would take them."""
        parts = []
        for number, (searcher, actions) in enumerate(zip(problem.searchers, plan.actions, strict=True)):
            if isinstance(searcher.moves, RegionMoves):
                cells, times = _over_regions(searcher.moves, actions)
            else:
                looks = searcher.moves.looks(problem.grid, searcher, actions)
                cells, times = looks.items.astype(np.int64), looks.times
            parts.append(cls(cells, times, np.full(len(cells), number)))
        return cls.joined(parts)

    @classmethod
    def joined(cls, parts: Sequence[PlanLooks]) -> PlanLooks:
        """All of them, in order of time."""
        cells, times, searchers = (
            np.concatenate([getattr(part, name) for part in parts]) for name in ("cells", "times", "searchers")
        )
        order = np.argsort(times, kind="stable")
        return cls(cells[order], times[order], searchers[order])

    def where(self, chosen: NDArray[np.bool_]) -> PlanLooks:
        """Some of them, (n,) bool."""
        return PlanLooks(self.cells[chosen], self.times[chosen], self.searchers[chosen])


@dataclass(frozen=True, eq=False)
class Flyover:
    """A plan as those who are hidden meet it: its looks, in order of time, whatever they answer.

    Parameters
    ----------
    sight : Sight            what may be hidden where, and what a look sees of it
    looks : PlanLooks
    """

    sight: Sight
    looks: PlanLooks

    @classmethod
    def of(cls, score: Score) -> Flyover:
        """The looks of a plan that has been scored."""
        return cls(score.mission.sight, PlanLooks.of(score.mission.problem, score.plan))

    @cached_property
    def counts(self) -> Ints:
        """(N,) int64: looks at each cell."""
        return np.bincount(self.looks.cells, minlength=self._model.n_cells)

    def flown(self, seed: int) -> PlanTrial:
        """One flight against what this seed hides."""
        if isinstance(self.sight.known, Belief) and not self.sight.false_alarm:
            return self._without_alarms(seed)
        hidden = Hidden(self._model, seed)
        hidden.look(self.looks.cells, self.looks.times)
        return PlanTrial.told(seed, self.sight, hidden)

    def _without_alarms(self, seed: int) -> PlanTrial:
        """As `flown`, where one person is sought without false alarms: what looks elsewhere answer is known."""
        noise = Noise(seed)
        cell = self._model.person(noise.stream())
        there = cell < self._model.n_cells
        order, starts = self._by_cell
        own = order[starts[cell] : starts[cell + 1]] if there else order[:0]
        numbers = np.arange(len(own))
        seen = noise.of_looks(np.full(len(own), cell), numbers) < (
            self._model.first_chance(cell, len(own)) if there else 0.0
        )
        found = bool(seen.any())
        time = float(self.looks.times[own[np.argmax(seen)]]) if found else nan
        value = float(found)
        if self.sight.objective.kind == "information":
            hits = np.zeros(self.counts.size, np.int64)
            hits[cell : cell + 1] = seen.sum()
            value = learnt(self.sight, self.counts, hits)
        return PlanTrial(seed, value, int(found), int(there), time, time)

    @cached_property
    def _by_cell(self) -> tuple[Ints, Ints]:
        """Looks cell by cell, in order of time, and where those of each cell begin, (N + 1,)."""
        return np.argsort(self.looks.cells, kind="stable"), np.append(0, np.cumsum(self.counts))

    @cached_property
    def _model(self) -> AnswerModel:
        return self.sight.answers


def learnt(sight: Sight, looks: Ints, hits: Ints) -> float:
    """Bits by which cells, each by itself, are less uncertain after so many looks; it may be less than nothing."""
    seen = np.flatnonzero(looks)
    if isinstance(sight.known, BetaGrid):
        alpha, beta = sight.known.alpha.ravel()[seen], sight.known.beta.ravel()[seen]
        later = rate_entropy(alpha + hits[seen], beta + (looks - hits)[seen])
        return float((rate_entropy(alpha, beta) - later).sum())
    prior = sight.theta.ravel()[seen]
    posterior = theta_from_counts(
        prior, (looks - hits)[seen], hits[seen], sight.glimpse.ravel()[seen], sight.false_alarm
    )
    return float((binary_entropy(prior) - binary_entropy(posterior)).sum())


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

    @classmethod
    def told(cls, seed: int, sight: Sight, hidden: Hidden) -> PlanTrial:
        """What looks have come to."""
        there = hidden.there
        times = hidden.first[there][np.isfinite(hidden.first[there])]
        found = int(hidden.hits.sum()) if isinstance(sight.known, BetaGrid) else len(times)
        value = learnt(sight, hidden.looks, hidden.hits) if sight.objective.kind == "information" else float(found)
        first, mean = (float(times.min()), float(times.mean())) if len(times) else (nan, nan)
        return cls(seed, value, found, len(there), first, mean, hidden.false_alarms)

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
            "moves": mission.moves,
            "trials": len(self.trials),
            "seed": self.trials[0].seed,
            "unit": mission.sight.unit,
            "value": self.value.result() | {"promised": evaluation.total, "off_by_errors": self.off},
            "time_unit": "seconds" if mission.timed else "steps",
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
    from sooner.missions.leg_trials import LegFlyover

    flyover = LegFlyover.of(score) if score.mission.over_legs else Flyover.of(score)
    yield from for_each_seed(partial(_fly, flyover), seeds, workers)


def _fly(flyover: Flyover | LegFlyover, seed: int) -> PlanTrial:
    return flyover.flown(seed)


def _over_regions(moves: RegionMoves, actions: Ints) -> tuple[Ints, Floats]:
    """Cells as they come into view, and when."""
    footprints = moves.graph.footprints
    cells, times = [np.zeros(0, np.int64)], [np.zeros(0)]
    for action, begun, turned in moves.flown(actions):
        entries = slice(footprints.starts[action], footprints.starts[action + 1])
        cells.append(footprints.cells[entries].astype(np.int64))
        times.append(begun + (footprints.back_s if turned else footprints.seconds)[entries].astype(float))
    return np.concatenate(cells), np.concatenate(times)
