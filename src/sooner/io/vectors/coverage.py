"""Coverage: which share of each cell lies within a polygon, exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

__all__ = ["cover"]

_NEAR = 1e-9  # shares nearer to none or all are that, but for rounding


def cover(polygon: Any, shape: tuple[int, int], cell_m: float) -> NDArray[np.float64]:
    """(H, W) float: which share of each cell's ground lies within a polygon.

    Exact: shares times the area of a cell total the polygon's area on the grid.

    Parameters
    ----------
    polygon : Polygon or MultiPolygon   metres east and north of the south-west cell's centre
    shape : (int, int)                  rows and columns
    cell_m : float                      of a cell's side

    Examples
    --------
    >>> cover(shapely.box(0.0, 0.0, 10.0, 20.0), (3, 2), 10.0)
    array([[0.25, 0.25],
           [0.5 , 0.5 ],
           [0.25, 0.25]])
    """
    from sooner.io.vectors._coverage_kernels import right_of

    height, width = shape
    oriented = shapely.orient_polygons(polygon, exterior_cw=False)
    rings = [ring for part in shapely.get_parts(oriented) for ring in (part.exterior, *part.interiors)]
    if not rings:
        return np.zeros(shape)
    places, whose = shapely.get_coordinates(np.array(rings, dtype=object), return_index=True)
    x, y = places[:, 0] / cell_m + 0.5, height - 0.5 - places[:, 1] / cell_m
    points = np.column_stack([x, y])
    together = whose[1:] == whose[:-1]
    edges = np.ascontiguousarray(np.hstack([points[:-1], points[1:]])[together])
    shares = np.asarray(right_of(edges, height, width), np.float64)
    shares = np.where(shares < _NEAR, 0.0, np.where(shares > 1.0 - _NEAR, 1.0, shares))
    return shares
