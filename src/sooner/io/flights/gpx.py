"""GPX 1.1: each flight a route, each home a waypoint, for handhelds and maps."""

from __future__ import annotations

from collections.abc import Sequence

from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.flight_plan import FlightPlan, Place
from sooner.io.flights.markup import branch, document, leaf

__all__ = ["gpx"]

SPACE = {"version": "1.1", "creator": "sooner", "xmlns": "http://www.topografix.com/GPX/1/1"}


def gpx(plans: Sequence[FlightPlan], aircraft: Aircraft) -> bytes:
    """A route for each flight. Heights stand in it only where home's is known: GPX counts them from the sea."""
    homes = [_point("wpt", plan.home, plan.home_altitude_m, [leaf("name", f"{plan.name}: home")]) for plan in plans]
    return document(branch("gpx", [*homes, *map(_route, plans)], SPACE))


def _route(plan: FlightPlan) -> str:
    sea_m = plan.home_altitude_m
    points = [
        _point("rtept", (each.lat, each.lon), None if sea_m is None else sea_m + each.altitude_m, [])
        for each in plan.waypoints
    ]
    return branch("rte", [leaf("name", plan.name), leaf("number", plan.searcher), *points])


def _point(tag: str, place: Place, above_sea_m: float | None, children: list[str]) -> str:
    height = [] if above_sea_m is None else [leaf("ele", f"{above_sea_m:.3f}")]
    return branch(tag, [*height, *children], {"lat": f"{place[0]:.9f}", "lon": f"{place[1]:.9f}"})
