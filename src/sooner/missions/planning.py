"""Plan a mission: the planner, the bound beside it, the judge, and the files that are left."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import sooner
from sooner.errors import DataFormatError, Fault, InfeasibleProblemError, InvalidProblemError
from sooner.io import Folder, plan_csv
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score, finite, objective_name, score_plan, step_of
from sooner.planners import Planner, Progress, Solution, max_seconds, solve
from sooner.planners.proved import Proved
from sooner.planners.receding import Receding
from sooner.planners.registry import DEFAULT, make_planner
from sooner.planners.soonest import Soonest
from sooner.planners.team import Team
from sooner.problem import SearchProblem

__all__ = ["FILES", "Planned", "plan_mission", "wrapped"]

FILES = ("plan.csv", "plan.json", "plan.png")


@dataclass(frozen=True, eq=False)
class Planned:
    """A planned mission.

    Parameters
    ----------
    score : Score               the plan and what it is worth
    solution : Solution         how the planner came to it, and what is proved
    planner : str               the planner's name
    """

    score: Score
    solution: Solution
    planner: str

    def result(self, plan_file: str | None) -> dict[str, Any]:
        """The object that `sooner plan --json` prints."""
        mission, best = self.score.mission, self.solution.best
        scored = self.score.result()
        return {
            "planner": self.planner,
            "objective": objective_name(mission),
            "value": finite(best.value),
            "bound": finite(best.bound),
            "bound_proof": best.bound_proof or None,
            "bound_assumes": best.bound_assumes or None,
            "gap": finite(best.gap),
            "reference": scored["reference"],
            "reference_name": scored["reference_name"],
            "efficiency": scored["efficiency"],
            "status": self.solution.status.value,
            "seconds": round(self.solution.seconds, 3),
            "seed": self.solution.seed,
            "plan_file": plan_file,
            "searchers": self._searchers(),
            **{key: value for key, value in scored.items() if key not in ("objective", "value", "efficiency")},
            "trace": [[round(p.seconds, 3), finite(p.value), finite(p.bound)] for p in self.solution.trace],
            "version": sooner.__version__,
        }

    def _searchers(self) -> list[dict[str, Any]]:
        grid = self.score.mission.problem.grid
        searchers = []
        for searcher, actions in zip(self.score.mission.problem.searchers, self.score.plan.actions, strict=True):
            rows, cols = np.divmod(actions, grid.shape[1])
            step_s = None if self.score.mission.step_s is None else step_of(searcher)
            searchers.append(
                {
                    "cells": np.column_stack([rows, cols]).tolist(),
                    "actions": actions.tolist(),
                    "duration_s": None if step_s is None else (len(actions) - 1) * step_s,
                }
            )
        return searchers

    def write(self, folder: Folder) -> dict[str, Any]:
        """Write plan, result and picture into the folder, all or none; returns the result."""
        from sooner.missions.picture import plan_picture

        result = self.result(str(folder.path / "plan.csv"))
        grid = self.score.mission.problem.grid
        folder.write(
            {
                "plan.csv": plan_csv(self.score.plan, grid),
                "plan.json": (json.dumps(result, allow_nan=False) + "\n").encode(),
                "plan.png": plan_picture(self),
            }
        )
        return result


def plan_mission(
    mission: Mission,
    planner: str | None = None,
    seconds: float = 10.0,
    seed: int = 0,
    on_tick: Callable[[Progress], None] | None = None,
) -> Planned:
    """Plan a mission with a bound beside it.

    Parameters
    ----------
    planner : str or None      a name of `sooner planners`; None for the default
    seconds : float            planning time
    on_tick : callable         is shown the progress of every tick

    Raises
    ------
    UnsupportedProblemError    where the planner is not made for this mission, or there is no such planner
    """
    if not (np.isfinite(seconds) and seconds > 0):
        raise InvalidProblemError(f"a planning time of {seconds} s came; expected a finite number above 0")
    name = DEFAULT if planner is None else planner
    chosen = _choose(mission.problem, name)
    try:
        solution = solve(mission.problem, chosen, stop=max_seconds(seconds), seed=seed, on_tick=on_tick)
    except InfeasibleProblemError as error:
        raise DataFormatError(
            Fault(str(mission.path), "searcher", str(error), "expected a flight that can be flown")
        ) from None
    return Planned(score_plan(mission, solution.best.plan), solution, name)


def _choose(problem: SearchProblem, name: str) -> Planner:
    """The planner of that name, wrapped for what the problem asks, with the proof beside it."""
    return Proved(wrapped(problem, make_planner(name)))


def wrapped(problem: SearchProblem, planner: Planner) -> Planner:
    """A planner for one drone, a person who stays and the most by the end, for what the problem asks."""
    if len(problem.searchers) > 1:
        planner = Team(planner)
    elif problem.drift is not None:
        planner = Receding(planner)
    if problem.objective.target is not None:
        planner = Soonest(planner)
    return planner
