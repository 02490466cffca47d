"""What a plan is worth on a mission, in the words of the outside face."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sooner.missions.mission_file import Mission
from sooner.problem import CellMoves, Evaluation, Plan, Searcher, evaluate

__all__ = ["Score", "score_plan"]

TARGETS = (0.1, 0.25, 0.5, 0.75, 0.9, 0.95)


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

    @property
    def never_looked(self) -> float:
        """Probability that the person is on the map where this plan never looks."""
        return float(self.mission.belief.poc.ravel()[self.evaluation.looks == 0].sum())

    @property
    def missed(self) -> float:
        """Probability that the person is where this plan looks, and is missed."""
        return max(0.0, 1.0 - self.mission.belief.outside - self.never_looked - self.evaluation.total)

    @property
    def seconds(self) -> float | None:
        """How long the longest flight takes; None where the mission says nothing about speed."""
        if self.mission.step_s is None:
            return None
        return max(
            (len(actions) - 1) * step_of(searcher)
            for searcher, actions in zip(self.mission.problem.searchers, self.plan.actions, strict=True)
        )

    def result(self) -> dict[str, Any]:
        """One JSON object; numbers that do not exist are null."""
        evaluation, step_s = self.evaluation, self.mission.step_s
        in_time = {f"{target:g}": finite(evaluation.time_to(target)) for target in TARGETS}
        return {
            "mission": self.mission.name,
            "objective": objective_name(self.mission),
            "value": finite(evaluation.value),
            "cdp": finite(evaluation.total),
            "efficiency": finite(evaluation.efficiency),
            "reference": finite(evaluation.reference),
            "reference_name": "teleport" if evaluation.reference is not None else None,
            "time_unit": "steps",
            "step_s": step_s,
            "steps": [len(actions) - 1 for actions in self.plan.actions],
            "duration_s": finite(self.seconds),
            "expected_time": finite(evaluation.expected_time),
            "mean_time_if_found": finite(evaluation.mean_time_if_found),
            "time_to": in_time,
            "remaining": {
                "never_looked": self.never_looked,
                "looked_but_missed": self.missed,
                "outside": self.mission.belief.outside,
            },
            "cells_looked_at": int((evaluation.looks > 0).sum()),
        }


def score_plan(mission: Mission, plan: Plan) -> Score:
    """Score a plan by the judge.

    Raises
    ------
    IllegalPlanError       naming searcher, step and reason
    """
    return Score(mission, plan, evaluate(mission.problem, plan))


def step_of(searcher: Searcher) -> float:
    """Seconds that one step of this searcher takes."""
    moves = searcher.moves
    return moves.step_s if isinstance(moves, CellMoves) else 1.0


def objective_name(mission: Mission) -> str:
    """`detection`, or the target that is to be reached soonest."""
    objective = mission.problem.objective
    return objective.kind if objective.target is None else f"{objective.kind} {objective.target:g} soonest"


def finite(value: float | np.floating[Any] | None) -> float | None:
    """A number for JSON: null where there is none, for JSON knows neither infinity nor NaN."""
    return float(value) if value is not None and math.isfinite(value) else None
