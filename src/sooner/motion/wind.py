"""The wind triangle: velocity over the ground is velocity through the air and the wind's together.

Angles are radians counter-clockwise from east; a wind is (east, north) in metres a second, where it blows to.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["Wind", "check_wind", "drifted", "ground_speed", "heading"]

Wind = tuple[float, float]
Floats = NDArray[np.float64]


def ground_speed(course: ArrayLike, airspeed: float, wind: Wind) -> Floats:
    """Speed over the ground of who keeps a course.

    g = w_1 + sqrt(A^2 - w_2^2)      w_1 the wind along the course, w_2 across it, A the airspeed

    Parameters
    ----------
    course : (...) float       direction over the ground
    airspeed : float           metres a second, more than the wind's
    wind : (float, float)

    Returns
    -------
    (...) float                metres a second, above 0

    Raises
    ------
    InvalidProblemError        if the wind is no weaker than the airspeed, or a number makes no sense

    Examples
    --------
    >>> ground_speed([0.0, np.pi / 2, np.pi], airspeed=10.0, wind=(6.0, 0.0))
    array([16.,  8.,  4.])
    """
    along, across = _components(course, airspeed, wind)
    return np.asarray(along + np.sqrt(airspeed**2 - across**2))


def heading(course: ArrayLike, airspeed: float, wind: Wind) -> Floats:
    """Direction through the air that keeps a course over the ground: upwind of it by the angle of drift.

    h = course - asin(w_2 / A)      w_2 the wind across the course, from the right to the left

    Parameters, errors: as `ground_speed`.

    Examples
    --------
    >>> float(np.degrees(heading(0.0, airspeed=10.0, wind=(0.0, 5.0))).round(6))
    -30.0
    """
    _, across = _components(course, airspeed, wind)
    return np.asarray(np.asarray(course, np.float64) - np.arcsin(across / airspeed))


def drifted(heading: ArrayLike, airspeed: float, wind: Wind) -> tuple[Floats, Floats]:
    """Course and speed over the ground of who keeps a heading; the inverse of `heading` and `ground_speed`.

    Parameters
    ----------
    heading : (...) float      direction through the air

    Returns
    -------
    (...) float, (...) float   radians in (-pi, pi]; metres a second

    Examples
    --------
    >>> course, speed = drifted(0.0, airspeed=3.0, wind=(0.0, 4.0))
    >>> float(course.round(6)), float(speed)
    (0.927295, 5.0)
    """
    _check_numbers(airspeed, wind)
    east = airspeed * np.cos(heading) + wind[0]
    north = airspeed * np.sin(heading) + wind[1]
    return np.asarray(np.arctan2(north, east)), np.asarray(np.hypot(east, north))


def check_wind(airspeed: float | None, wind: Wind) -> None:
    """Refuse a wind in which a drone cannot stand still over the ground, nor come back.

    Raises
    ------
    InvalidProblemError        if it is no weaker than the airspeed; without a limit of airspeed no wind is refused

    Examples
    --------
    >>> check_wind(10.0, (6.0, 8.0))
    Traceback (most recent call last):
    ...
    sooner.errors.InvalidProblemError: a wind of 10 m/s came, and at most 10 m/s through the air; nothing flies against it: wait for less wind, or take a faster drone
    """  # noqa: E501
    if airspeed is None:
        return
    strength = math.hypot(*wind)
    if strength >= airspeed:
        raise InvalidProblemError(
            f"a wind of {strength:g} m/s came, and at most {airspeed:g} m/s through the air; nothing flies against it:"
            " wait for less wind, or take a faster drone"
        )


def _components(course: ArrayLike, airspeed: float, wind: Wind) -> tuple[Floats, Floats]:
    """Wind along a course and across it, to the left, where it can be flown."""
    _check_numbers(airspeed, wind)
    check_wind(airspeed, wind)
    east, north = np.cos(course), np.sin(course)
    return np.asarray(wind[0] * east + wind[1] * north), np.asarray(wind[1] * east - wind[0] * north)


def _check_numbers(airspeed: float, wind: Wind) -> None:
    if not (np.isfinite(airspeed) and airspeed > 0):
        raise InvalidProblemError(f"an airspeed of {airspeed} m/s came; expected a positive number")
    if len(wind) != 2 or not np.isfinite(wind).all():
        raise InvalidProblemError(f"a wind of {wind} came; expected metres a second east and north")
