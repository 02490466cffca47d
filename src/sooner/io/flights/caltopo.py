"""GeoJSON in the words of CalTopo and SARTopo: a folder for each flight, with a line, a marker and fences."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.flight_plan import Fence, FlightPlan, Place

__all__ = ["caltopo"]

INK = ("#FF6E1A", "#1F71B4", "#2CA02C", "#9467BD", "#17BECF", "#BE17CF")


def caltopo(plans: Sequence[FlightPlan], aircraft: Aircraft) -> bytes:
    """All flights as one collection, which CalTopo imports; longitude first, as GeoJSON has it."""
    features = [feature for number, plan in enumerate(plans) for feature in _features(plan, INK[number % len(INK)])]
    return (json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n").encode()


def _features(plan: FlightPlan, ink: str) -> Iterator[dict[str, Any]]:
    folder = plan.identifier("folder")
    yield _feature(folder, None, {"class": "Folder", "title": plan.name, "visible": True, "labelVisible": True})
    line = [_lon_lat((each.lat, each.lon)) for each in plan.waypoints]
    drawn = {"stroke": ink, "stroke-width": 3, "stroke-opacity": 1, "pattern": "solid"}
    told = {"class": "Shape", "title": plan.name, "description": _about(plan), "folderId": folder, **drawn}
    yield _feature(plan.identifier("line"), {"type": "LineString", "coordinates": line}, told)
    for name, place in (("home", plan.home), *(("may land here", landing) for landing in plan.landings)):
        told = {"class": "Marker", "title": f"{plan.name}: {name}", "description": "", "folderId": folder}
        told |= {"marker-color": ink, "marker-symbol": "drone", "marker-size": "1"}
        yield _feature(plan.identifier(f"{name} {place}"), {"type": "Point", "coordinates": _lon_lat(place)}, told)
    for number, fence in enumerate(plan.fences):
        yield _feature(plan.identifier(f"fence {number}"), *_fenced(fence, folder))


def _about(plan: FlightPlan) -> str:
    told = [f"flight {plan.searcher}", f"{plan.length_m:.0f} m", plan.height]
    if plan.duration_s is not None:
        told.append(f"{plan.duration_s:.0f} s")
    if plan.departs_s:
        told.append(f"takes off after {plan.departs_s:.0f} s")
    return ", ".join(told)


def _fenced(fence: Fence, folder: str) -> tuple[dict[str, Any], dict[str, Any]]:
    ink = "#00A000" if fence.inclusion else "#FF0000"
    ring = [_lon_lat(corner) for corner in (*fence.corners, fence.corners[0])]
    drawn = {"stroke": ink, "stroke-width": 2, "stroke-opacity": 1, "fill": ink}
    told = {"class": "Shape", "title": "stay inside" if fence.inclusion else "stay out", "description": ""}
    told_all = told | {"folderId": folder, **drawn, "fill-opacity": 0 if fence.inclusion else 0.2}
    return {"type": "Polygon", "coordinates": [ring]}, told_all


def _feature(name: str, geometry: dict[str, Any] | None, properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "id": name, "geometry": geometry, "properties": properties}


def _lon_lat(place: Place) -> list[float]:
    return [round(place[1], 9), round(place[0], 9)]
