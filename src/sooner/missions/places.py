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
from sooner.missions.settings import Place as OnGlobe
from sooner.missions.settings import Settings

__all__ = ["Place", "components", "places"]

Place = tuple[int, int]


def places(faults: Faults, settings: Settings, layers: Layers) -> list[tuple[Place | None, Place | None]]:
    """Start and end of every searcher; None where the file gives none, or a wrong one."""
    found = []
    for number, said in enumerate(settings.searcher):
        key = f"searcher[{number}]"
        if said.start is None:
            faults.add(f"{key}.start", "nothing came", "expected [row, col], or lat and lon")
        start, end = (_place(faults, f"{key}.{name}", getattr(said, name), layers) for name in ("start", "end"))
        found.append((start, end))
    return found


def _place(faults: Faults, key: str, said: Any, layers: Layers) -> Place | None:
    if layers.first is None or layers.shape is None:
        return None
    cell = _told(faults, key, said, layers.first) if isinstance(said, OnGlobe) else said
    if not isinstance(cell, list | tuple):
        return None
    row, col = cell
    told = f"[{row}, {col}]" if cell is said else f"lat {said.lat:g}, lon {said.lon:g}, which is [{row}, {col}],"
    height, width = layers.shape
    if not (0 <= row < height and 0 <= col < width):
        map_is = f"rows 0 to {height - 1} and columns 0 to {width - 1}"
        faults.add(key, f"{told} came", f"expected a cell of the map, which has {map_is}")
        return None
    if layers.obstacles is not None and layers.obstacles[row, col]:
        faults.add(key, f"{told} came, and an obstacle stands there", "expected a cell that can be entered")
        return None
    return row, col


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


def components(free: NDArray[np.bool_]) -> NDArray[np.int32]:
    """(H, W) int: numbers from 1 for the pieces of free ground between which nothing can fly; 0 on obstacles.

    A diagonal step needs both cells beside it, so what hangs together by steps hangs together by sides.
    """
    from scipy.ndimage import label

    pieces: NDArray[np.int32] = label(free)[0]
    return pieces
