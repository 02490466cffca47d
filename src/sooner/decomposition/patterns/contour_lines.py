"""Contour lines of a raster of heights, by marching triangles."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

__all__ = ["contour_lines"]


def contour_lines(
    heights: NDArray[np.float64], cell_m: float, level: float, origin: ArrayLike = (0.0, 0.0)
) -> list[NDArray[np.float64]]:
    """The lines on which a surface has one height; the surface is plane over the two halves of each square of cells.

    Parameters
    ----------
    heights : (H, W) float     at cells' centres, row 0 in the north; where one is NaN no line passes
    cell_m : float             metres
    level : float              the height
    origin : (2,) float        the centre of the south-west cell, metres

    Returns
    -------
    list of (n, 2) float       metres; a closed line ends where it begins. Corners within half a cell of a straight
                               line are left out

    Examples
    --------
    >>> hill = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
    >>> (ring,) = contour_lines(hill, 100.0, level=1.0)
    >>> bool(np.array_equal(ring[0], ring[-1])), ring.min(axis=0), ring.max(axis=0)
    (True, array([50., 50.]), array([150., 150.]))
    """
    segments = _segments(heights, level)
    if not len(segments):
        return []
    rows, cols = segments[..., 0], segments[..., 1]
    x, y = np.asarray(origin, float)
    places = np.stack([x + cols * cell_m, y + (heights.shape[0] - 1 - rows) * cell_m], axis=-1)
    merged = shapely.line_merge(shapely.multilinestrings(shapely.linestrings(places)))
    parts = shapely.simplify(shapely.get_parts(merged), cell_m / 2)
    return [shapely.get_coordinates(part) for part in parts]


def _segments(heights: NDArray[np.float64], level: float) -> NDArray[np.float64]:
    """(n, 2, 2): ends, as [row, col], of the line's part in each triangle that it crosses."""
    H, W = heights.shape
    above = heights > level
    cell = np.arange(H * W).reshape(H, W)
    nw, ne, sw, se = cell[:-1, :-1], cell[:-1, 1:], cell[1:, :-1], cell[1:, 1:]
    triangles = np.concatenate([np.stack(each, axis=-1).reshape(-1, 3) for each in ((nw, ne, sw), (ne, sw, se))])
    triangles = triangles[np.isfinite(heights.ravel()[triangles]).all(axis=1)]
    high = above.ravel()[triangles]
    crossed = high.any(axis=1) & ~high.all(axis=1)
    triangles, high = triangles[crossed], high[crossed]
    # the corner that stands alone on its side of the level, and the two others
    alone = np.argmax(high == (high.sum(axis=1) == 1)[:, None], axis=1)
    lone = triangles[np.arange(len(triangles)), alone]
    others = [triangles[np.arange(len(triangles)), (alone + k) % 3] for k in (1, 2)]
    ends = np.stack([_crossing(heights, level, lone, other) for other in others], axis=1)
    crossings: NDArray[np.float64] = ends[(ends[:, 0] != ends[:, 1]).any(axis=1)]
    return crossings


def _crossing(
    heights: NDArray[np.float64], level: float, a: NDArray[np.int64], b: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(n, 2): [row, col] where the level lies between two cells; the same digits from whichever side."""
    a, b = np.minimum(a, b), np.maximum(a, b)
    z = heights.ravel()
    share = ((level - z[a]) / (z[b] - z[a]))[:, None]
    ends = [np.stack(np.divmod(cell, heights.shape[1]), axis=-1).astype(float) for cell in (a, b)]
    place: NDArray[np.float64] = ends[0] + share * (ends[1] - ends[0])
    return place
