"""Lanes: parallel legs across ground, and the chains in which one goes on as the next."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import affinity

from sooner.decomposition.patterns.legs import MAX_LEGS
from sooner.errors import InvalidProblemError

__all__ = ["Lane", "chains", "lanes", "narrowest", "turned", "turned_points"]

_MANY_SIDES = 500


class Lane(NamedTuple):
    """One leg from west to east at one height, in the frame turned so that legs run east."""

    west: float
    east: float
    north: float


def lanes(ground: Any, spacing: float) -> list[list[Lane]]:
    """Where lines from west to east lie in the ground, from south to north.

    The fewest lines that lie no further apart than the spacing, each in the middle of an equal share of the height:
    the first and last half a spacing from the ground's ends, as the manual has them.

    Parameters
    ----------
    ground : (Multi)Polygon    metres
    spacing : float            metres

    Returns
    -------
    list of lists of Lane      for each line its parts from west to east

    Examples
    --------
    >>> lanes(shapely.box(0, 0, 100, 40) - shapely.box(30, 25, 40, 40), spacing=20)  # doctest: +NORMALIZE_WHITESPACE
    [[Lane(west=0.0, east=100.0, north=10.0)],
     [Lane(west=0.0, east=30.0, north=30.0), Lane(west=40.0, east=100.0, north=30.0)]]
    """
    west, south, east, north = ground.bounds
    count = max(1, np.ceil((north - south) / spacing - 1e-9))
    if not count <= MAX_LEGS:
        raise InvalidProblemError(f"{count:.0f} lanes would come of a track spacing of {spacing} m; expected fewer")
    heights = south + (np.arange(int(count)) + 0.5) * (north - south) / count
    across = np.stack([np.stack([np.full_like(heights, x), heights], axis=1) for x in (west - 1, east + 1)], axis=1)
    shapely.prepare(ground)
    parts = shapely.intersection(shapely.linestrings(across), ground)
    found = [_parts(part, float(height)) for part, height in zip(parts, heights, strict=True)]
    if sum(map(len, found)) > MAX_LEGS:
        raise InvalidProblemError(f"more than {MAX_LEGS} lanes came of a track spacing of {spacing} m; expected fewer")
    return found


def chains(lines: Sequence[Sequence[Lane]]) -> list[list[Lane]]:
    """Lanes that go on as the next: each touches one other only, to the north of it; where ground parts, a chain ends.

    This is the boustrophedon decomposition, cut at lanes: each chain can be plowed in turns.
    """
    begun: list[list[Lane]] = []
    south: Sequence[Lane] = ()
    chain_of: list[list[Lane]] = []
    for north in lines:
        below, above = _beside(north, south), _beside(south, north)
        now: list[list[Lane]] = []
        for lane, touched in zip(north, below, strict=True):
            goes_on = len(touched) == 1 and len(above[touched[0]]) == 1
            chain = chain_of[touched[0]] if goes_on else []
            if not goes_on:
                begun.append(chain)
            chain.append(lane)
            now.append(chain)
        south, chain_of = north, now
    return begun


def narrowest(ground: Any) -> float:
    """The angle, in [0, pi), of legs across the direction in which ground is narrowest: the fewest legs.

    One side of the convex hull lies along it.

    Examples
    --------
    >>> narrowest(shapely.box(0, 0, 10, 30)) == np.pi / 2
    True
    """
    hull = ground.convex_hull
    corners = shapely.get_coordinates(hull)
    if len(corners) > _MANY_SIDES:
        corners = shapely.get_coordinates(hull.simplify(np.hypot(*np.ptp(corners, axis=0)) / 1000))
    sides = np.diff(corners, axis=0)
    angles = np.unique(np.mod(np.arctan2(sides[:, 1], sides[:, 0]), np.pi))
    across = np.stack([-np.sin(angles), np.cos(angles)])
    widths = np.array([np.ptp(corners @ across[:, k]) for k in range(len(angles))])
    # sides that are parallel have one width but for rounding: the first of them
    return float(angles[np.argmax(widths <= widths.min() * (1 + 1e-9))])


def turned(ground: Any, angle: float) -> Any:
    """The ground turned counter-clockwise about the origin by an angle in radians."""
    return affinity.rotate(ground, angle, origin=(0, 0), use_radians=True)


def turned_points(points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """(n, 2): places turned counter-clockwise about the origin by an angle in radians."""
    c, s = np.cos(angle), np.sin(angle)
    out: NDArray[np.float64] = points @ np.array([(c, s), (-s, c)])
    return out


def _parts(part: Any, height: float) -> list[Lane]:
    found = [shapely.get_coordinates(each)[:, 0] for each in shapely.get_parts(part) if each.length > 0]
    return sorted(Lane(float(xs.min()), float(xs.max()), height) for xs in found)


def _beside(lanes: Sequence[Lane], others: Sequence[Lane]) -> list[range]:
    """For each lane, which of the others, which are in order and apart, share some of its width."""
    wests, easts = [other.west for other in others], [other.east for other in others]
    return [range(bisect_right(easts, lane.west), bisect_left(wests, lane.east)) for lane in lanes]
