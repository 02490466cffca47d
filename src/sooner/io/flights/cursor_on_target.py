"""Cursor on Target: a flight as a route that ATAK, WinTAK and TAK servers take."""

from __future__ import annotations

from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.flight_plan import FlightPlan, Waypoint
from sooner.io.flights.markup import branch, document, empty, leaf

__all__ = ["cursor_on_target"]

UNKNOWN = "9999999.0"  # of heights and errors that nobody knows
WRITTEN, STALE = "2020-01-01T00:00:00.000Z", "2100-01-01T00:00:00.000Z"  # the same file each time; it does not expire
NOWHERE = {"lat": "0.0", "lon": "0.0", "hae": "0.0", "ce": UNKNOWN, "le": UNKNOWN}
DRAWN = {
    "color": "-37350",
    "stroke": "3",
    "method": "Flying",
    "direction": "Infil",
    "routetype": "Primary",
    "order": "Ascending Check Points",
    "prefix": "CP",
}


def cursor_on_target(plan: FlightPlan, aircraft: Aircraft) -> bytes:
    """An event of type b-m-r; its first and last places are waypoints, those between are control points.

    Heights are those above the ellipsoid in this format, which nobody here knows: they are left unknown.
    """
    route = plan.identifier("route")
    links = [_link(plan, f"{route}-{number}", number, each) for number, each in enumerate(plan.waypoints)]
    called = empty("contact", {"callsign": plan.name})
    detail = branch("detail", [*links, empty("link_attr", DRAWN), called, leaf("remarks", f"flight {plan.searcher}")])
    times = {"time": WRITTEN, "start": WRITTEN, "stale": STALE}
    told = {"version": "2.0", "uid": route, "type": "b-m-r", **times, "how": "h-e"}
    return document(branch("event", [empty("point", NOWHERE), detail], told))


def _link(plan: FlightPlan, uid: str, number: int, each: Waypoint) -> str:
    ends = {0: f"{plan.name} begins", len(plan.waypoints) - 1: f"{plan.name} ends"}
    told = {
        "uid": uid,
        "callsign": ends.get(number, ""),
        "type": "b-m-p-w" if number in ends else "b-m-p-c",
        "point": f"{each.lat:.9f},{each.lon:.9f},{UNKNOWN}",
        "relation": "c",
    }
    return empty("link", told)
