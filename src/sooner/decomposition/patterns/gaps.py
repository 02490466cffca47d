"""Gaps that tracks leave, and short detours that see them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.decomposition.patterns.lanes import narrowest, turned, turned_points
from sooner.decomposition.patterns.legs import Tracks, roomy
from sooner.decomposition.patterns.strips import strip_legs
from sooner.errors import InvalidProblemError

__all__ = ["gaps", "legs_along", "mended", "pieces_of"]

_CURVED = 32  # straight sides of a quarter of a disc; they lie inside it, by a part in three thousand at most
_SPECK = 1e-9  # of the squared radius: rounding
_ROUNDS = 100
_ALONG = 2  # rounds in which long gaps are flown along, before they are seen part by part
_WELL = 0.99  # of the radius


def gaps(ground: Any, tracks: Sequence[NDArray[np.float64]], radius: float) -> Any:
    """What of the ground no place of the tracks is within a radius of; discs are drawn a little too small.

    Examples
    --------
    >>> gaps(shapely.box(0, 0, 9, 2), [np.array([(1.0, 1.0), (5.0, 1.0)])], radius=2.0).area > 0
    True
    """
    swept = shapely.union_all(shapely.buffer([_line(track) for track in tracks], radius, quad_segs=_CURVED))
    return shapely.difference(ground, swept)


def mended(tracks: Sequence[NDArray[np.float64]], ground: Any, free: Any, radius: float) -> Tracks:
    """The tracks with detours from which the drone sees what they left.

    A gap is seen from one place, if there is one that has all of it in view, the one nearest to the tracks; or else
    from legs along it; or else part by part. The drone leaves a leg where it passes nearest and
    comes back there; where it cannot fly straight, the detour stands alone among the tracks.

    Parameters
    ----------
    tracks : sequence of (n, 2) float
    ground : (Multi)Polygon    what is to be seen; no place of it further than the radius from free ground
    free : (Multi)Polygon      where the drone may be
    radius : float             metres

    Returns
    -------
    tuple of (n, 2) float      the tracks, of which `gaps` finds none

    Raises
    ------
    InvalidProblemError        if gaps are left after a hundred rounds
    """
    out = list(tracks)
    left = ground
    for turn in range(_ROUNDS):
        left = gaps(left, out, radius)
        pieces = pieces_of(left, radius)
        if not pieces:
            return tuple(out)
        for piece in pieces:
            for detour in _detours(piece, out, free, radius, along=turn < _ALONG):
                _with_detour(out, detour, free)
    raise InvalidProblemError(f"gaps of {left.area:.3g} m2 could not be closed; expected ground of fewer corners")


def pieces_of(left: Any, radius: float) -> list[Any]:
    """The gaps one by one, without specks that come of rounding."""
    return [part for part in shapely.get_parts(left) if part.area > _SPECK * radius**2]


def legs_along(piece: Any, free: Any, radius: float) -> Tracks:
    """Legs that see a gap from along it; none where it can be seen from one place."""
    if _sees_all(piece, free, radius) is not None:
        return ()
    angle = narrowest(piece)
    legs = strip_legs(turned(piece, -angle), turned(free, -angle), radius, 2 * radius)
    return tuple(turned_points(leg, angle) for leg in legs)


def _detours(piece: Any, tracks: Sequence[NDArray[np.float64]], free: Any, radius: float, *, along: bool) -> Tracks:
    """(1, 2) or (2, 2) each: where to see a gap from, or at least its corner that is furthest from the tracks."""
    seen_from = _sees_all(piece, free, radius)
    legs = legs_along(piece, free, radius) if along and seen_from is None else ()
    if legs:
        return legs
    flown = shapely.union_all([_line(track) for track in tracks]) if tracks else piece.representative_point()
    if seen_from is not None:
        return (shapely.get_coordinates(shapely.shortest_line(seen_from, flown))[:1],)
    corners = shapely.points(shapely.get_coordinates(piece))
    furthest = corners[int(np.argmax(shapely.distance(corners, flown)))]
    return (shapely.get_coordinates(shapely.shortest_line(free, furthest))[:1],)


def _sees_all(piece: Any, free: Any, radius: float) -> Any | None:
    """Free ground that has all of a gap in view; None where there is none."""
    corners = shapely.points(shapely.get_coordinates(piece.convex_hull)[:-1])
    if np.hypot(*np.diff(np.reshape(piece.bounds, (2, 2)), axis=0)[0]) > 3 * radius:
        return None
    seen_from = free
    for disc in shapely.buffer(corners, _WELL * radius, quad_segs=8):
        seen_from = shapely.intersection(seen_from, disc)
        if seen_from.is_empty:
            return None
    return seen_from


def _with_detour(tracks: list[NDArray[np.float64]], detour: NDArray[np.float64], free: Any) -> None:
    """Put a detour into the track that passes nearest, or where it cannot be flown to straight, after it."""
    lines = np.array([_line(track) for track in tracks])
    nearest = int(np.argmin(shapely.distance(lines, shapely.points(detour[0])))) if tracks else -1
    alone = detour if len(detour) > 1 else np.repeat(detour, 2, axis=0)
    if not tracks:
        tracks.append(alone)
        return
    passed, _ = shapely.get_coordinates(shapely.shortest_line(lines[nearest], shapely.points(detour[0])))
    loop = np.concatenate([passed[None], detour, passed[None]])
    if not shapely.covers(roomy(free), shapely.linestrings(loop)):
        tracks.insert(nearest + 1, alone)
        return
    track = tracks[nearest]
    legs = shapely.linestrings(np.stack([track[:-1], track[1:]], axis=1))
    leg = int(np.argmin(shapely.distance(legs, shapely.points(passed))))
    if leg == len(track) - 2 and np.hypot(*(passed - track[-1])) < 1e-9:
        loop, leg = loop[1:-1], leg + 1
    elif leg == 0 and np.hypot(*(passed - track[0])) < 1e-9:
        loop = loop[1:]
        leg = -1
    tracks[nearest] = np.concatenate([track[: leg + 1], loop, track[leg + 1 :]])


def _line(track: NDArray[np.float64]) -> Any:
    return shapely.points(track[0]) if (track == track[0]).all() else shapely.linestrings(track)
