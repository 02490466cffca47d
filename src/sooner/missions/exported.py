"""A judged plan as files: flights that aircraft fly, and maps of what they leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sooner.errors import DataFormatError, Fault
from sooner.io.flights import FORMATS, Aircraft, FlightPlan
from sooner.io.geotiff import geotiff
from sooner.missions.chances import LAYERS, chances
from sooner.missions.flight_plans import Flights, check_place, flights
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score

__all__ = ["EXPORTS", "Exported", "chosen", "export", "file_names"]

MAPS = "geotiff"
EXPORTS: dict[str, str] = {name: each.about for name, each in FORMATS.items()} | {
    MAPS: "maps of POC before and after the flight, and of POD"
}
"""What `sooner export --format` takes, and who reads it."""


@dataclass(frozen=True)
class Exported:
    """What was made of a plan.

    Parameters
    ----------
    files : dict            name -> content
    formats : dict          name -> format
    flights : Flights       what they tell aircraft
    """

    files: dict[str, bytes]
    formats: dict[str, str]
    flights: Flights

    def result(self, folder: str) -> dict[str, Any]:
        """One JSON object: the files, the flights, and what whoever flies them should know."""
        return {
            "files": [
                {"file": f"{folder}/{name}", "format": known, "bytes": len(self.files[name])}
                for name, known in self.formats.items()
            ],
            "searchers": [_told(plan) for plan in self.flights.plans],
            "separation": None if self.flights.separation is None else self.flights.separation.result(),
            "notes": list(self.flights.notes),
        }


def _told(plan: FlightPlan) -> dict[str, Any]:
    return {
        "searcher": plan.searcher,
        "name": plan.name,
        "home": list(plan.home),
        "waypoints": len(plan.waypoints),
        "length_m": plan.length_m,
        "duration_s": plan.duration_s,
        "takeoff_s": plan.takeoff_s,
        "landing_s": plan.landing_s,
        "departs_s": plan.departs_s,
        "altitude_m": plan.waypoints[0].altitude_m,
        "highest_m": max(each.altitude_m for each in plan.waypoints),
        "lowest_m": min(each.altitude_m for each in plan.waypoints),
        "home_altitude_m": plan.home_altitude_m,
        "speed_mps": plan.speed_mps,
        "finish": plan.finish,
        "fences": len(plan.fences),
        "stays": plan.stays,
    }


def chosen(formats: Sequence[str], some: bool = True) -> tuple[str, ...]:
    """The formats asked for, each once; names may be joined by commas. With `some` there must be one.

    Raises
    ------
    DataFormatError         if there is none, or one that nobody knows

    Examples
    --------
    >>> chosen(["gpx,kml", "gpx"])
    ('gpx', 'kml')
    """
    names = dict.fromkeys(name.strip() for each in formats for name in each.split(","))
    wrong = [name for name in names if name not in EXPORTS]
    if wrong or (some and not names):
        came = f"{wrong[0]!r} came" if wrong else "nothing came"
        raise DataFormatError(Fault("--format", "", came, f"expected one or more of {', '.join(EXPORTS)}"))
    return tuple(names)


def file_names(mission: Mission, formats: Sequence[str]) -> dict[str, str]:
    """The files that these formats make of a mission, each with its format: one for each flight if it holds one.

    Raises
    ------
    DataFormatError         if the mission does not say where on the globe it lies
    """
    check_place(mission)
    count = len(mission.problem.searchers)
    named: dict[str, str] = {}
    for name in formats:
        if name == MAPS:
            named |= {f"{layer}.tif": name for layer in LAYERS}
        elif FORMATS[name].single and count > 1:
            named |= {f"flight-{number}{FORMATS[name].suffix}": name for number in range(count)}
        else:
            named[f"flight{FORMATS[name].suffix}"] = name
    return named


def export(score: Score, formats: Sequence[str], autopilot: str | None = None, dji: str | None = None) -> Exported:
    """Every file of these formats.

    Parameters
    ----------
    autopilot, dji : str or None    of `Aircraft`, for all drones; None: as their vehicle files say

    Raises
    ------
    DataFormatError         if the mission says too little for a file that flies
    UnsupportedProblemError if a format has no way to say this
    """
    mission = score.mission
    aircraft = [_aircraft(mission, number, autopilot, dji) for number in range(len(score.plan.actions))]
    told = flights(score)
    if all(plan.stays for plan in told.plans):
        raise DataFormatError(Fault(str(mission.path), "", "a plan that goes nowhere came", "expected one that flies"))
    named = file_names(mission, formats)
    files: dict[str, bytes] = {}
    for name in formats:
        of_this = [file for file, known in named.items() if known == name]
        made = _maps(score) if name == MAPS else _written(name, told.plans, aircraft)
        files |= {file: content for file, content in zip(of_this, made, strict=True) if content is not None}
    return Exported(files, {file: known for file, known in named.items() if file in files}, told)


def _aircraft(mission: Mission, number: int, autopilot: str | None, dji: str | None) -> Aircraft:
    """What a drone's files are written for: as is asked, else as its vehicle file says."""
    vehicle = mission.sorties[number].vehicle if mission.sorties else None
    own = Aircraft() if vehicle is None else vehicle.aircraft
    return Aircraft(autopilot or own.autopilot, dji or own.dji)


def _written(name: str, plans: Sequence[FlightPlan], aircraft: Sequence[Aircraft]) -> list[bytes | None]:
    """A file's content, or one for each flight: None for who stays on the ground."""
    known = FORMATS[name]
    if not known.single:  # maps, which say nothing of the aircraft
        return [known.write([plan for plan in plans if not plan.stays], aircraft[0])]
    flown = zip(plans, aircraft, strict=True)
    return [None if plan.stays else known.write([plan], each) for plan, each in flown]


def _maps(score: Score) -> list[bytes | None]:
    ground = check_place(score.mission)
    tags = {"MISSION": score.mission.name, "TIFFTAG_SOFTWARE": "sooner"}
    return [geotiff(values, ground, LAYERS[name], tags) for name, values in chances(score).items()]
