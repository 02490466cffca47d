"""What a plan is worth on a mission, in the words of the outside face."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.belief import EvidenceGrid
from sooner.belief.effort import Variant, expected_effort
from sooner.missions.mission_file import Mission
from sooner.missions.reference_plan import iterative_greedy
from sooner.problem import CellMoves, Evaluation, Plan, Searcher, detection_gains, evaluate
from sooner.problem.leg_moves import LegMoves, places_of
from sooner.problem.regions import RegionMoves

__all__ = ["GIVE_UP", "Effort", "Score", "score_plan"]

TARGETS = (0.1, 0.25, 0.5, 0.75, 0.9, 0.95)
GIVE_UP = 0.01  # probability below which people on the ground give a cell up [Kuhlman2017, sec. 7]


@dataclass(frozen=True)
class Effort:
    """How long people on the ground search a free cell on average, in time constants of detection.

    Parameters
    ----------
    before, after : float      the flight
    """

    before: float
    after: float


@dataclass(frozen=True, eq=False)
class Score:
    """A legal plan, and everything that can be said of it.

    Parameters
    ----------
    mission : Mission
    plan : Plan
    evaluation : Evaluation
    """

    mission: Mission
    plan: Plan
    evaluation: Evaluation

    @cached_property
    def looks(self) -> NDArray[Any]:
        """(N,): how often each cell is looked at; along legs the effort on it."""
        problem = self.mission.problem
        if not self.mission.over_regions:
            return self.evaluation.looks
        found = np.zeros(problem.grid.n_cells, np.int64)
        for searcher, actions in zip(problem.searchers, self.plan.actions, strict=True):
            found += _region_moves(searcher).cell_looks(problem.grid, actions)
        return found

    @cached_property
    def left(self) -> NDArray[np.float64]:
        """(N,) float: what is still to be found or learnt in each cell, as expected."""
        return np.maximum(np.ravel(self.mission.sight.there) - self.mission.sight.worth(self.looks), 0.0)

    @cached_property
    def found(self) -> float | None:
        """Probability that this plan finds the person; None over evidence, which does not total one."""
        belief, sight = self.mission.belief, self.mission.sight
        if belief is None:
            return None
        if sight.objective.kind == "detection":
            return self.evaluation.total
        gains, cells = detection_gains(belief, sight.detect), np.flatnonzero(self.looks)
        missed = gains.ratio[cells] ** self.looks[cells]
        return float((belief.poc.ravel()[cells] * (1.0 - missed)).sum())

    @property
    def never_looked(self) -> float:
        """Probability that the person is on the map where this plan never looks."""
        belief = self.mission.belief
        return 0.0 if belief is None else float(belief.poc.ravel()[self.looks == 0].sum())

    @property
    def missed(self) -> float:
        """Probability that the person is where this plan looks, and is missed."""
        belief = self.mission.belief
        outside = 0.0 if belief is None else belief.outside
        return max(0.0, 1.0 - outside - self.never_looked - (self.found or 0.0))

    @property
    def durations(self) -> list[float] | None:
        """Seconds that each flight takes; None where the mission says nothing about speed."""
        if self.mission.unit_s is None:
            return None
        flights = zip(self.mission.problem.searchers, self.plan.actions, strict=True)
        return [duration_s(searcher, actions) for searcher, actions in flights]

    @property
    def seconds(self) -> float | None:
        """How long the longest flight takes; None where the mission says nothing about speed."""
        return None if self.durations is None else max(self.durations)

    @cached_property
    def reference(self) -> tuple[float, str] | None:
        """What to compare with, and its name; None where there is nothing. No proof: plans may pass it over regions."""
        if self.mission.over_regions:
            return iterative_greedy(self.mission.problem), "iterative greedy"
        teleport = self.evaluation.reference
        return None if teleport is None else (teleport, "teleport")

    @property
    def efficiency(self) -> float | None:
        """What the plan collects as a share of the reference."""
        return self.evaluation.total / self.reference[0] if self.reference and self.reference[0] > 0 else None

    @property
    def early_share(self) -> float:
        """Area under the curve of gains, as a share of all of it being collected at once."""
        return self.evaluation.early_share

    def effort(self, variant: Variant = "corrected") -> Effort | None:
        """What the flight spares people on the ground; None but over evidence of whether a target is there.

        Over `poc` cells are not each by themselves: all of them together hold one person.

        Parameters
        ----------
        variant : str         "corrected", or "printed": eq. (11) as it stands in [Kuhlman2017]
        """
        sight, free = self.mission.sight, self.mission.problem.grid.passable
        if not isinstance(sight.known, EvidenceGrid):
            return None
        theta, detect, looks = np.ravel(sight.theta)[free], np.ravel(sight.glimpse)[free], self.looks[free]
        effort = np.zeros((2, theta.size))
        for glimpse in np.unique(detect):  # a level of difficulty each, or one for all
            here = detect == glimpse
            for row, seen in zip(effort, (np.zeros_like(looks), looks), strict=True):
                row[here] = expected_effort(
                    theta[here], seen[here], float(glimpse), sight.false_alarm, threshold=GIVE_UP, variant=variant
                )
        mean = [float(row.mean()) for row in effort]
        return Effort(*mean)

    def result(self) -> dict[str, Any]:
        """One JSON object; numbers that do not exist are null."""
        evaluation, mission = self.evaluation, self.mission
        probability = mission.sight.unit == "probability"
        reference = self.reference or (None, None)
        free = mission.problem.grid.passable
        return {
            "mission": mission.name,
            "objective": objective_name(mission),
            "value": finite(evaluation.value),
            "unit": mission.sight.unit,
            "cdp": finite(self.found),
            "efficiency": finite(self.efficiency),
            "reference": finite(reference[0]),
            "reference_name": reference[1],
            "time_unit": "seconds" if mission.timed else "steps",
            "step_s": mission.step_s,
            "steps": None if mission.timed else [len(actions) - 1 for actions in self.plan.actions],
            "duration_s": finite(self.seconds),
            "expected_time": finite(evaluation.expected_time) if probability else None,
            "mean_time_if_found": finite(evaluation.mean_time_if_found) if mission.sight.unit != "bits" else None,
            "time_to": {f"{t:g}": finite(evaluation.time_to(t)) if probability else None for t in TARGETS},
            "time_to_share": {f"{t:g}": finite(evaluation.time_to(t * evaluation.total)) for t in TARGETS},
            "early_share": finite(self.early_share),
            "remaining": self._remaining(),
            "to_find": {
                "before": float(np.ravel(mission.sight.there)[free].sum()),
                "after": float(self.left[free].sum()),
            },
            "ground_effort": self._ground_effort(),
            "cells_looked_at": int((self.looks > 0).sum()),
        }

    def _remaining(self) -> dict[str, float] | None:
        belief = self.mission.belief
        if belief is None:
            return None
        return {"never_looked": self.never_looked, "looked_but_missed": self.missed, "outside": belief.outside}

    def _ground_effort(self) -> dict[str, Any] | None:
        corrected, printed = self.effort(), self.effort("printed")
        if corrected is None or printed is None:
            return None
        told = {"before": corrected.before, "after": corrected.after}
        return {
            "unit": "time constants of detection, mean of a free cell",
            "give_up": GIVE_UP,
            **told,
            "as_printed": {"before": printed.before, "after": printed.after},
        }


def score_plan(mission: Mission, plan: Plan) -> Score:
    """Score a plan by the judge.

    Raises
    ------
    IllegalPlanError       naming searcher, step and reason
    """
    return Score(mission, plan, evaluate(mission.problem, plan))


def duration_s(searcher: Searcher, actions: NDArray[np.int64]) -> float:
    """Seconds that a plan of this searcher takes."""
    moves = searcher.moves
    if isinstance(moves, RegionMoves):
        return moves.seconds(actions)
    if isinstance(moves, LegMoves):
        return moves.seconds(places_of(actions))
    return (len(actions) - 1) * (moves.step_s if isinstance(moves, CellMoves) else 1.0)


def _region_moves(searcher: Searcher) -> RegionMoves:
    assert isinstance(searcher.moves, RegionMoves)
    return searcher.moves


def objective_name(mission: Mission) -> str:
    """`detection` or `information`, or the target that is to be reached soonest."""
    objective = mission.problem.objective
    return objective.kind if objective.target is None else f"{objective.kind} {objective.target:g} soonest"


def finite(value: float | np.floating[Any] | None) -> float | None:
    """A number for JSON: null where there is none, for JSON knows neither infinity nor NaN."""
    return float(value) if value is not None and math.isfinite(value) else None
