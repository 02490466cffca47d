"""Layers over an area that is drawn: first where the person may be, then what looks see there and what stands there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.missions.area_layers import LEAST_TOLD, Ground, blocked, brought, filled, grid_over, real_area
from sooner.missions.drawings import is_drawn
from sooner.missions.faults import Faults
from sooner.missions.land_cover import class_glimpse
from sooner.missions.settings import Settings
from sooner.missions.sketch import Sketch

if TYPE_CHECKING:
    from sooner.io.rasters import Raster
    from sooner.io.warped import Warped

__all__ = ["drawn_beside", "layers_on_ground"]

Floats = NDArray[np.float64]


def layers_on_ground(faults: Faults, settings: Settings) -> dict[str, Any]:
    """What `Layers` holds of a search whose grid is laid over its area; what is wrong is added to the faults."""
    _check_prior(faults, settings)
    ground = grid_over(faults, settings)
    if ground is None:
        return {}
    area = real_area(faults, settings, ground)
    found = {
        "shape": ground.frame.shape,
        "cell_m": ground.frame.ground.cell_m,
        "first": ground.located,
        "area": area,
        "notes": ground.notes,
        "glimpse": _glimpse(faults, settings, ground),
        "sweep_width": _sweep_width(faults, settings, ground),
    }
    stones = _stones(faults, settings, ground)
    if not settings.over_legs:
        shut = blocked(area, settings.area.margin_m)
        if shut.all():
            came = (
                f"no cell of {ground.frame.ground.cell_m:g} m lies wholly in the area, its margin and no-fly zones kept"
            )
            faults.add("area.cell_m", came, "expected smaller cells, a smaller margin_m, or fewer zones")
        stones = shut if stones is None else stones | shut
    if area.flyable(settings.area.margin_m).is_empty:
        came = f"nothing of the area is left with a margin of {settings.area.margin_m:g} m and no-fly zones"
        faults.once("area.margin_m", came, "expected some ground to fly over")
    return found | {"obstacles": stones} | _prior(faults, settings, ground)


def drawn_beside(
    faults: Faults, settings: Settings, first: Raster | None, obstacles: NDArray[np.bool_] | None
) -> dict[str, Any]:
    """What `Layers` gains from drawings, elevation and land cover beside rasters that are the grid themselves."""
    area = settings.area
    keys = [key for key in ("no_fly", "points", "elevation", "land_cover") if getattr(area, key) is not None]
    keys += ["margin_m"] if area.margin_m else []
    keys += ["obstacles"] if area.obstacles is not None and is_drawn(area.obstacles) else []
    if first is None or not (keys or settings.over_legs):
        return {}
    if first.corner is None:
        for key in keys:
            expected = "expected area.polygon, or a GeoTIFF with its place on the globe"
            faults.add(f"area.{key}", "it came, and a map without a georeference", expected)
        return {}
    import shapely

    from sooner.io.georeference import Georeference
    from sooner.io.local_frame import LocalFrame

    height, width = first.values.shape
    frame = LocalFrame(Georeference.of(first), (height, width))
    side = frame.ground.cell_m
    box = shapely.box(-side / 2, -side / 2, (width - 0.5) * side, (height - 0.5) * side)
    ground = Ground(frame, Sketch.read(faults, area), box, np.ones(first.values.shape), ())
    real = real_area(faults, settings, ground)
    found: dict[str, Any] = {"area": real}
    if settings.sensor.land_cover is not None:
        found["glimpse"] = class_glimpse(faults, settings, ground)
    if not settings.over_legs and (area.margin_m or not real.no_fly.is_empty):
        shut = blocked(real, area.margin_m)
        found["obstacles"] = shut if obstacles is None else shut | obstacles
    return found


# ---------------------------------------------------------------- where the person may be


def _check_prior(faults: Faults, settings: Settings) -> None:
    area = settings.area
    given = [key for key in ("poc", "evidence", "segments", "last_known") if getattr(area, key) is not None]
    if len(given) > 1:
        faults.add("area", f"{' and '.join(given)} came", "expected one of them")
    if area.outside and (area.segments is not None or area.last_known is not None):
        came = f"{area.outside:g} came, and {'segments' if area.segments is not None else 'last_known'}"
        faults.add("area.outside", came, "expected it left out: what their POC leave of one is outside")


def _prior(faults: Faults, settings: Settings, ground: Ground) -> dict[str, Any]:
    """`weights` and `outside`, or `theta`; and what should be known of them, with the notes so far."""
    area = settings.area
    if area.evidence is not None and area.poc is None:
        return {"theta": _theta(faults, area.evidence, ground)}
    if area.poc is not None:
        found = _of_raster(faults, area.poc, area.outside, ground, area.polygon is not None)
    elif area.segments is not None:
        found = _of_segments(ground)
    elif area.last_known is not None:
        found = _of_rings(faults, settings, ground)
    else:
        found = (ground.inside, area.outside, 0.0)
    if found is None:
        return {}
    weights, outside, beyond = found
    if not weights.sum() > 0 or outside >= 1.0:
        key = next(key for key in ("poc", "segments", "last_known", "polygon") if getattr(area, key) is not None)
        came = "a search area came in which the person is nowhere"
        faults.add(f"area.{key}", came, "expected some probability within it")
        return {}
    notes = ground.notes
    if beyond > LEAST_TOLD:
        notes += (f"{beyond:.1%} of the probability lies beyond the search area, and counts as outside",)
    return {"weights": weights, "outside": outside, "notes": notes}


def _of_raster(
    faults: Faults, name: str, outside: float, ground: Ground, cut: bool
) -> tuple[Floats, float, float] | None:
    """A raster's mass on the grid, cut to what of each cell lies in the polygon where there is one."""
    from sooner.io.warped import is_within, mass_on

    frame = ground.frame
    found = brought(faults, "area.poc", name, lambda path: mass_on(path, frame.ground, frame.shape))
    if found is None:
        return None
    cut = cut and not is_within(faults.path.parent / name)
    weights = found.values * ground.inside if cut else found.values
    on_grid = float(found.values.sum())
    kept = (1.0 - found.outside) * float(weights.sum()) / on_grid if on_grid > 0 else 0.0
    return weights, outside + (1.0 - outside) * (1.0 - kept), (1.0 - outside) * (1.0 - kept)


