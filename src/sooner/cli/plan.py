"""`sooner plan`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from math import inf, isfinite
from pathlib import Path
from typing import Any

from sooner.cli.evaluate import tell_collected, tell_early, tell_left, tell_reference
from sooner.cli.exits import DONE, INTERRUPTED, say, uninterrupted
from sooner.cli.export import tell_exported
from sooner.cli.given import planning_time
from sooner.cli.progress import Watch
from sooner.cli.words import amount, flight, percent, times
from sooner.io import Folder
from sooner.missions import Mission, plan_mission, read_mission
from sooner.missions.exported import Exported, chosen, export, file_names
from sooner.missions.planning import FILES, Planned
from sooner.planners import Status

__all__ = ["plan"]


def plan(
    mission_file: Path,
    planner: str | None,
    seconds: float,
    seed: int,
    out: Path | None,
    formats: Sequence[str],
    as_json: bool,
    quiet: bool,
    force: bool,
) -> int:
    """Plan, write, tell; answers the exit status."""
    planning_time(seconds)
    asked = chosen([name for each in formats for name in each.split(",") if name.strip() != "csv"], some=False)
    mission = read_mission(mission_file)
    folder = Folder(out or mission_file.parent / f"{mission_file.stem}-plan", force)
    names = file_names(mission, asked) if asked else {}
    folder.check(*FILES, *names)
    with Watch(mission, planner, seconds, quiet) as watch:
        planned = plan_mission(mission, planner, seconds, seed, on_tick=watch.tick)
    with uninterrupted():
        result = planned.write(folder)
        if not as_json:
            _tell(mission, planned, result, folder)
        exported = _exported(planned, asked, folder)
    if as_json:
        told = {} if exported is None else {"exported": exported.result(str(folder.path))}
        print(json.dumps(result | told, allow_nan=False))
    elif exported is not None:
        tell_exported(exported, folder)
    if planned.solution.status is Status.INTERRUPTED:
        say("sooner: interrupted; the best plan so far is written")
        return INTERRUPTED
    return DONE


def _exported(planned: Planned, formats: Sequence[str], folder: Folder) -> Exported | None:
    """The files that fly, written; what the plan is worth stands already, whatever may be wrong with them."""
    if not formats:
        return None
    exported = export(planned.score, formats)
    folder.write(exported.files)
    return exported


def _reached(mission: Mission, planned: Planned, target: float) -> str:
    """When the target is reached, or that it is not, and whether any flight could."""
    time, best = planned.score.evaluation.time_to(target), planned.solution.best
    if isfinite(time):
        return f"{target:.3g} is reached after             {times(mission, time)}"
    if best.bound == -inf:
        return f"{target:.3g} cannot be reached in this time   (proof: {best.bound_proof}); this flight comes closest"
    return f"{target:.3g} is not reached; this flight comes closest"


def _tell(mission: Mission, planned: Planned, result: dict[str, Any], folder: Folder) -> None:
    score, best = planned.score, planned.solution.best
    target = mission.problem.objective.target
    print(f"{mission.name}: a flight of {flight(mission, result)}, planned by {planned.planner}")
    tell_collected(score)
    if target is not None:
        print(f"  {_reached(mission, planned, target)}")
    if result["bound"] is not None and target is None:
        which = (
            "no flight over these regions passes " if mission.over_regions else "no flight can pass                  "
        )
        print(f"  {which}{amount(mission, best.bound)}   (proof: {best.bound_proof})")
        print(f"  so it is at most                    {percent(best.gap)}   short of the best there is")
    elif result["bound"] is not None and best.value > -inf:
        print(f"  no flight gets there before         {times(mission, -best.bound)}   (proof: {best.bound_proof})")
    tell_reference(score)
    tell_left(score)
    if mission.timed:
        tell_early(score)
    _tell_planned(planned)
    print(f"plan     {folder.path / 'plan.csv'}")
    print(f"picture  {folder.path / 'plan.png'}")


def _tell_planned(planned: Planned) -> None:
    """What was given up to have it early, and what was said between drones."""
    late, exchange = planned.late, planned.exchange
    if late is not None:
        less = max(0.0, 1.0 - planned.score.evaluation.total / late.total)
        told = percent(late.early_share)
        print(f"  brought forward from                {told}   at the cost of {less:.2%} of the total")
    if exchange is not None:
        print(f"  messages between drones             {exchange.sent:6d}     of which {exchange.lost} were lost")
