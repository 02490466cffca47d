"""Fences of an area that is drawn: its own polygons, with as few corners as autopilots have memory for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.io.flights import Fence
from sooner.missions.fences import CLEAR_M, MOST_CORNERS, MOST_TRIED
from sooner.missions.mission_file import Mission
from sooner.missions.real_area import RealArea

__all__ = ["drawn_fences", "rings_around"]

MOST_INSIDE, MOST_OUTSIDE = 40, 16  # corners of the fence to stay in, and of each to stay out of
LARGER_M = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # by which a fence may be drawn larger than its border
LEAST_M2 = 1.0  # of ground that is worth a fence

Floats = NDArray[np.float64]


def drawn_fences(mission: Mission, line: Floats, closed: bool) -> tuple[tuple[Fence, ...], tuple[str, ...]]:
    """Fences of a mission whose area is drawn, that a flight does not come near, and what is left out.

    Parameters
    ----------
    line : (n, 2) float     metres east and north that the flight passes
    closed : bool           it comes straight back from the last to the first
    """
    said, area = mission.settings.area, mission.area
    assert area is not None
    bounded = any(each is not None for each in (said.polygon, said.flight_area, said.segments, said.last_known))
    flown = np.concatenate([line, line[:1]]) if closed else line
    zones = shapely.union_all([area.no_fly, *_squares(area, mission.obstacles)])
    rings, notes = rings_around(area.border if bounded else None, zones, flown)
    places = area.frame.places
    told = tuple(
        Fence(tuple((float(lat), float(lon)) for lat, lon in places(ring)), inclusion) for ring, inclusion in rings
    )
    return told, notes


def rings_around(inside: Any | None, zones: Any, flown: Floats) -> tuple[list[tuple[Floats, bool]], tuple[str, ...]]:
    """Rings to stay in and out of, in metres: each holds all that its border does, and the flight keeps clear of it.

    The border of the area comes first, then the largest zones. Each is its own border where that has few corners, else
    one that is drawn a little larger and simpler; the border to stay in gives way where the flight comes near to it.

    Parameters
    ----------
    inside : geometry or None   the area; None where its edge forbids nothing
    zones : geometry            that nothing flies over
    flown : (n, 2) float        metres that the flight passes

    Returns
    -------
    rings : of ((m, 2) float, bool)   corners, and whether to stay in
    notes : of str                    what is left out

    Examples
    --------
    >>> rings, notes = rings_around(shapely.box(0, 0, 500, 300), shapely.Point(300, 200).buffer(40), [[9, 9], [90, 9]])
    >>> [(len(ring), inclusion) for ring, inclusion in rings], notes
    ([(4, True), (16, False)], ())
    """
    path = shapely.LineString(flown) if len(flown) > 1 else shapely.Point(flown[0])
    shapes: list[tuple[Any, bool]] = []
    if inside is not None:
        own = next((part for part in shapely.get_parts(inside) if part.covers(shapely.Point(flown[0]))), None)
        if own is not None:
            shapes.append((shapely.Polygon(own.exterior), True))
            holes = [shapely.Polygon(ring) for ring in own.interiors]
            zones = shapely.union_all([zones, *holes]).intersection(shapes[0][0])
    solid = [shapely.Polygon(part.exterior) for part in shapely.get_parts(zones) if part.geom_type == "Polygon"]
    solid = [part for part in solid if part.area >= LEAST_M2]
    shapes += [(part, False) for part in sorted(solid, key=lambda part: -part.area)]
    kept: list[tuple[Floats, bool]] = []
    near = corners = 0
    for shape, inclusion in shapes[:MOST_TRIED]:
        fitting = [ring for ring in _drawn(shape, inclusion) if corners + len(ring) <= MOST_CORNERS]
        clear = next((ring for ring in fitting if _clear(ring, inclusion, path)), None)
        if clear is not None:
            kept.append((clear, inclusion))
            corners += len(clear)
        elif fitting:
            near += 1
    return kept, _told(len(shapes), near, len(shapes) - len(kept) - near)


def _drawn(shape: Any, inclusion: bool) -> Iterator[Floats]:
    """Rings that hold a polygon, the nearest to it first, none of more corners than its kind has."""
    most = MOST_INSIDE if inclusion else MOST_OUTSIDE
    for larger_m in LARGER_M:
        # by half of what was added: where a ring begins, GEOS moves the border by up to twice what it is told
        drawn = shape.buffer(larger_m, join_style="mitre").simplify(larger_m / 2) if larger_m else shape
        ring = shapely.get_coordinates(drawn.exterior)[:-1]
        if len(ring) <= most and drawn.covers(shape):
            yield ring
    hull = shape.buffer(LARGER_M[-1] / 10, join_style="mitre").convex_hull
    for larger_m in LARGER_M[1:]:
        drawn = hull.buffer(larger_m, join_style="mitre").simplify(larger_m / 2)
        ring = shapely.get_coordinates(drawn.exterior)[:-1]
        if len(ring) <= most and drawn.covers(shape):
            yield ring


def _clear(ring: Floats, inclusion: bool, path: Any) -> bool:
    """Whether the flight is on the right side of a ring, and not near to it."""
    fence = shapely.Polygon(ring)
    return bool(fence.contains(path) == inclusion and fence.exterior.distance(path) >= CLEAR_M)


def _squares(area: RealArea, obstacles: NDArray[np.bool_] | None) -> list[Any]:
    """Cells that cannot be entered, as far as the drawn zones do not hold them."""
    if obstacles is None or not obstacles.any():
        return []
    rows, cols = np.nonzero(obstacles)
    side = area.ground.cell_m
    east, north = cols * side, (area.shape[0] - 1 - rows) * side
    return [shapely.union_all(shapely.box(east - side / 2, north - side / 2, east + side / 2, north + side / 2))]


def _told(count: int, near: int, many: int) -> tuple[str, ...]:
    told = []
    if near:
        why = f"the flight comes within {CLEAR_M:g} m of them: area.margin_m keeps it farther off"
        told.append(f"{near} of {count} fences are left out: {why}")
    if many:
        told.append(f"{many} of {count} fences are left out: they have more than {MOST_CORNERS} corners in all")
    return tuple(told)
