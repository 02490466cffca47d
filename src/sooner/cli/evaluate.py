"""`sooner evaluate`."""

from __future__ import annotations

import json
from pathlib import Path

from sooner.cli.exits import DONE
from sooner.cli.words import amount, flight, percent, times
from sooner.errors import DataFormatError, Fault, IllegalPlanError
from sooner.missions import Mission, Score, read_mission, read_plan_file, score_plan

__all__ = ["evaluate", "judged", "tell_collected", "tell_early", "tell_left", "tell_reference"]


def evaluate(mission_file: Path, plan_file: Path, as_json: bool) -> int:
    """Read, judge, tell."""
    score = judged(read_mission(mission_file), plan_file)
    if as_json:
        print(json.dumps(score.result() | {"plan_file": str(plan_file)}, allow_nan=False))
    else:
        _tell(score)
    return DONE


def judged(mission: Mission, plan_file: Path) -> Score:
    """What a plan file is worth; DataFormatError, with the reason, where the mission does not allow its flight."""
    plan = read_plan_file(mission, plan_file)
    try:
        return score_plan(mission, plan)
    except IllegalPlanError as error:
        raise DataFormatError(
            Fault(str(plan_file), "", str(error), f"expected a flight that {mission.path} allows")
        ) from None


def _tell(score: Score) -> None:
    mission, evaluation, result = score.mission, score.evaluation, score.result()
    exact = f"   ({evaluation.total:.6f})"
    print(f"{mission.name}: a flight of {flight(mission, result)}")
    tell_collected(score, exact)
    tell_reference(score)
    tell_left(score)
    tell_early(score)
    if mission.sight.unit == "probability":
        for target, time in result["time_to"].items():
            if time is not None:
                print(f"  {float(target):4.0%} found after                    {times(mission, time)}")
    else:
        for share, time in result["time_to_share"].items():
            if time is not None:
                print(f"  {float(share):4.0%} of that after                  {times(mission, time)}")
    if mission.problem.objective.target is not None:
        target, time = mission.problem.objective.target, -evaluation.value
        print(f"  the target of {target:.0%} is reached after {times(mission, time)}")


def tell_collected(score: Score, more: str = "") -> None:
    """What the plan is worth, in the words of its objective."""
    unit, total = score.mission.sight.unit, score.evaluation.total
    words = {"probability": "finds the person with probability", "bits": "learns", "targets": "finds, as expected"}
    print(f"  {words[unit]:35} {amount(score.mission, total)}{more if unit == 'probability' else ''}")


def tell_reference(score: Score) -> None:
    """How that compares with the yardstick of the papers."""
    if score.efficiency is not None:
        told = "efficiency against teleporting" if not score.mission.over_regions else "of iterative greedy, no bound"
        print(f"  {told:35} {percent(score.efficiency)}")


def tell_left(score: Score) -> None:
    """What is left to find or to learn, and where."""
    mission = score.mission
    if mission.sight.unit == "bits" and score.found is not None:
        print(f"  finds the person with probability   {percent(score.found)}")
    if mission.belief is None:
        free = mission.problem.grid.passable
        seen, left = float((score.looks[free] > 0).mean()), float(score.left[free].sum())
        print(f"  looked at                           {percent(seen)}   of the free ground")
        still = "still not known" if mission.sight.unit == "bits" else "still unseen, as expected"
        print(f"  {still:35} {amount(mission, left)}   of {amount(mission, left + score.evaluation.total)}")
        _tell_ground(score)
        return
    print(f"  never looked at                     {percent(score.never_looked)}   of the probability")
    print(f"  looked at, and missed               {percent(score.missed)}")
    if mission.belief.outside:
        print(f"  outside this map                    {percent(mission.belief.outside)}")


def tell_early(score: Score) -> None:
    """When it comes in."""
    mission, evaluation = score.mission, score.evaluation
    if not evaluation.total > 0:
        return
    if mission.sight.unit != "bits":
        print(f"  expected time, if it finds          {times(mission, evaluation.mean_time_if_found)}")
    if mission.sight.unit == "probability":
        print(f"  expected time, found or flown out   {times(mission, evaluation.expected_time)}")
    if mission.timed:
        print(f"  how early                           {percent(score.early_share)}   (100 %: all of it at once)")


def _tell_ground(score: Score) -> None:
    """What the flight spares people on the ground."""
    effort = score.effort()
    if effort is not None and effort.before > 0:
        print(f"  ground teams then search            {percent(effort.after / effort.before)}   of the time without it")
