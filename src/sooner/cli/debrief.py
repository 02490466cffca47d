"""`sooner debrief`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from sooner.cli.evaluate import judged
from sooner.cli.exits import DONE, say, uninterrupted
from sooner.cli.words import clock, percent
from sooner.errors import DataFormatError, Fault
from sooner.io import Folder
from sooner.io.tracks import read_tracks
from sooner.missions import read_mission
from sooner.missions.debrief import FILES, GAPS, NEXT, Debrief, debrief
from sooner.missions.debrief_next import MISSION, SEARCHED

__all__ = ["debrief_tracks"]


def debrief_tracks(
    mission_file: Path,
    track_files: Sequence[Path],
    plan_file: Path | None,
    out: Path | None,
    gap_s: float,
    as_json: bool,
    force: bool,
) -> int:
    """Read tracks, judge them, write what is left, tell."""
    if not (isfinite(gap_s) and gap_s > 0.0):
        raise DataFormatError(Fault("--gap", "", f"{gap_s:g} came", "expected seconds above 0"))
    mission = read_mission(mission_file)
    folder = Folder(out or mission_file.parent / f"{mission_file.stem}-debrief", force)
    folder.check(*FILES, *([] if plan_file is None else [GAPS]))
    Folder(folder.path / NEXT, force).check(MISSION, SEARCHED)
    speed = mission.settings.searcher[0].speed_mps
    tracks = [track for file in track_files for track in read_tracks(file, gap_s, speed)]
    plan = None if plan_file is None else judged(mission, plan_file)
    found = debrief(mission, tracks, plan)
    with uninterrupted():
        result = found.write(folder)
    if as_json:
        print(json.dumps(result, allow_nan=False))
    else:
        _tell(found, result["next"], folder)
    for note in result["notes"]:
        say(f"note: {note}")
    return DONE


def _tell(found: Debrief, following: str | None, folder: Folder) -> None:
    _tell_flights(found)
    if found.remaining is None:
        print(f"  finds, as expected                  {found.found:6.3f}   targets")
    else:
        print(f"  would have found the person with    {percent(found.found)}   POS of these flights")
        if found.searched.flights:
            print(
                f"  with all {found.so_far.flights} flights so far            {percent(found.so_far.pos)}   POS so far"
            )
        shares, before = found.remaining, "of the probability before"
        print(f"  never looked at                     {percent(shares['never_looked'])}   {before}")
        print(f"  looked at, and missed               {percent(shares['looked_but_missed'])}   {before}")
        if found.outside:
            print(f"  outside this map                    {percent(shares['outside'])}   {before}")
            print(f"  outside this map                    {percent(found.outside)}   now")
    _tell_plan(found)
    print(f"files     {folder.path}")
    if following is not None:
        print(f"next      sooner plan {following}")


def _tell_flights(found: Debrief) -> None:
    print(f"{found.mission.name}: {len(found.tracks)} flight{'s' * (len(found.tracks) != 1)}")
    for number, (each, adds) in enumerate(zip(found.tracks, found.adds, strict=True)):
        seconds = each.track.duration_s
        lasted = "" if seconds is None else f", {clock(seconds)}"
        worth = f", adds {100 * adds:.2f} %" if found.remaining is not None else ""
        print(f"  flight {number}: {each.length_m:.0f} m{lasted}{worth}   {Path(each.track.source).name}")


def _tell_plan(found: Debrief) -> None:
    beside = found.compared
    if beside is None:
        return
    poc = float(found.after.ravel()[beside.missed].sum())
    lat, lon = beside.farthest_at
    if beside.share_flown is not None:
        print(f"  of the plan's line was flown        {percent(beside.share_flown)}")
    if beside.found > 0:
        print(f"  of what the plan would find         {percent(found.found / beside.found)}")
    if beside.share_flown is not None:
        print(f"  farthest from the plan              {beside.farthest_m:6.0f} m at {lat:.5f}, {lon:.5f}")
    holds = f", where the person is now with {percent(poc).strip()}"
    print(
        f"  gaps                                {beside.gap_m2 / 1e4:6.2f} ha in {len(beside.gaps)} places"
        + (holds if beside.gaps and found.remaining is not None else "")
    )
    if beside.slivers_m2:
        print(f"  smaller than one look, left out     {beside.slivers_m2 / 1e4:6.2f} ha")
