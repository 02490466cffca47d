"""The layers of a search that lies on the globe: a grid over the area, and every raster brought to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, cos, pi, radians, tan
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.io.local_frame import LocalFrame, projection
from sooner.io.rasters import Raster
from sooner.missions.faults import Faults
from sooner.missions.real_area import RealArea
from sooner.missions.settings import Settings
from sooner.missions.sketch import Sketch

if TYPE_CHECKING:
    from sooner.io.warped import Warped

__all__ = [
    "LEAST_TOLD",
    "Ground",
    "blocked",
    "brought",
    "check_seen",
    "filled",
    "grid_over",
    "lies_on_globe",
    "real_area",
]

Floats = NDArray[np.float64]

USUAL_CELLS = 40_000  # of a grid whose cells nobody tells
ROUND_M = (1, 2, 5, 10, 20, 25, 50, 100, 200, 250, 500, 1000, 2000, 5000)
LEAST_TOLD = 0.0005  # of the probability: less lies outside untold
LOWEST_M, HIGHEST_M = -500, 9_000  # of ground above the sea
MOST_UNTRUE = 0.01  # share by which metres of a frame that is told may differ from those on the ground
DISC_CORNERS = 16  # of a quarter of a circle around a point that nobody flies over


def lies_on_globe(faults: Faults, settings: Settings) -> bool:
    """Whether a grid of its own is laid over the area: where it is drawn, or its first raster cannot be it."""
    area = settings.area
    if any(each is not None for each in (area.polygon, area.flight_area, area.segments, area.last_known, area.frame)):
        return True
    name = area.evidence if area.poc is None else area.poc
    if name is None or not name.lower().endswith((".tif", ".tiff")):
        return False
    from sooner.io.warped import square_and_upright

    try:
        return not square_and_upright(faults.path.parent / name)
    except DataFormatError:
        return False  # told where it is read


@dataclass(frozen=True, eq=False)
class Ground:
    """A grid over an area, and the area on it.

    Parameters
    ----------
    frame : LocalFrame
    sketch : Sketch
    polygon : geometry          the search area, in metres
    inside : (H, W) float       share of each cell that lies in it
    notes : tuple of str
    flight_area : geometry or None   where drones may be, in metres; None where that is the search area
    """

    frame: LocalFrame
    sketch: Sketch
    polygon: Any
    inside: Floats
    notes: tuple[str, ...]
    flight_area: Any | None = None

    @property
    def located(self) -> Raster:
        """A raster that says where the grid lies."""
        ground = self.frame.ground
        return Raster(self.inside, None, ground.cell_m, ground.corner, ground.crs)


def grid_over(faults: Faults, settings: Settings) -> Ground | None:
    """The grid of a search that is drawn; None where something is wrong with what is drawn."""
    import shapely

    from sooner.io.vectors import cover

    area = settings.area
    sketch = Sketch.read(faults, area)
    if area.grid == "hex":
        faults.add("area.grid", "'hex' came", "expected square cells over an area that is drawn")
    key, around, finest, notes = _around(faults, settings, sketch)
    if around is None:
        return None
    try:
        crs = None if area.frame is None else projection(area.frame)
    except InvalidProblemError as error:
        came, _, expected = str(error).partition("; ")
        faults.add("area.frame", came.removesuffix(" came") + " came", expected)
        return None
    if area.flight_area is not None and sketch.flight_area is None:
        return None
    whole = around if sketch.flight_area is None else shapely.union_all([around, sketch.flight_area])
    if sketch.flight_area is not None and sketch.flight_area.envelope.area > around.envelope.area:
        key = "area.flight_area"
    try:
        cell_m, told = _cell_m(area.cell_m, finest, whole, crs)
        frame = LocalFrame.around(whole, cell_m, crs=crs)
        polygon = _whole(frame.moved(around))
        flight_area = None if sketch.flight_area is None else _whole(frame.moved(sketch.flight_area))
    except InvalidProblemError as error:
        came, _, expected = str(error).partition("; ")
        faults.add(key, came, expected or "expected an area that a map can show")
        return None
    inside = cover(polygon, frame.shape, cell_m)
    _check_size(faults, settings, polygon, cell_m)
    if crs is not None and frame.scale_error > MOST_UNTRUE:
        came = f"{crs} came, whose metres are {frame.scale_error:.1%} off here"
        faults.add("area.frame", came, "expected a projection that is true here, or none: one centred on the area")
    middle = f"{frame.shape[0]} x {frame.shape[1]} cells of {cell_m:g} m"
    where = "centred on the area" if crs is None else crs
    notes += (f"{middle} in a projection {where}: metres true to {max(frame.scale_error, 1e-6):.0e}{told}",)
    notes += _beyond(faults, polygon, flight_area)
    return Ground(frame, sketch, polygon, inside, notes, flight_area)


def _whole(geometry: Any) -> Any:
    return geometry if geometry.is_valid else geometry.buffer(0)


def _beyond(faults: Faults, polygon: Any, flight_area: Any | None) -> tuple[str, ...]:
    """What of the search area no drone may fly over; a flight area that holds nothing of it is a fault."""
    if flight_area is None:
        return ()
    beyond = 1.0 - float(polygon.intersection(flight_area).area) / float(polygon.area)
    if beyond > 1.0 - 1e-9:
        came = f"an area {float(polygon.distance(flight_area)):.0f} m from the search area came"
        expected = "expected one that holds the search area too: drones are nowhere else"
        faults.add("area.flight_area", came, expected)
    told = f"{beyond:.1%} of the search area lies beyond the flight area, where no drone flies"
    return (told,) if beyond > LEAST_TOLD else ()


def _around(
    faults: Faults, settings: Settings, sketch: Sketch
) -> tuple[str, Any | None, float | None, tuple[str, ...]]:
    """Key and geometry of the area, a cell's side where a raster says one, and what to know of it."""
    import shapely

    from sooner.io.warped import extent

    area = settings.area
    name = area.evidence if area.poc is None else area.poc
    box, side = None, None
    if name is not None:
        key = "area.evidence" if area.poc is None else "area.poc"
        try:
            box, side, _ = extent(faults.path.parent / name)
        except DataFormatError as error:
            _add(faults, key, error)
            if area.polygon is None:
                return key, None, None, ()
    if area.polygon is not None:
        return "area.polygon", sketch.polygon, side, ()
    if area.segments is not None:
        drawn = [polygon for _, polygon, _ in sketch.segments]
        return "area.segments", shapely.union_all(drawn) if drawn else None, side, ()
    if area.last_known is not None:
        rings = area.last_known.rings_m
        if sketch.last_known is None or not rings:
            return "area.last_known", None, side, ()
        lon, lat = sketch.last_known
        near = LocalFrame.around(shapely.Point(lon, lat), max(rings), 0.0)
        turns = np.linspace(0.0, 2.0 * np.pi, 16 * DISC_CORNERS, endpoint=False)
        circle = np.column_stack([np.cos(turns), np.sin(turns)]) * max(rings) + near.metres([[lat, lon]])
        return "area.last_known", shapely.Polygon(near.places(circle)[:, ::-1]), side, ()
    if box is not None:
        return ("area.evidence" if area.poc is None else "area.poc"), shapely.box(*box), side, ()
    beside = "frame" if area.flight_area is None else "flight_area"
    faults.add("area.polygon", f"nothing came beside {beside}", "expected the search area, or poc in a GeoTIFF")
    return "area.polygon", None, None, ()


