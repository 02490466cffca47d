"""`sooner simulate` of a mission over cells or over regions: plan, fly, and compare with what was promised."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path

from sooner.cli.exits import DONE, say, uninterrupted
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
from sooner.simulation.episodes import animation_of, picture_of
from sooner.simulation.plan_episode_file import plan_episode_npz

__all__ = ["simulate_plan"]

SECONDS = 10.0


def simulate_plan(mission_file: Path, asked: Asked, folder: Folder, as_json: bool, quiet: bool) -> int:
    """Plan, fly, write, tell; answers the exit status."""
    mission = read_mission(mission_file)
    folder.check("trials.csv", "simulation.json", "plan.csv", "plan.png", *episode_files(asked))
    seconds = SECONDS if asked.seconds is None else asked.seconds
    every = None if asked.replan is None else _every(mission, asked.replan)
    with Watch(mission, asked.planner, seconds, quiet) as watch:
        planned = plan_mission(mission, asked.planner, seconds, asked.seed, on_tick=watch.tick)
    if not quiet:
        say(f"flying it {asked.trials:,} times")
    flights = (
        fly_plan(planned.score, asked.seeds, asked.workers)
        if every is None
        else fly_replanned(planned, every, asked.seeds, asked.workers)
    )
    flown, status = gathered(flights, asked.trials, quiet)
    trials = PlanTrials(planned.score, flown)
    result = trials.result() | {"planner": planned.planner, "replan": asked.replan, "interrupted": status != DONE}
    result["files"] = str(folder.path)
    with uninterrupted():
        folder.write(
            {
                "trials.csv": csv_of(COLUMNS, (trial.row(mission.unit_s) for trial in flown)),
                "simulation.json": (json.dumps(result, allow_nan=False) + "\n").encode(),
                "plan.csv": plan_file(mission, planned.score.plan),
                "plan.png": plan_picture(planned),
                **_episode(planned, every, asked),
            }
        )
    if as_json:
        print(json.dumps(result, allow_nan=False))
    else:
        _tell(mission, trials, planned.planner, every, folder)
    tell_end(status, len(flown), asked.trials)
    return status


def _episode(planned: Planned, every: float | None, asked: Asked) -> dict[str, bytes]:
    """The first flight, kept whole."""
    episode = plan_episode(planned.score.mission, planned.score.plan, asked.seed, planned.planner, every)
    files = {"episode.npz": plan_episode_npz(episode), "episode.png": picture_of(episode)}
    return files | {"episode.gif": animation_of(episode)} if asked.animate else files


def _every(mission: Mission, wanted: float) -> float:
    """Time between plans in the judge's unit."""
    check_replanning(mission)
    every = wanted if mission.unit_s is None else wanted / mission.unit_s
    least = 1.0 if not mission.over_regions else 1e-3
    if not (isfinite(every) and every >= least):
        expected = "expected time for at least one step" if not mission.over_regions else "expected seconds above 0"
        raise DataFormatError(Fault("--replan", "", f"{wanted:g} came", expected))
    return every if mission.over_regions else float(int(every + 1e-9))


def _tell(mission: Mission, trials: PlanTrials, planner: str, every: float | None, folder: Folder) -> None:
    evaluation, unit, count = trials.score.evaluation, mission.sight.unit, len(trials.trials)
    long = flight(mission, trials.score.result())
    print(f"{mission.name}: a flight of {long}, planned by {planner}, flown {count:,} time{'s' if count > 1 else ''}")
    words = {"probability": "finds the person in", "bits": "learns", "targets": "finds"}[unit]
    print(f"  {words:35} {_amount(mission, trials.value)}")
    promised = "the judge promised" if every is None else "without replans, as promised"
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
    for name in ("trials.csv", "plan.csv", "episode.npz"):
        print(f"{name.split('.')[0]:8} {folder.path / name}")
    print(f"pictures {folder.path / 'plan.png'}, episode.png")


def _amount(mission: Mission, mean: Mean) -> str:
    """As the judge's amounts, with the standard error."""
    if mission.sight.unit != "probability":
        return mean.told(3, f" {mission.sight.unit}")
    assert mean.value is not None
    error = "" if mean.error is None else f" +- {100 * mean.error:.2f}"
    return f"{100 * mean.value:6.2f}{error} % of flights"


def _time(mission: Mission, mean: Mean) -> str:
    """Steps or seconds, and as a clock shows them."""
    unit = " s" if mission.over_regions else " steps"
    seconds = None if mission.unit_s is None or mean.value is None else mean.value * mission.unit_s
    return mean.told(1, unit) + ("" if seconds is None else f"   ({clock(seconds)})")
