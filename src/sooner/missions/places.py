"""Starts and ends: cells of the map that can be entered."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.io import Raster
from sooner.io.georeference import cell_at
from sooner.missions.faults import Faults
from sooner.missions.layers import Layers
from sooner.missions.real_area import RealArea
from sooner.missions.settings import Place as OnGlobe
from sooner.missions.settings import Settings
from sooner.missions.sketch import named_place

__all__ = ["Place", "components", "places"]

Place = tuple[int, int]

ROUNDED = 0.01  # of a margin, by which arcs of straight lines fall short of it
NEARBY = 3  # cells from a place on the border of an area to one wholly within it


def places(faults: Faults, settings: Settings, layers: Layers) -> list[tuple[Place | None, Place | None]]:
    """Start and end of every searcher; None where the file gives none, or a wrong one."""
    margin_m = settings.area.margin_m if settings.over_legs else 0.0  # cells that keep it are told apart elsewhere
    found = []
    for number, said in enumerate(settings.searcher):
        key = f"searcher[{number}]"
        if said.start is None:
            faults.add(f"{key}.start", "nothing came", "expected [row, col], or lat and lon")
        start, end = (
            _place(faults, f"{key}.{name}", getattr(said, name), layers, margin_m) for name in ("start", "end")
        )
        found.append((start, end))
    return found


def _place(faults: Faults, key: str, said: Any, layers: Layers, margin_m: float) -> Place | None:
    if layers.first is None or layers.shape is None or said is None:
        return None
    if isinstance(said, str):
        cell = _titled(faults, key, said, layers)
    else:
        cell = _told(faults, key, said, layers.first) if isinstance(said, OnGlobe) else said
    if not isinstance(cell, list | tuple):
        return None
    row, col = cell
    told = f"[{row}, {col}]" if cell is said else f"{_words(said)}, which is [{row}, {col}],"
    height, width = layers.shape
    if layers.area is not None and not _in_area(
        faults, key, _words(said), _metres(said, cell, layers.area), layers.area, margin_m
    ):
        return None
    if not (0 <= row < height and 0 <= col < width):
        map_is = f"rows 0 to {height - 1} and columns 0 to {width - 1}"
        faults.add(key, f"{told} came", f"expected a cell of the map, which has {map_is}")
        return None
    if layers.obstacles is not None and layers.obstacles[row, col]:
        beside = None if cell is said or layers.area is None else _nearby(layers.obstacles, (row, col))
        if beside is None:
            faults.add(key, f"{told} came, and an obstacle stands there", "expected a cell that can be entered")
        return beside
    return row, col


def _words(said: Any) -> str:
    if isinstance(said, str):
        return repr(said)
    return f"lat {said.lat:g}, lon {said.lon:g}" if isinstance(said, OnGlobe) else str(list(said))


def _told(faults: Faults, key: str, said: OnGlobe, first: Raster) -> Place | None:
    """The cell of a latitude and longitude."""
    missing = [name for name in ("lat", "lon") if name not in said.model_fields_set]
    if missing:
        faults.add(f"{key}.{missing[0]}", "nothing came", "expected degrees: lat and lon make a place together")
        return None
    try:
        return cell_at(first, said.lat, said.lon)
    except InvalidProblemError as error:
        expected = "expected [row, col], or a GeoTIFF with its place on the globe"
        faults.add(key, str(error), expected)
        return None


# ---------------------------------------------------------------- on the ground


def _titled(faults: Faults, key: str, title: str, layers: Layers) -> Place | None:
    """The cell of a point by its title."""
    area = layers.area
    if area is None:
        expected = "expected [row, col] in whole numbers, or a title beside area.points or area.polygon"
        faults.add(key, f"{title!r} came", expected)
        return None
    point = named_place(faults, key, title, area.points, area.twice)
    if point is None:
        return None
    side = area.ground.cell_m
    return area.shape[0] - 1 - round(point[1] / side), round(point[0] / side)


def _metres(said: Any, cell: Place, area: RealArea) -> tuple[float, float]:
    if isinstance(said, str):
        return area.points[said]
    if isinstance(said, OnGlobe):
        east, north = area.frame.metres([[said.lat, said.lon]])[0]
        return float(east), float(north)
    return cell[1] * area.ground.cell_m, (area.shape[0] - 1 - cell[0]) * area.ground.cell_m


def _in_area(faults: Faults, key: str, told: str, place: tuple[float, float], area: RealArea, margin_m: float) -> bool:
    """Whether a place lies where drones may be, and in no zone; and so far from the border of both."""
    import shapely

    point = shapely.Point(place)
    if not area.no_fly.is_empty and area.no_fly.intersects(point):
        expected = "expected a place that drones may fly over: move it, or cut the zone (area.no_fly, area.obstacles)"
        faults.add(key, f"{told} came, which lies in a no-fly zone", expected)
        return False
    if (away := float(area.border.distance(point))) > 0:
        which = "search area" if area.flight_area is None else "flight area"
        expected = "expected a place in it: draw area.flight_area around both it and the way from there"
        faults.add(key, f"{told} came, which lies {away:.0f} m out of the {which}", expected)
        return False
    near = min(float(each.distance(point)) for each in (area.border.boundary, area.no_fly) if not each.is_empty)
    if near < (1.0 - ROUNDED) * margin_m:
        came = f"{told} came, {near:.1f} m from the border or a no-fly zone, and margin_m = {margin_m:g}"
        faults.add(key, came, "expected a place farther off, or a smaller area.margin_m")
        return False
    return True


def _nearby(obstacles: NDArray[np.bool_], cell: Place) -> Place | None:
    """The free cell nearest to one that is not; None where there is none nearby."""
    rows, cols = np.nonzero(~obstacles)
    if not len(rows):
        return None
    away = (rows - cell[0]) ** 2 + (cols - cell[1]) ** 2
    best = int(away.argmin())
    return (int(rows[best]), int(cols[best])) if away[best] <= NEARBY**2 else None


def components(free: NDArray[np.bool_]) -> NDArray[np.int32]:
    """(H, W) int: numbers from 1 for the pieces of free ground between which nothing can fly; 0 on obstacles.

    A diagonal step needs both cells beside it, so what hangs together by steps hangs together by sides.
    """
    from scipy.ndimage import label

    pieces: NDArray[np.int32] = label(free)[0]
    return pieces
