"""`sooner upload`."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import Any

from sooner.cli.evaluate import judged
from sooner.cli.exits import BAD_INPUT, DONE, say
from sooner.errors import DataFormatError, Fault
from sooner.io.flights import AUTOPILOTS, FlightPlan
from sooner.io.mavlink import Connection, Patience, Uploaded, upload
from sooner.missions import read_mission
from sooner.missions.flight_plans import Flights, flights

__all__ = ["upload_plan"]

MOST_TOLD = 20
MOST_WAIT_S = 3_600.0


def upload_plan(
    mission_file: Path,
    plan_file: Path,
    connect: str,
    searcher: int | None,
    autopilot: str | None,
    system: int | None,
    wait: float,
    as_json: bool,
    quiet: bool,
    force: bool,
) -> int:
    """Judge the plan, send one drone's flight, and tell whether the vehicle holds what it was sent."""
    connection, patience, number = Connection.of(connect), _patience(wait), _autopilot(autopilot)
    mission = read_mission(mission_file)
    told = flights(judged(mission, plan_file))
    plan = _chosen(told, searcher, str(plan_file))
    tell = (lambda line: None) if quiet else say
    uploaded = upload(plan, connection, number, system, force, patience, tell)
    notes = [*told.about(plan), *uploaded.notes]
    if as_json:
        result = {"mission": mission.name, "plan_file": str(plan_file), "connection": str(connection)}
        print(json.dumps(result | _result(uploaded, plan, notes), allow_nan=False))
    else:
        _tell(uploaded, plan, notes)
    return DONE if uploaded.same else BAD_INPUT


def _patience(wait: float) -> Patience:
    if not (isfinite(wait) and 0.0 < wait <= MOST_WAIT_S):
        raise DataFormatError(Fault("--wait", "", f"{wait:g} came", f"expected seconds above 0, to {MOST_WAIT_S:g}"))
    return Patience(heartbeat_s=wait)


def _autopilot(name: str | None) -> int | None:
    if name is not None and name not in AUTOPILOTS:
        raise DataFormatError(Fault("--autopilot", "", f"{name!r} came", f"expected one of {', '.join(AUTOPILOTS)}"))
    return None if name is None else AUTOPILOTS[name]


def _chosen(told: Flights, searcher: int | None, plan_file: str) -> FlightPlan:
    """The flight to send: a vehicle flies one."""
    numbers = [plan.searcher for plan in told.plans]
    if searcher is None and len(numbers) > 1:
        came = f"flights of drones {', '.join(map(str, numbers))} came"
        raise DataFormatError(Fault(plan_file, "", came, "expected --searcher to say which this vehicle flies"))
    if searcher is not None and searcher not in numbers:
        expected = f"expected one of {', '.join(map(str, numbers))}"
        raise DataFormatError(Fault("--searcher", "", f"{searcher} came", expected))
    return told.plans[0 if searcher is None else numbers.index(searcher)]


def _result(uploaded: Uploaded, plan: FlightPlan, notes: list[str]) -> dict[str, Any]:
    vehicle = uploaded.vehicle
    return {
        "vehicle": {
            "system": vehicle.system,
            "component": vehicle.component,
            "autopilot": vehicle.autopilot_name,
            "armed": vehicle.armed,
        },
        "searcher": plan.searcher,
        "same": uploaded.same,
        "lists": [
            {"list": each.part, "sent": each.sent, "held": each.held, "differences": list(each.differences)}
            for each in uploaded.checked
        ],
        "notes": notes,
    }


def _tell(uploaded: Uploaded, plan: FlightPlan, notes: list[str]) -> None:
    for note in notes:
        say(f"note: {note}")
    for each in uploaded.checked:
        found = "read back the same" if not each.differences else f"{len(each.differences)} differences"
        print(f"{plan.name}: {each.part}, {each.sent} items sent, {each.held} held, {found}")
        for difference in each.differences[:MOST_TOLD]:
            say(f"sooner: {difference}")
        if len(each.differences) > MOST_TOLD:
            say(f"sooner: {each.part}: and {len(each.differences) - MOST_TOLD} more")
    if not uploaded.same:
        say("sooner: the vehicle does not hold what it was sent: do not fly it; upload again")
