"""`sooner simulate` of a plan over cells, over regions or along legs: fly it, and compare with what was promised."""

from __future__ import annotations

import json
from dataclasses import replace
from math import isfinite
from pathlib import Path

from sooner.cli.evaluate import judged
from sooner.cli.exits import DONE, say, uninterrupted
from sooner.cli.given import planning_time
from sooner.cli.progress import Watch
from sooner.cli.simulate import Asked, csv_of, episode_files, gathered, tell_end
from sooner.cli.words import amount, clock, flight
from sooner.errors import DataFormatError, Fault
from sooner.io import Folder
from sooner.missions import Mission, plan_mission, read_mission
from sooner.missions.estimates import Mean
from sooner.missions.picture import plan_picture
from sooner.missions.plan_episodes import plan_episode
from sooner.missions.plan_trials import COLUMNS, PlanTrials, fly_plan
from sooner.missions.planning import Planned, plan_file
from sooner.missions.replanned import check_replanning, fly_replanned
from sooner.planners import Solution, Status
from sooner.planners.registry import DEFAULT
from sooner.problem.incumbent import Incumbent
from sooner.simulation.episodes import animation_of, picture_of
from sooner.simulation.plan_episode_file import plan_episode_npz

__all__ = ["simulate_plan"]

SECONDS = 10.0


def simulate_plan(mission_file: Path, asked: Asked, folder: Folder, as_json: bool, quiet: bool) -> int:
    """Plan, fly, write, tell; answers the exit status."""
    mission = read_mission(mission_file)
    if mission.over_legs and asked.animate:
        expected = "expected it left out along legs, of which no episode is kept"
        raise DataFormatError(Fault("--animate", "", 'it came, and moves = "legs"', expected))
    kept = [] if mission.over_legs else episode_files(asked)
    folder.check("trials.csv", "simulation.json", "plan.csv", "plan.png", *kept)
    every = None if asked.replan is None else _every(mission, asked.replan)
    planned = _planned(mission, asked, quiet)
    if not quiet:
        say(f"flying it {asked.trials:,} times")
    flights = (
        fly_plan(planned.score, asked.seeds, asked.workers)
        if every is None
        else fly_replanned(_replanned_by(planned), every, asked.seeds, asked.workers)
    )
    flown, status = gathered(flights, asked.trials, quiet)
    trials = PlanTrials(planned.score, flown)
    result = trials.result() | {
        "planner": planned.planner or None,
        "plan": None if asked.plan is None else str(asked.plan),
        "replan": asked.replan,
        "interrupted": status != DONE,
    }
    result["files"] = str(folder.path)
    with uninterrupted():
        folder.write(
            {
                "trials.csv": csv_of(COLUMNS, (trial.row(mission.unit_s) for trial in flown)),
                "simulation.json": (json.dumps(result, allow_nan=False) + "\n").encode(),
                "plan.csv": plan_file(mission, planned.score.plan),
                "plan.png": plan_picture(planned),
                **({} if mission.over_legs else _episode(planned, every, asked)),
            }
        )
    if as_json:
        print(json.dumps(result, allow_nan=False))
    else:
        _tell(mission, trials, asked, planned.planner, folder)
    tell_end(status, len(flown), asked.trials)
    return status


def _planned(mission: Mission, asked: Asked, quiet: bool) -> Planned:
    """The plan that came, judged, or one that is made now."""
    if asked.plan is not None:
        for option, came in (("--planner", asked.planner), ("--seconds", asked.seconds)):
            if came is not None:
                raise DataFormatError(Fault(option, "", f"{came!r} came beside --plan", "expected one of them"))
        score = judged(mission, asked.plan)
        best = Incumbent(score.plan, score.evaluation.value)
        return Planned(score, Solution(best, Status.FINISHED, asked.seed, 0.0, ()), "")
    seconds = SECONDS if asked.seconds is None else planning_time(asked.seconds)
    with Watch(mission, asked.planner, seconds, quiet) as watch:
        return plan_mission(mission, asked.planner, seconds, asked.seed, on_tick=watch.tick)


