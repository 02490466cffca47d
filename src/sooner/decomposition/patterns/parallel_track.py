"""The parallel track search (PS) [IAMSAR2019, vol. III, p. 12-15]."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from sooner.decomposition.patterns.lanes import narrowest
from sooner.decomposition.patterns.legs import Tracks, checked_angle, checked_ground, checked_number
from sooner.decomposition.patterns.plowed import plowed

__all__ = ["parallel_track"]


def parallel_track(free: Any, spacing: float, angle: float | None = None, commence: ArrayLike | None = None) -> Tracks:
    """Legs parallel to the long side of the ground, one track spacing apart, from one side to the other.

    The search commences half a spacing inside both sides of a corner; a rectangle of length L has legs of L - S.

    Parameters
    ----------
    free : (Multi)Polygon      where the drone may be, metres
    spacing : float            S, metres; where the ground's width is not a multiple of it, legs lie a little closer
    angle : float              of the legs, radians counter-clockwise from east; None for `narrowest`, the fewest legs
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
    >>> parallel_track(shapely.box(0, 0, 100, 40), spacing=20, commence=(100, 40))
    (array([[90., 30.],
           [10., 30.],
           [10., 10.],
           [90., 10.]]),)
    """
    free, spacing = checked_ground(free), checked_number("track spacing", spacing)
    return plowed(free, spacing, narrowest(free) if angle is None else checked_angle(angle), commence)
