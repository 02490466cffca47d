"""`sooner evaluate`."""

from __future__ import annotations

import json
from pathlib import Path

from sooner.cli.exits import DONE
from sooner.cli.words import percent, steps
from sooner.errors import DataFormatError, Fault, IllegalPlanError
from sooner.io import read_plan
from sooner.missions import Score, read_mission, score_plan

__all__ = ["evaluate"]


def evaluate(mission_file: Path, plan_file: Path, as_json: bool) -> int:
    """Read, judge, tell."""
    mission = read_mission(mission_file)
    plan = read_plan(plan_file, mission.problem.grid)
    try:
        score = score_plan(mission, plan)
    except IllegalPlanError as error:
        raise DataFormatError(
            Fault(str(plan_file), "", str(error), f"expected a flight that {mission_file} allows")
        ) from None
    if as_json:
        print(json.dumps(score.result() | {"plan_file": str(plan_file)}, allow_nan=False))
    else:
        _tell(score)
    return DONE


def _tell(score: Score) -> None:
    mission, evaluation, result = score.mission, score.evaluation, score.result()
    print(f"{mission.name}: a flight of {steps(mission, max(result['steps']))}")
    print(f"  finds the person with probability   {percent(evaluation.total)}   ({evaluation.total:.6f})")
    if evaluation.efficiency is not None:
        print(f"  efficiency against teleporting      {percent(evaluation.efficiency)}")
    print(f"  never looked at                     {percent(score.never_looked)}   of the probability")
    print(f"  looked at, and missed               {percent(score.missed)}")
    if mission.belief.outside:
        print(f"  outside this map                    {percent(mission.belief.outside)}")
    print(f"  expected time, if it finds          {steps(mission, evaluation.mean_time_if_found)}")
    print(f"  expected time, found or flown out   {steps(mission, evaluation.expected_time)}")
    for target, time in result["time_to"].items():
        if time is not None:
            print(f"  {float(target):4.0%} found after                    {steps(mission, time)}")
    if mission.problem.objective.target is not None:
        target, time = mission.problem.objective.target, -evaluation.value
        print(f"  the target of {target:.0%} is reached after {steps(mission, time)}")
