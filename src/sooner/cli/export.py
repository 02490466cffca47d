"""`sooner export`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from sooner.cli.evaluate import judged
from sooner.cli.exits import DONE, say, uninterrupted
from sooner.cli.words import clock
from sooner.io import Folder
from sooner.io.flights import Aircraft
from sooner.missions import read_mission
from sooner.missions.exported import Exported, chosen, export, file_names

__all__ = ["export_plan", "tell_exported"]


def export_plan(
    mission_file: Path,
    plan_file: Path,
    formats: Sequence[str],
    out: Path | None,
    autopilot: str | None,
    dji: str | None,
    as_json: bool,
    force: bool,
) -> int:
    """Judge the plan, and write it in every format asked for."""
    asked = chosen(formats)
    Aircraft(autopilot or Aircraft.autopilot, dji or Aircraft.dji)  # names that nobody knows are refused at once
    mission = read_mission(mission_file)
    folder = Folder(out or plan_file.parent, force)
    folder.check(*file_names(mission, asked))
    exported = export(judged(mission, plan_file), asked, autopilot, dji)
    with uninterrupted():
        folder.write(exported.files)
    if as_json:
        told = {"mission": mission.name, "plan_file": str(plan_file), **exported.result(str(folder.path))}
        print(json.dumps(told, allow_nan=False))
    else:
        tell_exported(exported, folder)
    return DONE


def tell_exported(exported: Exported, folder: Folder) -> None:
    """Each flight, what whoever flies it should know, and the files."""
    for plan in exported.flights.plans:
        known = "" if plan.duration_s is None else f", {clock(plan.duration_s)}"
        ends = plan.takeoff_s + plan.landing_s
        known += f" and {clock(ends)} to take off and land" if ends else ""
        known += f", takes off at {clock(plan.departs_s)}" if plan.departs_s else ""
        print(f"{plan.name}: {len(plan.waypoints)} waypoints, {plan.length_m:.0f} m{known}, {plan.height}")
    for note in exported.flights.notes:
        say(f"note: {note}")
    for name, known_as in exported.formats.items():
        print(f"{known_as:9} {folder.path / name}")
