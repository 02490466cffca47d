"""Plan a mission: the planner, the bound beside it, the judge, and the files that are left."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

import sooner
from sooner.errors import (
    DataFormatError,
    Fault,
    InfeasibleProblemError,
    InvalidProblemError,
    UnsupportedProblemError,
)
from sooner.grid import rows_and_cols
from sooner.io import Folder, plan_csv, read_plan, read_region_plan, region_plan_csv
from sooner.io.leg_plans import leg_plan_csv, read_leg_plan
from sooner.io.region_plans import stages
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score, finite, objective_name, score_plan
from sooner.missions.settings import Hearing
from sooner.planners import Planner, Progress, Solution, Status, max_seconds, solve
from sooner.planners.by_moves import moves_of
from sooner.planners.decentralised import Decentralised, Exchange, Links
from sooner.planners.proved import Proved
from sooner.planners.receding import Receding
from sooner.planners.region_soonest import RegionSoonest
from sooner.planners.registry import DEFAULT, PLANNERS, make_planner
from sooner.planners.soonest import Soonest
from sooner.planners.team import Team
from sooner.problem import Evaluation, Plan, SearchProblem, evaluate
from sooner.problem.leg_moves import places_of

__all__ = ["FILES", "Planned", "plan_file", "plan_mission", "read_plan_file", "wrapped"]

FILES = ("plan.csv", "plan.json", "plan.png")
EARLY = 0.2  # share of the planning time in which a plan is brought forward
LEGS_EARLY = 0.05  # likewise along legs, where only flights as they are change places


@dataclass(frozen=True, eq=False)
class Planned:
    """A planned mission.

    Parameters
    ----------
    score : Score               the plan and what it is worth
    solution : Solution         how the planner came to it, and what is proved
    planner : str               the planner's name
    late : Evaluation or None   of the plan as it was before it was brought forward; None where it was not
    exchange : Exchange or None how drones that plan for themselves came to it
    """

    score: Score
    solution: Solution
    planner: str
    late: Evaluation | None = None
    exchange: Exchange | None = None

    def result(self, plan_file: str | None) -> dict[str, Any]:
        """The object that `sooner plan --json` prints."""
        mission, best = self.score.mission, self.solution.best
        scored = self.score.result()
        says = best.bound == -inf or self._told_bound(best.bound) is not None
        return {
            "planner": self.planner,
            "objective": objective_name(mission),
            "value": finite(best.value),
            "bound": self._told_bound(best.bound),
            "bound_proof": (best.bound_proof or None) if says else None,
            "bound_assumes": (best.bound_assumes or None) if says else None,
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
            "brought_forward": self._brought_forward(),
            "links": self._links(),
            "trace": [[round(p.seconds, 3), finite(p.value), self._told_bound(p.bound)] for p in self.solution.trace],
            "version": sooner.__version__,
        }

    def _told_bound(self, bound: float) -> float | None:
        """A bound for JSON; null where it says nothing, as that no flight reaches a target before it begins."""
        vacuous = self.score.mission.problem.objective.target is not None and bound >= 0
        return None if vacuous else finite(bound)

    def _brought_forward(self) -> dict[str, Any] | None:
        """What the plan was before, and what share of that it keeps."""
        if self.late is None:
            return None
        before = {"value": finite(self.late.total), "early_share": finite(self.late.early_share)}
        return {"kept": finite(self.score.evaluation.total / self.late.total), "before": before}

    def _links(self) -> dict[str, Any] | None:
        """What was said between drones that plan for themselves, and whose flights each knows at last."""
        if self.exchange is None:
            return None
        messages = [[each.turn, each.sender, each.receiver, each.heard] for each in self.exchange.messages]
        knows = [np.flatnonzero(row).tolist() for row in self.exchange.knows]
        believed = [finite(value) for value in self.exchange.believed]
        counts = {"sent": self.exchange.sent, "lost": self.exchange.lost}
        return {**counts, "knows": knows, "believed": believed, "messages": messages}

    def _searchers(self) -> list[dict[str, Any]]:
        problem, plan = self.score.mission.problem, self.score.plan
        durations: Sequence[float | None] = self.score.durations or [None] * len(plan.actions)
        searchers = []
        for searcher, actions, seconds in zip(problem.searchers, plan.actions, durations, strict=True):
            if self.score.mission.over_legs:
                rows_cols = np.rint(rows_and_cols(problem.grid, places_of(actions))).astype(int)
                cells = np.clip(rows_cols, 0, np.array(problem.grid.shape) - 1).tolist()
            elif self.score.mission.over_regions:
                cells = [list(stage.cell) for stage in stages(problem, searcher, actions)]
            else:
                cells = np.column_stack(np.divmod(actions, problem.grid.shape[1])).tolist()
            searchers.append({"cells": cells, "actions": actions.tolist(), "duration_s": seconds})
        return searchers

    def write(self, folder: Folder) -> dict[str, Any]:
        """Write plan, result and picture into the folder, all or none; returns the result."""
        from sooner.missions.picture import plan_picture

        result = self.result(str(folder.path / "plan.csv"))
        folder.write(
            {
                "plan.csv": plan_file(self.score.mission, self.score.plan),
                "plan.json": (json.dumps(result, allow_nan=False) + "\n").encode(),
                "plan.png": plan_picture(self),
            }
        )
        return result


def plan_file(mission: Mission, plan: Plan) -> bytes:
    """The plan as CSV, in the columns of its moves."""
    if mission.over_regions:
        return region_plan_csv(plan, mission.problem)
    if mission.over_legs:
        return leg_plan_csv(plan, mission.problem, mission.ground)
    return plan_csv(plan, mission.problem.grid)


def read_plan_file(mission: Mission, path: Path) -> Plan:
    """Read what `plan_file` wrote, or anybody else's plan for this mission.

    Raises
    ------
    DataFormatError       with every fault of the file that does not hide others
    """
    if mission.over_regions:
        return read_region_plan(path, mission.problem)
    if mission.over_legs:
        return read_leg_plan(path, mission.problem)
    return read_plan(path, mission.problem.grid)


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
    told: list[Exchange] = []
    chosen = _choose(mission.problem, name, mission.settings.links, told.append)
    wants_early = mission.settings.wants_early
    share = LEGS_EARLY if mission.over_legs else EARLY
    stop = max_seconds(seconds * (1.0 - share) if wants_early else seconds)
    try:
        solution = solve(mission.problem, chosen, stop=stop, seed=seed, on_tick=on_tick)
    except InfeasibleProblemError as error:
        raise DataFormatError(
            Fault(str(mission.path), "searcher", str(error), "expected a flight that can be flown")
        ) from None
    late = None
    if wants_early and not told and solution.status is not Status.INTERRUPTED:
        # patterns are flown as they are drawn, and who asks for no gap gives nothing up
        solution, late = _brought_forward(mission.problem, solution, seconds * share, may_give_up=name == DEFAULT)
    exchange = told[0] if told else None
    return Planned(score_plan(mission, solution.best.plan), solution, name, late, exchange)


def _brought_forward(
    problem: SearchProblem, solution: Solution, seconds: float, may_give_up: bool
) -> tuple[Solution, Evaluation | None]:
    """The solution with its plan brought forward, and what the plan was before; None where nothing was gained."""
    from sooner.planners.leg_early import earlier_within
    from sooner.planners.leg_tidy import tidied
    from sooner.planners.region_early import brought_forward_within

    plan = solution.best.plan
    if moves_of(problem) == "legs":
        early = earlier_within(problem, tidied(problem, plan) if may_give_up else plan, seconds)
    else:
        early = brought_forward_within(problem, plan, seconds)
    if early == plan:
        return solution, None
    best = replace(solution.best, plan=early, value=evaluate(problem, early).value)
    return replace(solution, best=best), evaluate(problem, plan)


def _choose(problem: SearchProblem, name: str, links: Hearing | None, tell: Callable[[Exchange], None]) -> Planner:
    """The planner of that name, wrapped for what the problem asks, with the proof beside it."""
    planner = make_planner(name)
    if links is not None:
        range_m = inf if links.range_m is None else links.range_m
        planner = Decentralised(planner, Links(range_m, links.loss, links.relays), tell=tell)
    else:
        planner = wrapped(problem, planner)
    why = planner.handles(problem)
    if why is not None:
        kind = moves_of(problem)
        names = ", ".join(other for other, entry in PLANNERS.items() if kind in entry.moves)
        raise UnsupportedProblemError(f"{name} cannot plan this: {why}; for moves over {kind} there are: {names}")
    return Proved(planner)


def wrapped(problem: SearchProblem, planner: Planner) -> Planner:
    """A planner for one drone, a person who stays and the most by the end, for what the problem asks.

    Planners of legs plan all sorties together as they are.
    """
    if moves_of(problem) == "legs":
        return planner
    if len(problem.searchers) > 1:
        planner = Team(planner)
    elif problem.drift is not None:
        planner = Receding(planner)
    if problem.objective.target is not None:
        planner = RegionSoonest(planner) if moves_of(problem) == "regions" else Soonest(planner)
    return planner
