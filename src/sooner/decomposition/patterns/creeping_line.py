"""The creeping line search (CS) [IAMSAR2019, vol. III, sec. 12]."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sooner.decomposition.patterns.lanes import narrowest
from sooner.decomposition.patterns.legs import Tracks, checked_angle, checked_ground, checked_number
from sooner.decomposition.patterns.plowed import plowed

__all__ = ["creeping_line"]


def creeping_line(free: Any, spacing: float, angle: float | None = None, commence: ArrayLike | None = None) -> Tracks:
    """Legs parallel to the short side of the ground, so that the search creeps along the long one.

    One end of the ground is searched first: choose it with `commence` where the person is more likely there. On a
    rectangle of width B legs are B - S long and begin half a spacing inside the corner.

    Parameters
    ----------
    free : (Multi)Polygon      where the drone may be, metres
    spacing : float            S, metres; where the ground's length is not a multiple of it, legs lie a little closer
    angle : float              of the creep, radians counter-clockwise from east; None for `narrowest`
    commence : (2,) float      metres; the corner of the pattern nearest to it comes first

    Returns
    -------
    tuple of (n, 2) float      tracks in the order of flight; one where nothing must be flown around

    Raises
    ------
    InvalidProblemError        if the ground is none, a number makes no sense, or the pattern has too many legs

    Examples
    --------
    >>> import shapely
    >>> (track,) = creeping_line(shapely.box(0, 0, 90, 40), spacing=30, commence=(0, 0))
    >>> track.round(6).tolist()
    [[15.0, 15.0], [15.0, 25.0], [45.0, 25.0], [45.0, 15.0], [75.0, 15.0], [75.0, 25.0]]
    """
    free, spacing = checked_ground(free), checked_number("track spacing", spacing)
    along = narrowest(free) if angle is None else checked_angle(angle)
    return plowed(free, spacing, along + np.pi / 2, commence)