def _cell_m(said: float | None, raster_m: float | None, around: Any, crs: str | None) -> tuple[float, str]:
    """Metres of a cell: as the file says, else as the raster's, else a round number for a grid of usual size."""
    if said is not None:
        return said, ""
    from sooner.io.georeference import ground_m

    west, south, east, north = around.bounds
    middle = (south + north) / 2
    across, down = ground_m([[middle, west], [middle, east]])[0], ground_m([[south, west], [north, west]])[0]
    usual = float(np.sqrt(across * down / USUAL_CELLS))
    if raster_m is not None and across * down / raster_m**2 <= 25 * USUAL_CELLS:
        found = float(f"{raster_m:.3g}")
        return found, ", as fine as the raster (area.cell_m says otherwise)"
    return float(next((each for each in ROUND_M if each >= usual), ceil(usual))), " (area.cell_m says otherwise)"


def check_seen(faults: Faults, settings: Settings, polygon: Any, radius_m: float) -> None:
    """An area that one look covers needs no plan."""
    if polygon.area < np.pi * radius_m**2:
        area = settings.area
        keys = ("polygon", "segments", "last_known", "poc", "evidence")
        key = next((each for each in keys if getattr(area, each) is not None), "polygon")
        came = f"an area of {polygon.area:.0f} m2 came, and one look covers {np.pi * radius_m**2:.0f} m2"
        faults.once(f"area.{key}", came, "expected a larger area: one look from its middle may see all of it")


