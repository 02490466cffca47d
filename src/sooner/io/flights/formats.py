"""The formats that flights are written in, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.caltopo import caltopo
from sooner.io.flights.cursor_on_target import cursor_on_target
from sooner.io.flights.dji import dji_kmz
from sooner.io.flights.flight_plan import FlightPlan
from sooner.io.flights.gpx import gpx
from sooner.io.flights.kml import kml
from sooner.io.flights.qgroundcontrol import qgroundcontrol_plan
from sooner.io.flights.waypoint_list import waypoint_list

__all__ = ["FORMATS", "Format"]

Writer = Callable[[Sequence[FlightPlan], Aircraft], bytes]


@dataclass(frozen=True)
class Format:
    """A format.

    Parameters
    ----------
    suffix : str        of its files
    about : str         who reads it, in one line
    write : callable    flights and the aircraft that fly them -> a file
    single : bool       a file holds one flight
    """

    suffix: str
    about: str
    write: Writer
    single: bool


def _one(writer: Callable[[FlightPlan, Aircraft], bytes]) -> Writer:
    """A writer of files that hold one flight."""

    def write(plans: Sequence[FlightPlan], aircraft: Aircraft) -> bytes:
        (plan,) = plans
        return writer(plan, aircraft)

    return write


FORMATS: dict[str, Format] = {
    "qgc": Format(".plan", "QGroundControl: mission, fence and rally points", _one(qgroundcontrol_plan), True),
    "waypoints": Format(".waypoints", "Mission Planner, APM Planner, MAVProxy", _one(waypoint_list), True),
    "dji": Format(".kmz", "DJI Pilot 2 and FlightHub 2 (WPML)", _one(dji_kmz), True),
    "kml": Format(".kml", "Google Earth and other maps", kml, False),
    "gpx": Format(".gpx", "handhelds and maps: a route", gpx, False),
    "caltopo": Format(".geojson", "CalTopo and SARTopo", caltopo, False),
    "cot": Format(".cot", "ATAK, WinTAK, TAK servers: a Cursor on Target route", _one(cursor_on_target), True),
}
