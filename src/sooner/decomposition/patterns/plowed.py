"""Lanes flown in turns: there on one and back on the next, and on to the nearest ground that is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.decomposition.patterns.lanes import Lane, chains, lanes, turned, turned_points
from sooner.decomposition.patterns.legs import Tracks, checked_place, joined

__all__ = ["plowed"]

_MANY = 5000


def plowed(free: Any, spacing: float, angle: float, commence: ArrayLike | None = None) -> Tracks:
    """Parallel legs at an angle over all of the ground, one track spacing apart.

    The first is half a spacing from the side, and each ends half a spacing before the border does; what is shorter
    than one spacing is met in its middle.

    Parameters
    ----------
    free : (Multi)Polygon      metres
    spacing : float            metres, as `lanes`
    angle : float              of the legs, radians counter-clockwise from east
    commence : (2,) float      the corner nearest to it comes first; None for the first corner to the right, facing
                               along the angle

    Returns
    -------
    tuple of (n, 2) float      tracks in the order of flight

    Examples
    --------
    >>> import shapely
    >>> plowed(shapely.box(0, 0, 100, 40), spacing=20, angle=0.0)
    (array([[10., 10.],
           [90., 10.],
           [90., 30.],
           [10., 30.]]),)
    """
    ground = turned(free, -angle)
    begun = chains(lanes(ground, spacing))
    ways = [
        [_in_turns(chain[::step], east, spacing / 2) for step in (1, -1) for east in (True, False)] for chain in begun
    ]
    here = ways[0][0][0, 0] if commence is None else turned_points(checked_place("commence", commence), -angle)
    tracks = joined(_nearest_first(ways, here), ground)
    return tuple(turned_points(track, angle) for track in tracks)


def _in_turns(chain: Sequence[Lane], east: bool, inset: float) -> NDArray[np.float64]:
    """(n, 2, 2): from end to end of each lane of a chain, the first flown to the east or to the west."""
    west, east_end, north = np.array(chain).T
    short = np.minimum(inset, (east_end - west) / 2)
    ends = np.stack([west + short, east_end - short], axis=1)
    ends[int(east) :: 2] = ends[int(east) :: 2, ::-1]
    return np.stack([ends, np.stack([north, north], axis=1)], axis=2)


def _nearest_first(ways: list[list[NDArray[np.float64]]], here: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """One way over each chain, that which begins nearest to the end of the one before; of very many as they come."""
    if len(ways) > _MANY:
        return [lane for each in ways for lane in each[0]]
    starts = np.array([[way[0, 0] for way in each] for each in ways])
    flown = []
    for _ in ways:
        chain, way = np.unravel_index(np.argmin(np.hypot(*(starts - here).T).T), starts.shape[:2])
        flown += list(ways[chain][way])
        starts[chain] = np.inf
        here = flown[-1][-1]
    return flown
