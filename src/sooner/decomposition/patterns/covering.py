"""Coverage without gaps: a polygon of which no place is left unseen, for those who must say that it was searched."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import shapely

from sooner.decomposition.patterns.gaps import gaps, legs_along, mended, pieces_of
from sooner.decomposition.patterns.lanes import narrowest, turned, turned_points
from sooner.decomposition.patterns.legs import Tracks, checked_ground, checked_number, joined
from sooner.decomposition.patterns.strips import strip_legs
from sooner.decomposition.patterns.tour import toured
from sooner.errors import InvalidProblemError

__all__ = ["Covering", "covering"]

_SURE = 1e-3  # of the radius, that is kept in hand so that rounding leaves no gap
_CLOSER = (1.0, 0.95, 0.9)  # strips that are narrower than they must be let their lanes end earlier
_MANY_CORNERS = 1000
_ANGLES = 18  # of half a turn, by which lanes are turned
_TURNS = (0, 9, 5, 14, 2, 7, 11, 16, 1, 3, 4, 6, 8, 10, 12, 13, 15, 17)  # the most unlike first
_EFFORT = 100_000  # squared legs of all tries, after which no more are made
_SIMPLER = (0.01, 0.03, 0.1)  # radii by which borders are drawn simpler, one after the other
_MENDED = 8  # of the tries, the best, whose gaps are closed before the best is chosen
_SEEN = 5e-3  # of the radius: what can only be seen from less near than that counts as out of sight


@dataclass(frozen=True)
class Covering:
    """Tracks that leave nothing of a polygon unseen but what cannot be seen.

    Parameters
    ----------
    tracks : tuple of (n, 2) float    metres, in the order of flight
    unseen : (Multi)Polygon           what of the polygon no free ground has in view; empty where there is none
    """

    tracks: Tracks
    unseen: Any

    @property
    def length_m(self) -> float:
        """Metres along the tracks, and straight from the end of each to the next."""
        return _cost(self.tracks, 0.0)


def covering(polygon: Any, radius: float, overlap: float = 0.0, free: Any = None, *, turn_m: float = 0.0) -> Covering:
    """Tracks from which a disc sees every place of a polygon that can be seen from free ground.

    Lanes in strips, at most 2 R (1 - overlap) apart; then short detours to what they leave at borders and corners. Of
    several angles of the lanes the best is kept.

    Parameters
    ----------
    polygon : (Multi)Polygon   what must be seen, metres
    radius : float             R, metres to which the drone sees
    overlap : float            in [0, 0.9]: the share of each swath that the next one sees as well
    free : (Multi)Polygon      where the drone may be; None for the polygon

    turn_m : float             metres that might be flown instead of each turn; the shortest tracks turn often

    Returns
    -------
    Covering                   the tracks, and what they cannot see

    Raises
    ------
    InvalidProblemError        if the ground is none, a number makes no sense, or nothing of the polygon can be seen

    Notes
    -----
    What could be seen only from further than 0.995 R counts as out of sight. Borders of very many corners are drawn
    simpler, by a quarter of the radius at most: more than the polygon is seen, from less than the free ground.

    Examples
    --------
    >>> field = shapely.box(0, 0, 2000, 1000)
    >>> found = covering(field, radius=25.0)
    >>> found.unseen.is_empty, found.length_m * 2 * 25 < 1.08 * field.area
    (True, True)
    """
    polygon, radius = checked_ground(polygon, "polygon"), checked_number("radius", radius)
    free = polygon if free is None else checked_ground(free)
    if not 0 <= overlap <= 0.9:
        raise InvalidProblemError(f"an overlap of {overlap} came; expected 0 to 0.9")
    if not (np.isfinite(turn_m) and turn_m >= 0):
        raise InvalidProblemError(f"{turn_m} m for a turn came; expected a number of at least 0")
    free = _inner(free, radius)
    in_sight = free.buffer(radius * (1 - _SEEN))
    ground = _outer(polygon, radius).intersection(in_sight)
    ground = shapely.multipolygons([part for part in shapely.get_parts(ground) if part.geom_type == "Polygon"])
    if ground.area <= 0:
        raise InvalidProblemError(f"nothing of the polygon lies within {radius} m of free ground; expected some")
    unseen = polygon.difference(in_sight)
    border = _border(ground, free, radius)
    spacing = 2 * radius * (1 - 2.5 * _SURE) * (1 - overlap)
    tries, effort = [], 0
    for closer, angle in product(_CLOSER, [narrowest(ground) + k * np.pi / _ANGLES for k in _TURNS]):
        tracks, legs = _laned(ground, free, radius, spacing * closer, angle, border)
        tries.append(tracks)
        effort += legs**2  # as a tour of them takes
        if effort > _EFFORT:
            break
    tries.sort(key=lambda tracks: _cost(tracks, turn_m))
    few = max(2, min(_MENDED, len(tries) // 4))
    mends = [mended(tracks, ground, free, radius * (1 - _SURE)) for tracks in tries[:few]]
    return Covering(min(mends, key=lambda tracks: _cost(tracks, turn_m)), unseen)


def _cost(tracks: Tracks, turn_m: float) -> float:
    """Metres along tracks and straight between them, and so many for each turn."""
    points = np.concatenate([*tracks, np.zeros((0, 2))])
    return float(np.hypot(*np.diff(points, axis=0).T).sum()) + turn_m * len(points)


def _outer(polygon: Any, radius: float) -> Any:
    """Ground that holds the polygon, of fewer corners."""
    for tolerance in _SIMPLER:
        if shapely.get_num_coordinates(polygon) <= _MANY_CORNERS:
            break
        away = tolerance * radius
        polygon = polygon.buffer(2 * away, join_style="mitre").simplify(away)
    return polygon


def _inner(free: Any, radius: float) -> Any:
    """Ground that the free ground holds, of fewer corners; as it is where nothing would be left of it."""
    for tolerance in _SIMPLER:
        if shapely.get_num_coordinates(free) <= _MANY_CORNERS:
            break
        away = tolerance * radius
        simpler = free.buffer(-2 * away, join_style="mitre").simplify(away)
        if simpler.is_empty:
            break
        free = simpler
    return free


def _border(ground: Any, free: Any, radius: float) -> Tracks:
    """Stretches of the free ground's border, from which alone the drone sees ground far beyond it."""
    beyond = ground.difference(free.buffer(radius / 2))
    if beyond.is_empty:
        return ()
    near = shapely.intersection(shapely.boundary(free), beyond.buffer(1.01 * radius))
    lines = [part for part in shapely.get_parts(near) if part.geom_type == "LineString" and part.length > 0]
    merged = shapely.get_parts(shapely.line_merge(shapely.multilinestrings(lines))) if lines else []
    return tuple(shapely.get_coordinates(line) for line in merged)


def _laned(ground: Any, free: Any, radius: float, spacing: float, angle: float, border: Tracks) -> tuple[Tracks, int]:
    """Stretches of border, and lanes over what they leave, in the order of a short tour; and how many they are."""
    sure = radius * (1 - 2.5 * _SURE)
    left = gaps(ground, border, sure) if border else ground
    legs = strip_legs(turned(left, -angle), turned(free, -angle), sure, spacing)
    stretches = [*border, *(turned_points(leg, angle) for leg in legs)]
    tracks = joined(toured(stretches, free, 6 * radius), free)
    # long gaps, along slanting borders, are worth legs of their own in the order
    long = [leg for gap in pieces_of(gaps(ground, tracks, sure), sure) for leg in legs_along(gap, free, sure)]
    stretches += long
    return joined(toured(stretches, free, 6 * radius), free) if long else tracks, len(stretches)
