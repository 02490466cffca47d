"""Finer cells for a swath: a cell much wider than what is in view says too little of where the person is found."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, floor, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.missions.layers import Layers
from sooner.missions.real_area import RealArea
from sooner.motion.pace import Terrain

__all__ = ["finer", "parts_for"]

MOST_PARTS = 8
MOST_CELLS = 2_000_000
SURE_PARTS, EFFORT_PARTS = 3.0, 2.0  # cells for each radius: where all in view is seen, and where effort falls off


def parts_for(radius_m: float, cell_m: float, cells: int, sure: bool) -> int:
    """Into how many parts each side of a cell is cut, as far as there is room.

    Parameters
    ----------
    cells : int             of the map
    sure : bool             whoever is in view is seen; else effort falls off towards the edge of what is in view

    Examples
    --------
    >>> parts_for(30.0, 24.0, 10_000, sure=True), parts_for(30.0, 5.0, 10_000, sure=True)
    (3, 1)
    """
    most = max(min(MOST_PARTS, floor(sqrt(MOST_CELLS / max(cells, 1)))), 1)
    return min(max(ceil((SURE_PARTS if sure else EFFORT_PARTS) * cell_m / radius_m - 1e-9), 1), most)


def finer(layers: Layers, parts: int) -> Layers:
    """The same layers over cells cut into `parts` x `parts`; weights are shared out evenly."""
    if parts == 1 or layers.shape is None or layers.cell_m is None:
        return layers

    def cut(values: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
        return None if values is None else np.repeat(np.repeat(values, parts, axis=0), parts, axis=1)

    stones = None if layers.obstacles is None else np.repeat(np.repeat(layers.obstacles, parts, axis=0), parts, axis=1)
    first = layers.first
    if first is not None:
        values = cut(first.values)
        assert values is not None
        first = replace(
            first, values=values, missing=None, cell_m=None if first.cell_m is None else layers.cell_m / parts
        )
    return replace(
        layers,
        shape=(layers.shape[0] * parts, layers.shape[1] * parts),
        weights=cut(layers.weights),
        theta=cut(layers.theta),
        difficulty=cut(layers.difficulty),
        glimpse=cut(layers.glimpse),
        obstacles=stones,
        cell_m=layers.cell_m / parts,
        first=first,
        sweep_width=cut(layers.sweep_width) if isinstance(layers.sweep_width, np.ndarray) else layers.sweep_width,
        area=None if layers.area is None else _finer_area(layers.area, parts),
    )


def _finer_area(area: RealArea, parts: int) -> RealArea:
    """The same area in the frame of the finer cells, whose south-west centre lies nearer to the corner."""
    import shapely

    side = area.ground.cell_m
    off = (side - side / parts) / 2

    def moved(shape: Any) -> Any:
        return shapely.transform(shape, lambda points: points + off)

    ground = replace(area.ground, side=area.ground.side / parts, cell_m=side / parts)
    shape = (area.shape[0] * parts, area.shape[1] * parts)
    heights = None
    if area.elevation is not None:
        centres = Grid(shape, "square8", side / parts).centres_m - off
        heights = Terrain(area.elevation, side).heights_at(centres).reshape(shape)
    points = {title: (east + off, north + off) for title, (east, north) in area.points.items()}
    return replace(
        area,
        polygon=moved(area.polygon),
        flight_area=None if area.flight_area is None else moved(area.flight_area),
        no_fly=moved(area.no_fly),
        points=points,
        elevation=heights,
        ground=ground,
        shape=shape,
    )
