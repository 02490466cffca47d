"""Legs on ground: what of a track lies in the free ground, and what can be flown on without a way around."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = [
    "MAX_LEGS",
    "Tracks",
    "checked_angle",
    "checked_ground",
    "checked_number",
    "checked_place",
    "clipped",
    "joined",
]

MAX_LEGS = 100_000
_MAX_VERTICES = 100_000
_SLACK_M = 1e-6

Tracks = tuple[NDArray[np.float64], ...]
"""(n, 2) metres each: stretches to be flown in this order, one by one, each of them inside the free ground. Where
one place is enough, a stretch is that place, twice."""


def clipped(track: ArrayLike, free: Any) -> Tracks:
    """What of a track lies in the free ground, leg by leg; it may cross itself.

    Parameters
    ----------
    track : (n, 2) float       metres
    free : (Multi)Polygon      where the drone may be

    Returns
    -------
    tuple of (m, 2) float      stretches in the order of the track

    Examples
    --------
    >>> lake = shapely.box(4, -1, 6, 1)
    >>> clipped([(0, 0), (9, 0), (9, 3)], shapely.box(0, -5, 10, 5) - lake)
    (array([[0., 0.],
           [4., 0.]]), array([[6., 0.],
           [9., 0.],
           [9., 3.]]))
    """
    points = np.asarray(track, float)
    legs = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    shapely.prepare(free)
    inside, crossing = shapely.covers(free, legs), shapely.intersects(free, legs)
    out: list[list[NDArray[np.float64]]] = []
    for k in np.flatnonzero(crossing):
        a, b = points[k : k + 2]
        for piece in [np.stack([a, b])] if inside[k] else _pieces(legs[k], free, a):
            if out and np.array_equal(out[-1][-1], piece[0]):
                out[-1].append(piece[1])
            else:
                out.append([piece[0], piece[1]])
    return tuple(np.array(stretch) for stretch in out)


def joined(tracks: Iterable[NDArray[np.float64]], free: Any) -> Tracks:
    """The same tracks, made one wherever the straight leg from the end of one to the next lies in the free ground.

    Examples
    --------
    >>> over, back = np.array([(0.0, 0.0), (9.0, 0.0)]), np.array([(9.0, 2.0), (0.0, 2.0)])
    >>> [track.tolist() for track in joined([over, back], shapely.box(0, 0, 9, 9))]
    [[[0.0, 0.0], [9.0, 0.0], [9.0, 2.0], [0.0, 2.0]]]
    """
    tracks = list(tracks)
    if not tracks:
        return ()
    between = np.array([(a[-1], b[0]) for a, b in pairwise(tracks)]).reshape(-1, 2, 2)
    clear = shapely.covers(roomy(free), shapely.linestrings(between))
    out = [[tracks[0]]]
    for track, goes_on in zip(tracks[1:], clear, strict=True):
        if goes_on:
            out[-1].append(track)
        else:
            out.append([track])
    return tuple(_without_repeats(np.concatenate(parts)) for parts in out)


@lru_cache(maxsize=8)
def roomy(free: Any) -> Any:
    """The ground and a hair more, prepared: ends of clipped legs lie on the border but for rounding."""
    out = free.buffer(_SLACK_M, join_style="mitre")
    shapely.prepare(out)
    return out


def checked_ground(free: Any, name: str = "free") -> Any:
    """The ground, refused unless it is a valid (Multi)Polygon of some area with finite corners, not too many."""
    kind = getattr(free, "geom_type", type(free).__name__)
    if kind not in ("Polygon", "MultiPolygon") or free.is_empty:
        raise InvalidProblemError(f"{name}: {kind} came; expected a polygon or several that are not empty")
    corners = shapely.get_coordinates(free)
    if len(corners) > _MAX_VERTICES:
        raise InvalidProblemError(f"{name}: {len(corners)} corners came; expected at most {_MAX_VERTICES}")
    if not np.isfinite(corners).all():
        raise InvalidProblemError(f"{name}: a corner that is not a number came; expected metres")
    if not free.is_valid or free.area <= 0:
        raise InvalidProblemError(f"{name}: {shapely.is_valid_reason(free)}; expected borders that do not cross")
    return free


def checked_number(name: str, value: float, lowest: float = 0.0, unit: str = " m") -> float:
    """The number, refused unless it is finite and above the lowest."""
    if not (np.isfinite(value) and value > lowest):
        raise InvalidProblemError(f"a {name} of {value}{unit} came; expected a number above {lowest:g}")
    return float(value)


def checked_angle(angle: float) -> float:
    """The angle in radians, refused unless it is finite."""
    if not np.isfinite(angle):
        raise InvalidProblemError(f"an angle of {angle} came; expected radians")
    return float(angle)


def checked_place(name: str, place: ArrayLike) -> NDArray[np.float64]:
    """(2,): the place, refused unless it is two finite numbers."""
    point = np.asarray(place, float)
    if point.shape != (2,) or not np.isfinite(point).all():
        raise InvalidProblemError(f"{name}: {place!r} came; expected metres east and north")
    return point


def _pieces(leg: Any, free: Any, start: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """(2, 2) each: the parts of one leg in the ground, from its start."""
    parts = shapely.get_parts(shapely.intersection(leg, free))
    ends = [
        shapely.get_coordinates(part)[[0, -1]] for part in parts if part.geom_type == "LineString" and part.length > 0
    ]
    # an intersection keeps no direction
    ends = [pair if np.hypot(*(pair[0] - start)) <= np.hypot(*(pair[1] - start)) else pair[::-1] for pair in ends]
    return sorted(ends, key=lambda pair: float(np.hypot(*(pair[0] - start))))


def _without_repeats(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same track without places at which it would stay."""
    kept: NDArray[np.float64] = points[np.append(True, np.hypot(*np.diff(points, axis=0).T) > _SLACK_M)]
    return kept if len(kept) > 1 else points[:2]
