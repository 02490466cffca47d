"""QGroundControl's .plan: mission, fence and rally points as JSON."""

from __future__ import annotations

import json
from typing import Any

from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.flight_plan import Fence, FlightPlan, Place
from sooner.io.flights.mission_items import RELATIVE, MissionItem, mission_items

__all__ = ["qgroundcontrol_plan"]

COPTER, FIXED_WING = 2, 1  # MAV_TYPE
USUAL_MPS = {"copter": 5.0, "fixed_wing": 15.0}  # QGroundControl's own, where the flight has no speed


def qgroundcontrol_plan(plan: FlightPlan, aircraft: Aircraft) -> bytes:
    """The file that QGroundControl opens.

    Examples
    --------
    >>> from sooner.io.flights.flight_plan import Waypoint
    >>> flight = FlightPlan("ridge", 0, (46.0, 11.0), (Waypoint(46.001, 11.0, 60.0),), speed_mps=12.0)
    >>> [item["command"] for item in json.loads(qgroundcontrol_plan(flight, Aircraft()))["mission"]["items"]]
    [22, 178, 16, 20]
    """
    speed = USUAL_MPS[plan.kind] if plan.speed_mps is None else plan.speed_mps
    items = mission_items(plan)
    told = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": aircraft.firmware,
            "vehicleType": FIXED_WING if plan.kind == "fixed_wing" else COPTER,
            "cruiseSpeed": speed,
            "hoverSpeed": speed,
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": [*_degrees(plan.home), plan.home_altitude_m or 0.0],
            "items": [_item(number, item) for number, item in enumerate(items, start=1)],
        },
        "geoFence": {"version": 2, "polygons": [_polygon(fence) for fence in plan.fences], "circles": []},
        "rallyPoints": {
            "version": 2,
            "points": [[*_degrees(place), plan.waypoints[-1].altitude_m] for place in plan.landings],
        },
    }
    return (json.dumps(told, indent=1, allow_nan=False) + "\n").encode()


def _degrees(place: Place) -> list[float]:
    return [round(place[0], 9), round(place[1], 9)]


def _item(number: int, item: MissionItem) -> dict[str, Any]:
    told: dict[str, Any] = {
        "type": "SimpleItem",
        "command": item.command,
        "frame": item.frame,
        "params": [*item.settings, *_degrees((item.lat, item.lon)), round(item.altitude_m, 3)],
        "autoContinue": True,
        "doJumpId": number,
    }
    if item.frame == RELATIVE:
        told |= {"Altitude": round(item.altitude_m, 3), "AltitudeMode": 1, "AMSLAltAboveTerrain": None}
    return told


def _polygon(fence: Fence) -> dict[str, Any]:
    return {"polygon": [_degrees(corner) for corner in fence.corners], "inclusion": fence.inclusion, "version": 1}
