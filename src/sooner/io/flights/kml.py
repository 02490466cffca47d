"""KML: each flight a folder with its line, its home and its fences, for Google Earth and maps."""

from __future__ import annotations

from collections.abc import Sequence

from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.flight_plan import Fence, FlightPlan, Place
from sooner.io.flights.markup import branch, document, leaf

__all__ = ["NAMESPACE", "kml", "lon_lat"]

NAMESPACE = "http://www.opengis.net/kml/2.2"
INK = ("ff1a6eff", "ffb4711f", "ff2ca02c", "ff9467bd", "ff17becf", "ffcf17be")  # alpha, blue, green, red


def kml(plans: Sequence[FlightPlan], aircraft: Aircraft) -> bytes:
    """A folder for each flight. Heights are those above the sea where home's is known.

    Where it is not, they are drawn above the ground, though they are flown above home's.
    """
    folders = [_folder(plan, INK[number % len(INK)]) for number, plan in enumerate(plans)]
    return document(branch("kml", [branch("Document", folders)], {"xmlns": NAMESPACE}))


def lon_lat(lat: float, lon: float, *altitude_m: float) -> str:
    """A place as KML writes it: longitude first."""
    return ",".join([f"{lon:.9f}", f"{lat:.9f}", *(f"{each:.3f}" for each in altitude_m)])


def _folder(plan: FlightPlan, ink: str) -> str:
    sea_m = plan.home_altitude_m
    line = " ".join(lon_lat(each.lat, each.lon, (sea_m or 0.0) + each.altitude_m) for each in plan.waypoints)
    style = branch("Style", [branch("LineStyle", [leaf("color", ink), leaf("width", 3)])])
    height = leaf("altitudeMode", "relativeToGround" if sea_m is None else "absolute")
    flown = branch("LineString", [leaf("tessellate", 1), height, leaf("coordinates", line)])
    landings = [_place(f"{plan.name}: may land here", place) for place in plan.landings]
    parts = [
        leaf("name", plan.name),
        branch("Placemark", [leaf("name", plan.name), style, flown]),
        _place(f"{plan.name}: home", plan.home),
        *landings,
        *map(_fenced, plan.fences),
    ]
    return branch("Folder", parts)


def _place(name: str, place: Place) -> str:
    point = branch("Point", [leaf("coordinates", lon_lat(*place))])
    return branch("Placemark", [leaf("name", name), point])


def _fenced(fence: Fence) -> str:
    ring = " ".join(lon_lat(*corner) for corner in (*fence.corners, fence.corners[0]))
    border = branch("outerBoundaryIs", [branch("LinearRing", [leaf("coordinates", ring)])])
    lines = branch("LineStyle", [leaf("color", "ff00c000" if fence.inclusion else "ff0000ff"), leaf("width", 2)])
    style = branch("Style", [lines, branch("PolyStyle", [leaf("fill", 0)])])
    name = leaf("name", "stay inside" if fence.inclusion else "stay out")
    return branch("Placemark", [name, style, branch("Polygon", [border])])