def _check_size(faults: Faults, settings: Settings, polygon: Any, cell_m: float) -> None:
    """An area that one look covers needs no plan; one smaller than a cell has none."""
    radius, camera = settings.sensor.radius_m, settings.sensor.camera
    if radius is None and camera is not None and camera.altitude_m is not None and camera.fov_deg is not None:
        radius = camera.altitude_m * tan(radians(camera.fov_deg) / 2.0)
    if radius is not None:
        check_seen(faults, settings, polygon, radius)
    if polygon.area < cell_m**2:
        came = f"an area of {polygon.area:.3g} m2 came, and cells of {cell_m:g} m"
        faults.add("area.cell_m", came, "expected smaller cells")


def real_area(faults: Faults, settings: Settings, ground: Ground) -> RealArea:
    """Zones, points and elevation on a grid."""
    import shapely

    frame, sketch = ground.frame, ground.sketch
    zones = [frame.moved(zone) for zone in sketch.zones]
    around = 1.0 / cos(pi / (4 * DISC_CORNERS))  # so that the polygon holds the circle
    zones += [frame.moved(each.geometry).buffer(each.radius_m * around, DISC_CORNERS) for each in sketch.circles]
    no_fly = shapely.union_all([_whole(zone) for zone in zones]) if zones else shapely.MultiPolygon()
    places = {name: frame.metres([[lat, lon]])[0] for name, (lon, lat) in sketch.points.items()}
    points = {name: (float(place[0]), float(place[1])) for name, place in places.items()}
    known = ground.polygon if ground.flight_area is None else shapely.union_all([ground.polygon, ground.flight_area])
    elevation = _elevation(faults, settings.area.elevation, frame, known)
    here = frame.ground, frame.shape, sketch.twice
    return RealArea(ground.polygon, no_fly, points, elevation, *here, ground.flight_area)


def _elevation(faults: Faults, name: str | None, frame: LocalFrame, polygon: Any) -> Floats | None:
    """(H, W) float: metres above the sea; beyond the raster, where the area does not reach, those nearby."""
    from sooner.io.vectors import cover
    from sooner.io.warped import sampled_on

    if name is None:
        return None
    found = brought(
        faults, "area.elevation", name, lambda path: sampled_on(path, frame.ground, frame.shape, smooth=True)
    )
    if found is None:
        return None
    values = found.values
    missing = ~np.isfinite(values)
    needed = missing & (cover(polygon, frame.shape, frame.ground.cell_m) > 0)
    if needed.any():
        row, col = np.argwhere(needed)[0]
        came = f"{name} says nothing of {int(needed.sum())} cells of the area, the first at [{row}, {col}]"
        faults.add("area.elevation", came, "expected a raster that covers the area")
        return None
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if low < LOWEST_M or high > HIGHEST_M:
        came = f"heights from {low:g} to {high:g} came in {name}"
        faults.add("area.elevation", came, f"expected metres above the sea, from {LOWEST_M:,} to {HIGHEST_M:,}")
        return None
    return filled(values, missing)


def filled(values: Floats, missing: NDArray[np.bool_]) -> Floats:
    """The same, with the nearest value where one is missing."""
    from scipy.ndimage import distance_transform_edt

    if not missing.any():
        return values
    rows, cols = distance_transform_edt(missing, return_distances=False, return_indices=True)
    return np.asarray(values[rows, cols])


def brought(faults: Faults, key: str, name: str, how: Callable[[Any], Warped]) -> Warped | None:
    """A raster on the grid; None, and a fault of its key, where it cannot be brought there."""
    try:
        return how(faults.path.parent / name)
    except DataFormatError as error:
        _add(faults, key, error)
        return None


def _add(faults: Faults, key: str, error: DataFormatError) -> None:
    for fault in error.faults:
        where = f", {fault.key}" if fault.key else ""
        faults.add(key, f"{fault.file}{where}: {fault.came}", fault.expected)
    faults.wrong.add(key)


def blocked(area: RealArea, margin_m: float) -> NDArray[np.bool_]:
    """(H, W) bool: cells that do not lie wholly where a drone may be, so that no step between others leaves it."""
    from sooner.io.vectors import cover

    return np.asarray(cover(area.flyable(margin_m), area.shape, area.ground.cell_m) < 1.0)
