"""Mission Planner's .waypoints: a line of twelve numbers for each mission item, home first."""

from __future__ import annotations

from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.flight_plan import FlightPlan
from sooner.io.flights.mission_items import WAYPOINT, MissionItem, mission_items

__all__ = ["waypoint_list"]

HEADER = "QGC WPL 110"
ABOVE_SEA = 0  # MAV_FRAME


def waypoint_list(plan: FlightPlan, aircraft: Aircraft) -> bytes:
    """The file that Mission Planner, APM Planner and MAVProxy open.

    Examples
    --------
    >>> from sooner.io.flights.flight_plan import Waypoint
    >>> flight = FlightPlan("ridge", 0, (46.0, 11.0), (Waypoint(46.001, 11.0, 60.0, hold_s=2.0),))
    >>> print(waypoint_list(flight, Aircraft()).decode().splitlines()[3].replace("\\t", " "))
    2 0 3 16 2.000 0.000 0.000 0.000 46.001000000 11.000000000 60.000 1
    """
    home = MissionItem(WAYPOINT, ABOVE_SEA, (0.0, 0.0, 0.0, 0.0), *plan.home, plan.home_altitude_m or 0.0)
    items = (home, *mission_items(plan))
    return "".join(f"{line}\n" for line in (HEADER, *map(_line, range(len(items)), items))).encode()


def _line(number: int, item: MissionItem) -> str:
    numbers = [f"{0.0 if each is None else each:.3f}" for each in item.settings]
    place = [f"{item.lat:.9f}", f"{item.lon:.9f}", f"{item.altitude_m:.3f}"]
    return "\t".join([str(number), str(int(number == 0)), str(item.frame), str(item.command), *numbers, *place, "1"])
