"""The sector search (VS) [IAMSAR2019, vol. II, fig. 5-1; vol. III, p. 12-11]."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.decomposition.patterns.legs import (
    Tracks,
    checked_angle,
    checked_ground,
    checked_number,
    checked_place,
    clipped,
    joined,
)
from sooner.errors import InvalidProblemError

__all__ = ["sector_search"]


def sector_search(free: Any, datum: ArrayLike, radius: float, heading: float = np.pi / 2, *, passes: int = 1) -> Tracks:
    """Three equilateral triangles that meet in the datum, every turn 120 degrees to the right: legs of 9 R in all.

    The next pass begins 30 degrees further to the right, so that its legs fall half-way between those of the first.
    The one after that flies the first again.

    Parameters
    ----------
    free : (Multi)Polygon      where the drone may be, metres; legs that leave it are cut
    datum : (2,) float         the middle, metres; it may lie outside the free ground
    radius : float             R, metres: the length of every leg; those through the datum are two of them
    heading : float            of the first leg, radians counter-clockwise from east; the manual flies it down-drift
    passes : int

    Returns
    -------
    tuple of (n, 2) float      tracks in the order of flight

    Raises
    ------
    InvalidProblemError        if the ground is none or a number makes no sense

    Notes
    -----
    The manual's six sectors of 60 degrees, the pattern that vessels fly; for aircraft it lets the angle follow from
    the radius and the widest track spacing.

    Examples
    --------
    >>> import shapely
    >>> (track,) = sector_search(shapely.box(-150, -150, 150, 150), (0, 0), radius=100)
    >>> np.hypot(*np.diff(track, axis=0).T).round().tolist()
    [100.0, 100.0, 200.0, 100.0, 200.0, 100.0, 100.0]
    >>> track[1:3].round(1).tolist()
    [[0.0, 100.0], [86.6, 50.0]]
    """
    free = checked_ground(free)
    place, radius = checked_place("datum", datum), checked_number("radius", radius)
    if not 1 <= passes <= 100:
        raise InvalidProblemError(f"{passes} passes came; expected 1 to 100")
    heading = checked_angle(heading)
    rounds = [_triangles(heading - k % 2 * np.pi / 6)[min(k, 1) :] for k in range(passes)]
    return joined(clipped(place + radius * np.concatenate(rounds), free), free)


def _triangles(heading: float) -> NDArray[np.float64]:
    """(8, 2): one pass of radius 1 about the origin, from it and back to it."""
    spokes = heading + np.radians([0.0, -60.0, 120.0, 60.0, -120.0, -180.0])
    out = np.stack([np.cos(spokes), np.sin(spokes)], axis=1)
    return np.concatenate([np.zeros((1, 2)), out, np.zeros((1, 2))])
