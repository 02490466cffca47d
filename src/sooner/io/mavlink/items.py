"""The three lists that a vehicle holds of a flight: mission, fence and rally points, as it is told them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import ceil

from sooner.io.flights import FlightPlan
from sooner.io.flights.mission_items import RELATIVE, WAYPOINT, MissionItem, mission_items

__all__ = ["FENCE", "MISSION", "RALLY", "Part", "items_of"]

ABOVE_SEA = 0  # MAV_FRAME
STAY_INSIDE, STAY_OUT, RALLY_POINT = 5001, 5002, 5100  # MAV_CMD


@dataclass(frozen=True)
class Part:
    """One of a vehicle's lists.

    Parameters
    ----------
    name : str
    number : int            MAV_MISSION_TYPE
    capability : int        bit of MAV_PROTOCOL_CAPABILITY; 0: every vehicle has it
    item : str              what one of its items is called
    """

    name: str
    number: int
    capability: int
    item: str


MISSION = Part("mission", 0, 0, "item")
FENCE = Part("fence", 1, 1 << 14, "corner")
RALLY = Part("rally points", 2, 1 << 15, "point")


def items_of(plan: FlightPlan, part: Part, ardupilot: bool) -> tuple[MissionItem, ...]:
    """What is sent; ArduPilot's mission begins with home, and it is told only what it can keep.

    ArduPilot counts holds in whole seconds and heights of rally points in whole metres, here rounded up; where a
    parameter is the autopilot's to choose it takes 0 and, in some commands, refuses NaN.

    Examples
    --------
    >>> from sooner.io.flights import Waypoint
    >>> flight = FlightPlan("ridge", 0, (46.0, 11.0), (Waypoint(46.001, 11.0, 60.0, hold_s=2.5),), speed_mps=12.0)
    >>> [item.command for item in items_of(flight, MISSION, ardupilot=True)]
    [16, 22, 178, 16, 20]
    >>> items_of(flight, MISSION, ardupilot=True)[3].settings
    (3.0, 0.0, 0.0, None)
    """
    if part is FENCE:
        return tuple(_corners(plan))
    if part is RALLY:
        up = plan.waypoints[-1].altitude_m
        up = float(ceil(up)) if ardupilot else up
        return tuple(MissionItem(RALLY_POINT, RELATIVE, (0.0, 0.0, 0.0, 0.0), *place, up) for place in plan.landings)
    items = mission_items(plan)
    if not ardupilot:
        return items
    home = MissionItem(WAYPOINT, ABOVE_SEA, (0.0, 0.0, 0.0, 0.0), *plan.home, plan.home_altitude_m or 0.0)
    return home, *map(_kept, items)


def _kept(item: MissionItem) -> MissionItem:
    """A hold in whole seconds."""
    hold, *_ = item.settings
    if item.command != WAYPOINT or hold is None:
        return item
    return replace(item, settings=(float(ceil(hold)), *item.settings[1:]))


def _corners(plan: FlightPlan) -> Iterator[MissionItem]:
    for fence in plan.fences:
        command, count = STAY_INSIDE if fence.inclusion else STAY_OUT, float(len(fence.corners))
        for corner in fence.corners:
            yield MissionItem(command, ABOVE_SEA, (count, 0.0, 0.0, 0.0), *corner)
