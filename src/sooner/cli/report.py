"""`sooner report`."""

from __future__ import annotations

import json
from pathlib import Path

from sooner.cli.evaluate import judged, tell_collected
from sooner.cli.exits import DONE, say, uninterrupted
from sooner.cli.given import planning_time
from sooner.cli.words import amount
from sooner.errors import DataFormatError, Fault
from sooner.io import Folder
from sooner.missions import read_mission
from sooner.missions.report import Report, make_report

__all__ = ["report_plan"]

USUAL = "report.html"


def report_plan(
    mission_file: Path, plan_file: Path, out: Path | None, seconds: float, as_json: bool, force: bool
) -> int:
    """Judge the plan, prove what can be proved in time, and write the page."""
    planning_time(seconds)
    mission = read_mission(mission_file)
    file = plan_file.parent / USUAL if out is None else out
    if not file.name or file.is_dir():
        expected = f"expected the name of a file, as {file / USUAL}"
        raise DataFormatError(Fault("--out", "", f"{str(file)!r} came, which is a folder", expected))
    folder = Folder(file.parent, force)
    folder.check(file.name)
    report = make_report(judged(mission, plan_file), seconds)
    page = report.html()
    with uninterrupted():
        folder.write({file.name: page})
    if as_json:
        told = {"plan_file": str(plan_file), "report": str(file), "bytes": len(page)}
        print(json.dumps(report.result() | told, allow_nan=False))
    else:
        _tell(report, file)
    return DONE


def _tell(report: Report, file: Path) -> None:
    mission = report.score.mission
    for note in report.notes:
        say(f"note: {note}")
    print(f"{mission.name}: {len(report.sheets)} flight{'s' * (len(report.sheets) != 1)}")
    tell_collected(report.score)
    for pattern in report.patterns[:1]:
        print(f"  {'the best pattern, ' + pattern.name + ',':35} {amount(mission, pattern.value)}")
    print(f"report   {file}")
