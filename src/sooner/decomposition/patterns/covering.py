"""Coverage without gaps: a polygon of which no place is left unseen, for those who must say that it was searched."""

from __future__ import annotations

from dataclasses import dataclass
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
        points = np.concatenate(self.tracks) if self.tracks else np.zeros((0, 2))
        return float(np.hypot(*np.diff(points, axis=0).T).sum())


def covering(polygon: Any, radius: float, overlap: float = 0.0, free: Any = None) -> Covering:
    """Tracks from which a disc sees every place of a polygon that can be seen from free ground.

    Lanes in strips, 2 R (1 - overlap) apart; round the border first where that is shorter; then short detours to
    what is left at borders and corners. Of several angles of the lanes the shortest is kept.

    Parameters
    ----------
    polygon : (Multi)Polygon   what must be seen, metres
    radius : float             R, metres to which the drone sees
    overlap : float            in [0, 0.9]: the share of each swath that the next one sees as well
    free : (Multi)Polygon      where the drone may be; None for the polygon

    Returns
    -------
    Covering                   the tracks, and what they cannot see

    Raises
    ------
    InvalidProblemError        if the ground is none, a number makes no sense, or nothing of the polygon can be seen

    Notes
    -----
    What could be seen only from further than 0.995 R counts as out of sight.

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
    ground = polygon.intersection(free.buffer(radius * (1 - _SEEN)))
    ground = shapely.multipolygons([part for part in shapely.get_parts(ground) if part.geom_type == "Polygon"])
    if ground.area <= 0:
        raise InvalidProblemError(f"nothing of the polygon lies within {radius} m of free ground; expected some")
    unseen = polygon.difference(free.buffer(radius * (1 - _SEEN)))
    tries = [
        _laned(ground, free, radius, overlap, angle, rim)
        for angle in _angles(ground)
        for rim in _rims(ground, free, radius)
    ]
    tries.sort(key=lambda each: Covering(each, unseen).length_m)
    mends = [mended(each, ground, free, radius * (1 - _SURE)) for each in tries[:4]]
    return min((Covering(each, unseen) for each in mends), key=lambda each: each.length_m)


def _angles(ground: Any) -> list[float]:
    """Angles worth trying: the fewest lanes first."""
    best = narrowest(ground)
    return [best + k * np.pi / 6 for k in range(6)]


def _rims(ground: Any, free: Any, radius: float) -> list[Tracks]:
    """Ways round the border to begin with: none, or just near enough to see square corners, or straight sides."""
    both = ground.intersection(free)
    border = _border(ground, free, radius)
    rims: list[Tracks] = [border]
    for inside in (0.7 * radius, 0.97 * radius):
        rings = shapely.get_parts(shapely.boundary(both.buffer(-inside, join_style="mitre")))
        lines = [
            line.simplify(0.02 * radius) for line in shapely.get_parts(shapely.line_merge(shapely.union_all(rings)))
        ]
        free_lines = [line for line in lines if line.length > 0 and free.buffer(1e-6).covers(line)]
        if free_lines:
            rims.append((*border, *(shapely.get_coordinates(line) for line in free_lines)))
    return rims


def _border(ground: Any, free: Any, radius: float) -> Tracks:
    """Stretches of the free ground's border, from which alone the drone sees ground far beyond it."""
    beyond = ground.difference(free.buffer(radius / 2))
    if beyond.is_empty:
        return ()
    near = shapely.intersection(shapely.boundary(free), beyond.buffer(1.01 * radius))
    lines = [part for part in shapely.get_parts(near) if part.geom_type == "LineString" and part.length > 0]
    merged = shapely.get_parts(shapely.line_merge(shapely.multilinestrings(lines))) if lines else []
    return tuple(shapely.get_coordinates(line) for line in merged)


def _laned(ground: Any, free: Any, radius: float, overlap: float, angle: float, rim: Tracks) -> Tracks:
    """A way round, and lanes over what it leaves, in the order of a short tour."""
    sure = radius * (1 - 2.5 * _SURE)
    left = ground
    if rim:
        swept = shapely.buffer([shapely.linestrings(ring) for ring in rim], sure * (1 - overlap), quad_segs=32)
        left = ground.difference(shapely.union_all(swept))
    legs = strip_legs(turned(left, -angle), turned(free, -angle), sure, 2 * sure * (1 - overlap))
    stretches = [*rim, *(turned_points(leg, angle) for leg in legs)]
    tracks = joined(toured(stretches, free, 6 * radius), free)
    # long gaps, along slanting borders, are worth legs of their own in the order
    long = [leg for gap in pieces_of(gaps(ground, tracks, sure), sure) for leg in legs_along(gap, free, sure)]
    return joined(toured([*stretches, *long], free, 6 * radius), free) if long else tracks
