"""The expanding square search (SS) [IAMSAR2019, vol. II, fig. 5-2; vol. III, p. 12-10]."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.decomposition.patterns.legs import (
    MAX_LEGS,
    Tracks,
    checked_angle,
    checked_ground,
    checked_number,
    checked_place,
    clipped,
    joined,
)
from sooner.errors import InvalidProblemError

__all__ = ["expanding_square"]


def expanding_square(free: Any, datum: ArrayLike, spacing: float, heading: float = np.pi / 2) -> Tracks:
    """Outwards from the datum in squares: legs of S, S, 2 S, 2 S, 3 S, 3 S ..., every turn 90 degrees to the right.

    Parameters
    ----------
    free : (Multi)Polygon      where the drone may be, metres; legs that leave it are cut
    datum : (2,) float         where the search begins, metres; it may lie outside the free ground
    spacing : float            S, metres between tracks
    heading : float            of the first leg, radians counter-clockwise from east; the manual flies it into the
                               wind, and turns a second search of the same ground by 45 degrees

    Returns
    -------
    tuple of (n, 2) float      tracks in the order of flight, until the square has passed the furthest free ground

    Raises
    ------
    InvalidProblemError        if the ground is none, a number makes no sense, or the pattern has too many legs

    Examples
    --------
    >>> import shapely
    >>> (track,) = expanding_square(shapely.box(-150, -150, 150, 150), (0, 0), spacing=100)
    >>> np.hypot(*np.diff(track, axis=0).T).round().tolist()
    [100.0, 100.0, 200.0, 200.0, 250.0]
    >>> track[:4].round().tolist()
    [[0.0, 0.0], [0.0, 100.0], [100.0, 100.0], [100.0, -100.0]]
    """
    free = checked_ground(free)
    place, spacing = checked_place("datum", datum), checked_number("track spacing", spacing)
    heading = checked_angle(heading)
    along = np.array([np.cos(heading), np.sin(heading)])
    right = np.array([along[1], -along[0]])
    west, south, east, north = free.bounds
    corners = np.array([(west, south), (west, north), (east, south), (east, north)]) - place
    reach = float(np.abs(corners @ np.stack([along, right], axis=1)).max())
    track = place + _square_spiral(reach, spacing) @ np.stack([along, right])
    return joined(clipped(track, free), free)


def _square_spiral(reach: float, spacing: float) -> NDArray[np.float64]:
    """(n, 2) metres ahead and to the right of the datum: all legs until none nearer than the reach is left."""
    legs = 4 * (reach / spacing + 1)
    if not legs <= MAX_LEGS:
        raise InvalidProblemError(f"{legs:.0f} legs would come of a track spacing of {spacing} m; expected fewer")
    number = np.arange(int(legs) + 1)
    turns = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])[number % 4]
    ends = np.cumsum((number[:, None] // 2 + 1) * turns, axis=0) * spacing
    return np.concatenate([np.zeros((1, 2)), ends])
