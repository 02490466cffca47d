"""Starts and ends: cells of the map that can be entered."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.missions.faults import Faults
from sooner.missions.layers import Layers
from sooner.missions.settings import Settings

__all__ = ["Place", "components", "places"]

Place = tuple[int, int]


def places(faults: Faults, settings: Settings, layers: Layers) -> list[tuple[Place | None, Place | None]]:
    """Start and end of every searcher; None where the file gives none, or a wrong one."""
    found = []
    for number, said in enumerate(settings.searcher):
        key = f"searcher[{number}]"
        if said.start is None:
            faults.add(f"{key}.start", "nothing came", "expected [row, col]")
        start, end = (_place(faults, f"{key}.{name}", getattr(said, name), layers) for name in ("start", "end"))
        found.append((start, end))
    return found


def _place(faults: Faults, key: str, said: Any, layers: Layers) -> Place | None:
    if not isinstance(said, list) or layers.shape is None:
        return None
    row, col = said
    height, width = layers.shape
    if not (0 <= row < height and 0 <= col < width):
        map_is = f"rows 0 to {height - 1} and columns 0 to {width - 1}"
        faults.add(key, f"[{row}, {col}] came", f"expected a cell of the map, which has {map_is}")
        return None
    if layers.obstacles is not None and layers.obstacles[row, col]:
        faults.add(key, f"[{row}, {col}] came, and an obstacle stands there", "expected a cell that can be entered")
        return None
    return row, col


def components(free: NDArray[np.bool_]) -> NDArray[np.int32]:
    """(H, W) int: numbers from 1 for the pieces of free ground between which nothing can fly; 0 on obstacles.

    A diagonal step needs both cells beside it, so what hangs together by steps hangs together by sides.
    """
    from scipy.ndimage import label

    pieces: NDArray[np.int32] = label(free)[0]
    return pieces