def _of_segments(ground: Ground) -> tuple[Floats, float, float] | None:
    """Each segment's POC even over its ground; what of it lies beyond the area is outside."""
    from sooner.io.vectors import cover

    if not ground.sketch.segments:
        return None
    frame, total = ground.frame, 0.0
    weights = np.zeros(frame.shape)
    for _, polygon, poc in ground.sketch.segments:
        segment = frame.moved(polygon)
        segment = segment if segment.is_valid else segment.buffer(0)
        within = segment.intersection(ground.polygon)
        weights += (
            poc * cover(_surface(within), frame.shape, frame.ground.cell_m) * frame.ground.cell_m**2 / segment.area
        )
        total += poc
    on_map = min(float(weights.sum()), 1.0)
    return weights, 1.0 - on_map, max(total - on_map, 0.0)


def _surface(geometry: Any) -> Any:
    """Only the polygons of what two polygons have in common: they may touch in lines and points too."""
    import shapely

    parts = [part for part in shapely.get_parts(geometry) if part.geom_type == "Polygon"]
    return shapely.multipolygons(parts)


def _of_rings(faults: Faults, settings: Settings, ground: Ground) -> tuple[Floats, float, float] | None:
    from sooner.belief.rings import ring_poc
    from sooner.grid import Grid

    said, last = settings.area.last_known, ground.sketch.last_known
    if said is None or last is None or said.rings_m is None or said.quantiles is None:
        return None
    frame = ground.frame
    centre = frame.metres([[last[1], last[0]]])[0]
    try:
        rings = ring_poc(Grid(frame.shape, cell_m=frame.ground.cell_m), centre, said.rings_m, said.quantiles)
    except InvalidProblemError as error:
        came, _, expected = str(error).partition("; ")
        faults.add("area.last_known", came, expected)
        return None
    poc = rings if settings.area.polygon is None else rings * ground.inside
    return poc, 1.0 - float(poc.sum()), max(said.quantiles[-1] - float(poc.sum()), 0.0)


