"""The rasters of a mission, read, checked, and laid over one another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError
from sooner.io import Raster, read_raster
from sooner.missions.area_layers import lies_on_globe
from sooner.missions.drawings import is_drawn
from sooner.missions.faults import Faults
from sooner.missions.land_cover import check_land_cover
from sooner.missions.layers_on_ground import drawn_beside, layers_on_ground
from sooner.missions.real_area import RealArea
from sooner.missions.settings import Settings

__all__ = ["Layers", "read_glimpse"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Layers:
    """What could be read of the rasters of a mission; None where there is none, or where it is wrong.

    Parameters
    ----------
    shape : (int, int)              of the map
    weights, theta : (H, W) float   `area.poc` or `area.evidence`
    difficulty, glimpse : (H, W) float
    obstacles : (H, W) bool
    cell_m : float                  metres between cell centres
    first : Raster                  the raster on whose cells all others lie, with its place on the globe
    outside : float                 probability that the person is not on this map, or beyond its polygon
    sweep_width : float or (H, W)   `sensor.sweep_width_m`
    area : RealArea                 the area on the ground, where it is drawn
    notes : tuple of str            what the user should know of how they were laid out
    """

    shape: tuple[int, int] | None = None
    weights: Floats | None = None
    theta: Floats | None = None
    difficulty: Floats | None = None
    glimpse: Floats | None = None
    obstacles: NDArray[np.bool_] | None = None
    cell_m: float | None = None
    first: Raster | None = None
    outside: float = 0.0
    sweep_width: float | Floats | None = None
    area: RealArea | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def read(cls, faults: Faults, settings: Settings) -> Layers:
        """Read them all; what is wrong is added to the faults."""
        check_land_cover(faults, settings)
        if lies_on_globe(faults, settings):
            return cls(**layers_on_ground(faults, settings))
        area, sensor = settings.area, settings.sensor
        key, name = ("area.evidence", area.evidence) if area.poc is None else ("area.poc", area.poc)
        first = _raster(faults, key, name)
        like = None if first is None else (name, first)
        difficulty = _raster(faults, "sensor.difficulty", sensor.difficulty, like)
        named = sensor.glimpse if isinstance(sensor.glimpse, str) else None
        glimpse = _raster(faults, "sensor.glimpse", named, like)
        stones = area.obstacles if isinstance(area.obstacles, str) and not is_drawn(area.obstacles) else None
        obstacles = _raster(faults, "area.obstacles", stones, like)
        widths = sensor.sweep_width_m if isinstance(sensor.sweep_width_m, str) else None
        width = _raster(faults, "sensor.sweep_width_m", widths, like)
        read = cls(
            None if first is None else (first.values.shape[0], first.values.shape[1]),
            _weights(faults, first) if area.poc is not None else None,
            _numbers(faults, key, first, 0.0, 1.0, missing=0.0) if area.poc is None else None,
            _numbers(faults, "sensor.difficulty", difficulty, 0.0, np.inf, missing=None),
            _numbers(faults, "sensor.glimpse", glimpse, 0.0, 1.0, missing=None),
            _obstacles(faults, obstacles, first),
            _cell_m(faults, settings, first),
            first,
            area.outside,
            _numbers(faults, "sensor.sweep_width_m", width, 0.0, np.inf, missing=None)
            if widths is not None
            else sensor.sweep_width_m,  # type: ignore[arg-type]  # a number, as it is no name
        )
        return replace(read, **drawn_beside(faults, settings, first, read.obstacles))


def read_glimpse(faults: Faults, name: str, shape: tuple[int, int], map_name: str) -> Floats | None:
    """(H, W) float: the raster that `sensor.glimpse` names, over a map that is no raster; None where it is wrong."""
    raster = _raster(faults, "sensor.glimpse", name)
    if raster is None or raster.values.shape == shape:
        return _numbers(faults, "sensor.glimpse", raster, 0.0, 1.0, missing=None)
    came = "{} x {} cells came in {}".format(*raster.values.shape, name)
    faults.add("sensor.glimpse", came, "expected {} x {} as in {}".format(*shape, map_name))
    return None


def _raster(faults: Faults, key: str, name: str | None, like: tuple[Any, Raster] | None = None) -> Raster | None:
    if name is None:
        return None
    try:
        raster = read_raster(faults.path.parent / name)
    except DataFormatError as error:
        for fault in error.faults:
            where = f", {fault.key}" if fault.key else ""
            faults.add(key, f"{fault.file}{where}: {fault.came}", fault.expected)
        return None
    if like is not None:
        _check_place(faults, key, name, raster, *like)
    return raster


def _check_place(faults: Faults, key: str, name: str, raster: Raster, first_name: str, first: Raster) -> None:
    if raster.values.shape != first.values.shape:
        came = "{} x {} cells came in {}".format(*raster.values.shape, name)
        faults.once(key, came, "expected {} x {} as in {}".format(*first.values.shape, first_name))
    elif raster.corner is not None and first.corner is not None and not _matches(raster, first):
        came = f"{name} lies at {raster.corner} in {raster.crs} with cells of {raster.cell_m} m"
        expected = f"expected {first.corner} in {first.crs} with cells of {first.cell_m} m, as {first_name}"
        faults.add(key, came, expected)


def _matches(one: Raster, other: Raster) -> bool:
    if one.crs != other.crs or one.corner is None or other.corner is None or not one.cell_m or not other.cell_m:
        return False
    near = 0.01 * other.cell_m
    apart = max(abs(a - b) for a, b in zip(one.corner, other.corner, strict=True))
    return apart <= near and abs(one.cell_m - other.cell_m) * max(one.values.shape) <= 10 * near


def _numbers(
    faults: Faults, key: str, raster: Raster | None, low: float, high: float, missing: float | None
) -> Floats | None:
    """Values within [low, high]; "no data" counts as `missing`."""
    if raster is None:
        return None
    values = raster.values
    if raster.missing is not None and missing is not None:
        values = np.where(raster.missing, missing, values)
    elif raster.missing is not None:
        faults.add(key, f'{int(raster.missing.sum())} cells of "no data" came', "expected a number in every cell")
        return None
    least = f"at least {low:g}" if high == np.inf else f"in [{low:g}, {high:g}]"
    broken = ~np.isfinite(values)
    beyond = ~broken & ((values < low) | (values > high))
    came = [_first(values, bad, what) for bad, what in ((broken, "not finite"), (beyond, "out of range")) if bad.any()]
    if came:
        faults.add(key, "; ".join(came), f"expected finite numbers {least}")
        return None
    return values


def _first(values: Floats, bad: NDArray[np.bool_], what: str) -> str:
    row, col = np.unravel_index(int(np.argmax(bad)), bad.shape)
    count = int(bad.sum())
    return f"{count} value{'s are' if count > 1 else ' is'} {what}, the first {values[row, col]:g} at [{row}, {col}]"


def _weights(faults: Faults, raster: Raster | None) -> Floats | None:
    weights = _numbers(faults, "area.poc", raster, 0.0, np.inf, missing=0.0)
    if weights is not None and not weights.any():
        faults.add("area.poc", "every weight is zero", "expected some cell where the person may be")
        return None
    return weights


def _obstacles(faults: Faults, raster: Raster | None, first: Raster | None) -> NDArray[np.bool_] | None:
    stones = _numbers(faults, "area.obstacles", raster, -np.inf, np.inf, missing=0.0)
    if stones is None or "area.obstacles" in faults.wrong or first is None:
        return None
    if (stones != 0).all():
        faults.once("area.obstacles", "an obstacle came in every cell", "expected some cells that can be entered")
        return None
    return np.asarray(stones != 0)


def _cell_m(faults: Faults, settings: Settings, first: Raster | None) -> float | None:
    said = settings.area.cell_m
    found = None if first is None else first.cell_m
    if said is not None and found is not None and abs(said - found) > 0.01 * found:
        faults.add("area.cell_m", f"{said:g} m came", f"expected {found:g} m, as the raster's georeference says")
    return said if found is None else found
