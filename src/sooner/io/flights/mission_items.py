"""A flight as MAVLink's mission items, which .plan and .waypoints both write down."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from sooner.errors import InvalidProblemError
from sooner.io.flights.flight_plan import FlightPlan

__all__ = ["RELATIVE", "WAYPOINT", "MissionItem", "mission_items"]

WAYPOINT, LOITER, RETURN, LAND, TAKEOFF, SPEED = 16, 17, 20, 21, 22, 178  # MAV_CMD
NOWHERE, RELATIVE = 2, 3  # MAV_FRAME: of a command without a place; altitude above home
CLIMB_DEG = 15.0  # of a fixed wing that takes off
MOST_ITEMS = 65_535


@dataclass(frozen=True)
class MissionItem:
    """A command: its number, what its altitude counts from, four parameters, and a place.

    Parameters
    ----------
    command, frame : int        MAV_CMD, MAV_FRAME
    settings : four             None: what the autopilot thinks best
    lat, lon, altitude_m : float
    """

    command: int
    frame: int
    settings: tuple[float | None, float | None, float | None, float | None] = (0.0, 0.0, 0.0, 0.0)
    lat: float = 0.0
    lon: float = 0.0
    altitude_m: float = 0.0


def mission_items(plan: FlightPlan) -> tuple[MissionItem, ...]:
    """Take off, set the speed, fly to each waypoint, end; home itself is not among them.

    Raises
    ------
    InvalidProblemError         if there are more than MAVLink can count
    """
    items = tuple(_items(plan))
    if len(items) >= MOST_ITEMS:
        raise InvalidProblemError(f"a flight of {len(items):,} mission items came; MAVLink counts to {MOST_ITEMS:,}")
    return items


def _items(plan: FlightPlan) -> Iterator[MissionItem]:
    climb = CLIMB_DEG if plan.kind == "fixed_wing" else 0.0
    yield MissionItem(TAKEOFF, RELATIVE, (climb, 0.0, 0.0, None), *plan.home, plan.waypoints[0].altitude_m)
    flown: float | None = None
    for each, speed in zip(plan.waypoints, plan.speeds, strict=True):
        if speed is not None and speed != flown:
            over_ground, leave_the_throttle = 1.0, -1.0
            yield MissionItem(SPEED, NOWHERE, (over_ground, round(speed, 3), leave_the_throttle, 0.0))
            flown = speed
        held = (round(each.hold_s, 3), 0.0, 0.0, None)
        yield MissionItem(WAYPOINT, RELATIVE, held, each.lat, each.lon, each.altitude_m)
    last = plan.waypoints[-1]
    if plan.finish == "return":
        yield MissionItem(RETURN, NOWHERE)
    elif plan.finish == "land":
        yield MissionItem(LAND, RELATIVE, (0.0, 0.0, 0.0, None), last.lat, last.lon, 0.0)
    else:
        yield MissionItem(LOITER, RELATIVE, (0.0, 0.0, 0.0, None), last.lat, last.lon, last.altitude_m)