def _theta(faults: Faults, name: str, ground: Ground) -> Floats | None:
    """A raster of evidence; where drones may be beyond the search area, nobody is looked for there."""
    found = _mean(faults, "area.evidence", name, ground)
    if found is None:
        return None
    theta = _within(faults, "area.evidence", name, np.where(np.isnan(found.values), 0.0, found.values), 0.0, 1.0)
    return theta if theta is None or ground.flight_area is None else np.where(ground.inside > 0, theta, 0.0)


# ---------------------------------------------------------------- what looks see, what stands there


def _glimpse(faults: Faults, settings: Settings, ground: Ground) -> Floats | None:
    """P(detect) from rasters of it, of difficulty, or of classes; None where there is none, or a number."""
    sensor = settings.sensor
    if sensor.land_cover is not None:
        return class_glimpse(faults, settings, ground)
    if isinstance(sensor.glimpse, str):
        return _everywhere(faults, "sensor.glimpse", sensor.glimpse, ground, 1.0)
    if sensor.difficulty is None:
        return None
    levels = _everywhere(faults, "sensor.difficulty", sensor.difficulty, ground, np.inf)
    if levels is None:
        return None
    from sooner.io.warped import largest

    try:
        hardest = largest(faults.path.parent / sensor.difficulty)
    except DataFormatError:
        return None  # told where it was read
    return np.clip(1.0 - levels / (hardest + 1.0), 0.0, 1.0)


def _sweep_width(faults: Faults, settings: Settings, ground: Ground) -> float | Floats | None:
    said = settings.sensor.sweep_width_m
    return _everywhere(faults, "sensor.sweep_width_m", said, ground, np.inf) if isinstance(said, str) else said


def _stones(faults: Faults, settings: Settings, ground: Ground) -> NDArray[np.bool_] | None:
    """Cells of which a raster says that something stands on any part."""
    said = settings.area.obstacles
    if not isinstance(said, str) or is_drawn(said):
        return None
    found = _mean(faults, "area.obstacles", said, ground, whether=True)
    return None if found is None else np.nan_to_num(found.values) > 1e-6


def _everywhere(faults: Faults, key: str, name: str, ground: Ground, most: float) -> Floats | None:
    """A raster's mean over every cell of the area; beyond it, where it says nothing, what is near."""
    found = _mean(faults, key, name, ground)
    if found is None:
        return None
    missing = np.isnan(found.values)
    needed = missing & (ground.inside > 0)
    if needed.any():
        row, col = np.argwhere(needed)[0]
        came = f"{name} says nothing of {int(needed.sum())} cells of the area, the first at [{row}, {col}]"
        faults.add(key, came, "expected a raster that covers the area")
        return None
    return _within(faults, key, name, filled(found.values, missing), 0.0, most)


def _within(faults: Faults, key: str, name: str, values: Floats, low: float, high: float) -> Floats | None:
    wrong = ~np.isfinite(values) | (values < low - 1e-9) | (values > high + 1e-9)
    if wrong.any():
        row, col = np.argwhere(wrong)[0]
        least = f"at least {low:g}" if high == np.inf else f"in [{low:g}, {high:g}]"
        faults.add(
            key, f"{values[row, col]:g} came in {name}, at [{row}, {col}] of the grid", f"expected numbers {least}"
        )
        return None
    return np.clip(values, low, high)


def _mean(faults: Faults, key: str, name: str, ground: Ground, whether: bool = False) -> Warped | None:
    from sooner.io.warped import mean_on

    frame = ground.frame
    how: Callable[[Any], Warped] = lambda path: mean_on(path, frame.ground, frame.shape, whether)  # noqa: E731
    return brought(faults, key, name, how)
