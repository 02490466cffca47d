"""How long a drone takes that can neither fly nor speed up as it likes: bang-bang legs from point to point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import turns_rad

__all__ = ["Dynamics", "Profile", "Stops", "checked_waypoints", "corners"]

Stops = Literal["waypoints", "turns"]

STRAIGHT_RAD = 1e-6  # a turn below this is straight ahead: it asks for no more speed sideways than rounding does


@dataclass(frozen=True, eq=False)
class Profile:
    """Speed along one leg or many: up to a peak, along at the peak, down again.

    Parameters
    ----------
    start, peak, end : (...) float     metres per second when the leg begins, cruises and ends
    switches : (..., 2) float          seconds at which u goes from +a_max to 0 and from 0 to -a_max;
                                       the two are one where the leg is too short to cruise
    seconds : (...) float              how long the leg takes
    """

    start: NDArray[np.float64]
    peak: NDArray[np.float64]
    end: NDArray[np.float64]
    switches: NDArray[np.float64]
    seconds: NDArray[np.float64]


@dataclass(frozen=True)
class Dynamics:
    """A second-order integrator whose speed and acceleration are limited.

    r'' = u,   |r'| <= v_max,   |u| <= a_max                 [Kuhlman2017, eq. (6)]

    Parameters
    ----------
    v_max : float              metres per second
    a_max : float              metres per second squared

    Raises
    ------
    InvalidProblemError        if a limit is not a positive, finite number

    Examples
    --------
    >>> drone = Dynamics(v_max=2.0, a_max=2.0)
    >>> drone.r_crit
    2.0
    >>> drone.leg_seconds([0.5, 2.0, 10.0])
    array([1., 2., 6.])
    >>> drone.seconds([[0, 0], [10, 0], [20, 0]]), drone.seconds([[0, 0], [10, 0], [20, 0]], stops="turns")
    (12.0, 11.0)
    """

    v_max: float
    a_max: float

    def __post_init__(self) -> None:
        for name, limit, unit in (("speed", self.v_max, "m/s"), ("acceleration", self.a_max, "m/s2")):
            if not (np.isfinite(limit) and limit > 0):
                raise InvalidProblemError(f"a greatest {name} of {limit} {unit} came; expected a positive number")

    @property
    def r_crit(self) -> float:
        """Length in metres above which a leg from rest to rest cruises: v_max^2 / a_max [Kuhlman2017, Theorem 1]."""
        return self.v_max**2 / self.a_max

    def leg_seconds(self, length: ArrayLike, v_start: ArrayLike = 0.0, v_end: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Least time along straight legs.

        t = 2 sqrt(L / a)                   where L <= r_crit              [Kuhlman2017, eq. (7), Theorem 1]
        t = 2 v / a + (L - r_crit) / v      where L > r_crit

        from rest to rest; `profile` gives the general form. It never falls as the length grows.

        Parameters
        ----------
        length : (...) float           metres, at least 0
        v_start, v_end : (...) float   metres per second along the leg, in [0, v_max]; all three broadcast

        Returns
        -------
        (...) float                    seconds

        Raises
        ------
        InvalidProblemError            if a length or speed makes no sense, or an end speed cannot be reached

        Examples
        --------
        >>> float(Dynamics(2.0, 2.0).leg_seconds(10.0, v_end=2.0))
        5.5
        """
        return self.profile(length, v_start, v_end).seconds

    def profile(self, length: ArrayLike, v_start: ArrayLike = 0.0, v_end: ArrayLike = 0.0) -> Profile:
        """Speeds and switching times of the fastest flight along straight legs.

        peak = min(v_max, sqrt(a L + (v0^2 + v1^2) / 2))                    [Kuhlman2017, Theorem 1]
        t_1 = (peak - v0) / a,  t_2 = t_1 + (L - (2 peak^2 - v0^2 - v1^2) / 2a) / peak,  t = t_2 + (peak - v1) / a

        Parameters, errors: as `leg_seconds`.

        Examples
        --------
        >>> leg = Dynamics(2.0, 2.0).profile(10.0)
        >>> float(leg.peak), leg.switches
        (2.0, array([1., 5.]))
        """
        length, start, end = np.broadcast_arrays(
            np.asarray(length, np.float64), np.asarray(v_start, np.float64), np.asarray(v_end, np.float64)
        )
        self._check(length, start, end)
        return self._profile(length, start, end)

    def _profile(self, length: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]) -> Profile:
        squares = start**2 + end**2
        peak = np.minimum(np.sqrt(self.a_max * length + squares / 2), self.v_max)
        peak = np.maximum(peak, np.maximum(start, end))
        cruise_m = np.maximum(length - (2 * peak**2 - squares) / (2 * self.a_max), 0.0)
        cruises = (peak >= self.v_max) & (cruise_m > 0)
        up = (peak - start) / self.a_max
        down_from = up + np.where(cruises, cruise_m / self.v_max, 0.0)
        seconds = np.asarray(down_from + (peak - end) / self.a_max)
        return Profile(start, np.asarray(peak), end, np.stack([up, down_from], axis=-1), seconds)

    def reachable(self, length: ArrayLike, v_start: ArrayLike, v_end: ArrayLike) -> NDArray[np.bool_]:
        """Whether a leg is long enough to get from one speed to the other: |v1^2 - v0^2| <= 2 a L."""
        length, start, end = (np.asarray(x, np.float64) for x in (length, v_start, v_end))
        change = np.abs(end**2 - start**2)
        return np.asarray((length >= 0) & (change <= 2 * self.a_max * length * (1 + 1e-9) + 1e-12 * self.v_max**2))

    def _check(self, length: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]) -> None:
        if not (np.isfinite(length).all() and (length >= 0).all()):
            raise InvalidProblemError("a length came negative or not finite; expected metres of at least 0")
        for speed in (start, end):
            if not ((speed >= 0) & (speed <= self.v_max * (1 + 1e-9))).all():
                raise InvalidProblemError(f"an end speed came outside [0, {self.v_max}] m/s, the drone's range")
        short = np.flatnonzero(~self.reachable(length, start, end))
        if len(short):
            metres, begun, ended = (float(x.ravel()[short[0]]) for x in (length, start, end))
            span = 2 * self.a_max * metres
            low, high = max(begun**2 - span, 0.0) ** 0.5, min((begun**2 + span) ** 0.5, self.v_max)
            raise InvalidProblemError(
                f"a leg of {metres:g} m from {begun:g} to {ended:g} m/s came; at {self.a_max:g} m/s2 its end speed can"
                f" be {low:.4g} to {high:.4g} m/s: make the leg longer or the speeds more alike"
            )

    def seconds(self, waypoints: ArrayLike, stops: Stops = "waypoints") -> float:
        """Least time along a polyline that stops on its way.

        sum over legs of leg_seconds(|r_(i+1) - r_i|)                      [Kuhlman2017, sec. 5.3]

        Parameters
        ----------
        waypoints : (n, 2) float   metres east and north, n >= 1
        stops : str                "waypoints": stop at every one, as the paper does;
                                   "turns": fly on through those that lie straight ahead

        Examples
        --------
        >>> Dynamics(2.0, 2.0).seconds([[0, 0], [2, 0], [2, 2]])
        4.0
        """
        points = checked_waypoints(waypoints)
        if stops == "turns":
            points = points[corners(points)]
        elif stops != "waypoints":
            raise InvalidProblemError(f"stops={stops!r} came; expected 'waypoints' or 'turns'")
        return float(self.leg_seconds(np.hypot(*np.diff(points, axis=0).T)).sum())


def checked_waypoints(waypoints: ArrayLike) -> NDArray[np.float64]:
    """(n, 2) float: waypoints that make sense, or InvalidProblemError."""
    points = np.asarray(waypoints, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) == 0 or not np.isfinite(points).all():
        raise InvalidProblemError(
            f"waypoints of shape {points.shape} came; expected finite metres east and north, (n, 2) with n >= 1"
        )
    return points


def corners(points: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of the first waypoint, of those where the way turns, and of the last; each place once in a row.

    >>> corners(np.array([[0.0, 0], [1, 0], [1, 0], [2, 0], [2, 1]]))
    array([0, 3, 4])
    """
    apart = np.flatnonzero(np.any(np.diff(points, axis=0) != 0, axis=1)) + 1
    kept: NDArray[np.intp] = np.concatenate([[0], apart]).astype(np.intp)
    if len(kept) < 3:
        return kept
    turning = np.concatenate([[True], turns_rad(points[kept]) > STRAIGHT_RAD, [True]])
    return np.asarray(kept[turning], np.intp)
