"""DJI's WPML: a .kmz of a template, which Pilot 2 shows and edits, and of the line that the aircraft flies."""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from sooner.errors import UnsupportedProblemError
from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.flight_plan import FlightPlan, Waypoint
from sooner.io.flights.kml import NAMESPACE, lon_lat
from sooner.io.flights.markup import branch, document, leaf

__all__ = ["dji_kmz"]

SPACE = {"xmlns": NAMESPACE, "xmlns:wpml": "http://www.dji.com/wpmz/1.0.2"}
WRITTEN_MS = 1_577_836_800_000  # 2020-01-01: the same file each time
WRITTEN = (2020, 1, 1, 0, 0, 0)
FINISH = {"return": "goHome", "land": "autoLand", "loiter": "noAction"}
STOP = "toPointAndStopWithDiscontinuityCurvature"  # straight to the point, and stop there
PASS = "toPointAndPassWithContinuityCurvature"  # on through it: where the line goes straight on
MOST_M, MOST_POINTS = 1_500.0, 65_536
LEAST_M, TRANSIT_MPS = 1.2, (1.0, 15.0)  # least height of a take-off; speeds on the way to the first waypoint


def dji_kmz(plan: FlightPlan, aircraft: Aircraft) -> bytes:
    """The file that DJI Pilot 2 and FlightHub 2 import: the aircraft flies straight lines, and stops in every corner.

    Waypoints that lie straight ahead, where only the height or the speed changes, are passed without a stop.

    Raises
    ------
    UnsupportedProblemError     without a speed, with less than two waypoints, too high, or on wings
    """
    _check(plan)
    parts = {
        "wpmz/template.kml": document(branch("kml", [_document(_template(plan, aircraft))], SPACE)),
        "wpmz/waylines.wpml": document(branch("kml", [_document(_waylines(plan, aircraft))], SPACE)),
    }
    written = BytesIO()
    with ZipFile(written, "w", ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            entry = ZipInfo(name, WRITTEN)
            entry.compress_type, entry.external_attr, entry.create_system = ZIP_DEFLATED, 0o644 << 16, 3
            archive.writestr(entry, content)
    return written.getvalue()


def _check(plan: FlightPlan) -> None:
    came = f"{plan.name!r}" if len(plan.name) <= 60 else f"{plan.name[:60]!r}..."
    if plan.kind == "fixed_wing":
        raise UnsupportedProblemError(f"{came} is flown on fixed wings; dji expects a copter")
    if plan.speed_mps is None:
        raise UnsupportedProblemError(f"{came} has no speed, which dji expects: give searcher.speed_mps")
    if len(plan.waypoints) < 2:
        raise UnsupportedProblemError(f"{came} has one waypoint; dji expects at least two")
    if len(plan.waypoints) > MOST_POINTS:
        raise UnsupportedProblemError(f"{came} has {len(plan.waypoints):,} waypoints; dji counts to {MOST_POINTS:,}")
    highest = max((each.altitude_m for each in plan.waypoints), key=abs)
    if abs(highest) > MOST_M:
        raise UnsupportedProblemError(f"{came} is flown {highest:g} m high; dji expects at most {MOST_M:g} m")


def _wpml(tag: str, said: object) -> str:
    return leaf(f"wpml:{tag}", said)


def _told(tag: str, said: Mapping[str, object]) -> str:
    return branch(f"wpml:{tag}", [_wpml(name, value) for name, value in said.items()])


def _number(value: float) -> str:
    return f"{value:.3f}".rstrip("0").rstrip(".")


def _document(children: list[str]) -> str:
    return branch("Document", children)


def _config(plan: FlightPlan, aircraft: Aircraft) -> str:
    """What both files say of the whole flight: up first, then across; home at the end and when the link is lost."""
    model, low, (slow, fast) = aircraft.model, plan.waypoints[0].altitude_m, TRANSIT_MPS
    told = {
        "flyToWaylineMode": "safely",
        "finishAction": FINISH[plan.finish],
        "exitOnRCLost": "executeLostAction",
        "executeRCLostAction": "goBack",
        "takeOffSecurityHeight": _number(max(low, LEAST_M)),
        "globalTransitionalSpeed": _number(min(max(plan.speed_mps or slow, slow), fast)),
    }
    parts = [_wpml(name, value) for name, value in told.items()]
    parts.append(_told("droneInfo", {"droneEnumValue": model.drone, "droneSubEnumValue": model.sub}))
    if model.payload is not None:
        parts.append(_told("payloadInfo", {"payloadEnumValue": model.payload, "payloadPositionIndex": 0}))
    return branch("wpml:missionConfig", parts)


def _template(plan: FlightPlan, aircraft: Aircraft) -> list[str]:
    system = {"coordinateMode": "WGS84", "heightMode": "relativeToStartPoint", "positioningType": "GPS"}
    parts = [
        _wpml("templateType", "waypoint"),
        _wpml("templateId", 0),
        _told("waylineCoordinateSysParam", system),
        _wpml("autoFlightSpeed", _number(plan.speed_mps or 0.0)),
        _wpml("globalHeight", _number(plan.waypoints[0].altitude_m)),
        _wpml("caliFlightEnable", 0),
        _wpml("gimbalPitchMode", "manual"),
        _told("globalWaypointHeadingParam", _heading()),
        _wpml("globalWaypointTurnMode", STOP),
        _wpml("globalUseStraightLine", 1),
    ]
    parts += [_shown(plan, index) for index in range(len(plan.waypoints))]
    created = [_wpml("author", "sooner"), _wpml("createTime", WRITTEN_MS), _wpml("updateTime", WRITTEN_MS)]
    return [*created, _config(plan, aircraft), branch("Folder", parts)]


def _waylines(plan: FlightPlan, aircraft: Aircraft) -> list[str]:
    parts = [
        _wpml("templateId", 0),
        _wpml("executeHeightMode", "relativeToStartPoint"),
        _wpml("waylineId", 0),
        _wpml("distance", _number(plan.length_m)),
        *([] if plan.duration_s is None else [_wpml("duration", _number(plan.duration_s))]),
        _wpml("autoFlightSpeed", _number(plan.speed_mps or 0.0)),
    ]
    parts += [_flown(plan, index) for index in range(len(plan.waypoints))]
    return [_config(plan, aircraft), branch("Folder", parts)]


def _heading() -> dict[str, object]:
    """The nose goes first."""
    return {"waypointHeadingMode": "followWayline", "waypointHeadingPathMode": "followBadArc"}


def _point(each: Waypoint, index: int) -> list[str]:
    return [branch("Point", [leaf("coordinates", lon_lat(each.lat, each.lon))]), _wpml("index", index)]


def _speed(plan: FlightPlan, index: int) -> str:
    """DJI's speed of a waypoint is that of the leg which leaves it."""
    onward = plan.waypoints[min(index + 1, len(plan.waypoints) - 1)].speed_mps
    return _number((plan.speed_mps or 0.0) if onward is None else onward)


def _shown(plan: FlightPlan, index: int) -> str:
    """A waypoint of the template."""
    each = plan.waypoints[index]
    height = _number(each.altitude_m)
    told = {"ellipsoidHeight": height, "height": height, "useGlobalHeight": 0}
    told |= {"useGlobalSpeed": 0, "waypointSpeed": _speed(plan, index), "useGlobalHeadingParam": 1}
    on = plan.passed[index]
    told |= {"useGlobalTurnParam": int(not on)}
    turn = [_turn(plan, index)] if on else []
    parts = [*map(_wpml, told, told.values()), *turn, _wpml("useStraightLine", 1)]
    return branch("Placemark", [*_point(each, index), *parts, *_hover(each, index)])


def _flown(plan: FlightPlan, index: int) -> str:
    """A waypoint of the line that is flown."""
    each = plan.waypoints[index]
    parts = [
        *_point(each, index),
        _wpml("executeHeight", _number(each.altitude_m)),
        _wpml("waypointSpeed", _speed(plan, index)),
        _told("waypointHeadingParam", _heading()),
        _turn(plan, index),
        _wpml("useStraightLine", 1),
    ]
    return branch("Placemark", [*parts, *_hover(each, index)])


def _turn(plan: FlightPlan, index: int) -> str:
    mode = PASS if plan.passed[index] else STOP
    return _told("waypointTurnParam", {"waypointTurnMode": mode, "waypointTurnDampingDist": 0})


def _hover(each: Waypoint, index: int) -> list[str]:
    """What the aircraft does there: wait, if it is to hold."""
    if not each.hold_s:
        return []
    param = _told("actionActuatorFuncParam", {"hoverTime": _number(each.hold_s)})
    action = branch("wpml:action", [_wpml("actionId", 0), _wpml("actionActuatorFunc", "hover"), param])
    told = {"actionGroupId": index, "actionGroupStartIndex": index, "actionGroupEndIndex": index}
    group = [_wpml(name, value) for name, value in (told | {"actionGroupMode": "sequence"}).items()]
    trigger = _told("actionTrigger", {"actionTriggerType": "reachPoint"})
    return [branch("wpml:actionGroup", [*group, trigger, action])]