def _replanned_by(planned: Planned) -> Planned:
    """With the planner that plans anew on the way: the default one where nobody says who planned."""
    return planned if planned.planner else replace(planned, planner=DEFAULT)


def _episode(planned: Planned, every: float | None, asked: Asked) -> dict[str, bytes]:
    """The first flight, kept whole."""
    episode = plan_episode(planned.score.mission, planned.score.plan, asked.seed, _replanned_by(planned).planner, every)
    files = {"episode.npz": plan_episode_npz(episode), "episode.png": picture_of(episode)}
    return files | {"episode.gif": animation_of(episode)} if asked.animate else files


def _every(mission: Mission, wanted: float) -> float:
    """Time between plans in the judge's unit."""
    check_replanning(mission)
    unit_s = 1.0 if mission.unit_s is None else mission.unit_s
    budget = float(max(searcher.budget for searcher in mission.problem.searchers))
    least = 1e-3 if mission.over_regions else 1.0
    every = wanted / unit_s
    if not mission.over_regions and isfinite(every):
        every = float(int(every + 1e-9))
    if not least <= every < budget:
        unit = " steps" if mission.unit_s is None else " s"
        came = f"{wanted:g} came, and the search lasts {budget * unit_s:g}{unit}"
        step = "" if mission.over_regions else "one step, which takes " if mission.unit_s is not None else "one step: "
        raise DataFormatError(
            Fault("--replan", "", came, f"expected less than that, and at least {step}{least * unit_s:g}{unit}")
        )
    return every


def _tell(mission: Mission, trials: PlanTrials, asked: Asked, planner: str, folder: Folder) -> None:
    evaluation, unit, count = trials.score.evaluation, mission.sight.unit, len(trials.trials)
    long = flight(mission, trials.score.result())
    whose = f"planned by {planner}" if asked.plan is None else f"planned in {asked.plan}"
    print(f"{mission.name}: a flight of {long}, {whose}, flown {count:,} time{'s' if count > 1 else ''}")
    words = {"probability": "finds the person in", "bits": "learns", "targets": "finds"}[unit]
    print(f"  {words:35} {_amount(mission, trials.value)}")
    promised = "the judge promised" if asked.replan is None else "without replans, as promised"
    off = "" if trials.off is None else f"   ({abs(trials.off):.1f} standard errors away)"
    print(f"  {promised:35} {amount(mission, evaluation.total)}{off}")
    if unit != "bits" and trials.time_if_found.value is not None:
        print(f"  if it finds, after                  {_time(mission, trials.time_if_found)}")
        if unit == "probability":
            print(
                f"  the judge promised                  {_time(mission, Mean(evaluation.mean_time_if_found, None, 0))}"
            )
    if mission.sight.false_alarm:
        print(f"  false alarms                        {trials.false_alarms.told(1)} a flight")
    for name in ("trials.csv", "plan.csv", *([] if mission.over_legs else ["episode.npz"])):
        print(f"{name.split('.')[0]:8} {folder.path / name}")
    if mission.over_legs:
        print(f"picture  {folder.path / 'plan.png'}")
    else:
        print(f"pictures {folder.path / 'plan.png'}, episode.png{', episode.gif' if asked.animate else ''}")


def _amount(mission: Mission, mean: Mean) -> str:
    """As the judge's amounts, with the standard error."""
    if mission.sight.unit != "probability":
        return mean.told(3, f" {mission.sight.unit}")
    assert mean.value is not None
    error = "" if mean.error is None else f" +- {100 * mean.error:.2f}"
    return f"{100 * mean.value:6.2f}{error} % of flights"


def _time(mission: Mission, mean: Mean) -> str:
    """Steps or seconds, and as a clock shows them."""
    unit = " s" if mission.timed else " steps"
    seconds = None if mission.unit_s is None or mean.value is None else mean.value * mission.unit_s
    return mean.told(1, unit) + ("" if seconds is None else f"   ({clock(seconds)})")
