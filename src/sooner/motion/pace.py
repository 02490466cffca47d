"""How long straight legs take: from rest to rest, against the wind, and up and down over terrain.

Places are metres east and north of the centre of the grid's south-west cell, as `Grid.centres_m`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.motion.kinematics import checked_waypoints, corners
from sooner.motion.trajectory import Course, Trajectory
from sooner.motion.wind import check_wind

__all__ = ["Pace", "Terrain"]

Arrays = tuple[float, float, float, float, float, float, float, NDArray[np.float64], float]


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights of the ground beneath a flight, which keeps its height above them.

    Parameters
    ----------
    heights : (H, W) float     metres at the centres of cells, row 0 north; bilinear between, the border's beyond
    cell_m : float             metres between the centres

    Raises
    ------
    InvalidProblemError        if a height or the cell makes no sense

    Examples
    --------
    >>> slope = Terrain(np.array([[30.0, 30.0], [0.0, 10.0]]), cell_m=20.0)
    >>> slope.heights_at([[0.0, 0.0], [0.0, 10.0], [10.0, 10.0], [500.0, -500.0]])
    array([ 0. , 15. , 17.5, 10. ])
    """

    heights: NDArray[np.float64]
    cell_m: float

    def __post_init__(self) -> None:
        heights = np.ascontiguousarray(self.heights, np.float64)
        if heights.ndim != 2 or heights.size == 0 or not np.isfinite(heights).all():
            raise InvalidProblemError(f"heights of shape {heights.shape} came; expected finite metres, (H, W)")
        if not (np.isfinite(self.cell_m) and self.cell_m > 0):
            raise InvalidProblemError(f"a cell size of {self.cell_m} m came; expected a positive number")
        object.__setattr__(self, "heights", heights)

    def heights_at(self, points: ArrayLike) -> NDArray[np.float64]:
        """(n,) float: height of the ground at places (n, 2), metres east and north."""
        from sooner.motion._pace_kernels import heights_at

        found: NDArray[np.float64] = heights_at(_places(points, "places"), self.heights, self.cell_m)
        return found

    def smoothed(self, radius_m: float) -> Terrain:
        """A surface to follow in flight: smoother than the ground, and nowhere beneath it.

        s = mean over a square of the highest ground in a square, both reaching `radius_m` in whole cells, at least one

        Every highest ground in the mean is of a square that holds the cell itself; so s is no lower than the ground,
        at the centres and, being bilinear as it is, between them.

        Examples
        --------
        >>> Terrain(np.array([[0.0, 0, 0, 9, 0, 0, 0]]), cell_m=10.0).smoothed(10.0).heights
        array([[0., 3., 6., 9., 6., 3., 0.]])
        """
        from scipy import ndimage

        if not (np.isfinite(radius_m) and radius_m >= 0):
            raise InvalidProblemError(f"a radius of {radius_m} m came; expected a number of at least 0")
        size = 2 * min(max(round(radius_m / self.cell_m), 1), max(self.heights.shape)) + 1
        highest = ndimage.maximum_filter(self.heights, size, mode="nearest")
        mean = ndimage.uniform_filter(highest, size, mode="nearest")
        return Terrain(np.maximum(mean, self.heights), self.cell_m)  # rounding of the mean might dip beneath


@dataclass(frozen=True)
class Pace:
    """How fast a drone flies straight legs between stops.

    Parameters
    ----------
    speed_mps : float              asked for over the ground, metres a second
    accel_mps2 : float             metres a second squared; inf: stops cost nothing, time is length over speed
    airspeed_mps : float or None   most through the air; None: the wind does not matter
    wind : (float, float)          metres a second east and north, where it blows to
    climb_mps, descent_mps : float or None     most up and down; None: slopes do not matter
    terrain : Terrain or None      followed at one height above it; see `Terrain.smoothed`

    Raises
    ------
    InvalidProblemError            if a limit is not a positive number, or the wind not two numbers

    Examples
    --------
    >>> Pace(speed_mps=10.0, accel_mps2=2.0).leg_seconds([[0, 0]], [[100, 0]])
    array([15.])
    >>> windy = Pace(10.0, 2.0, airspeed_mps=10.0, wind=(6.0, 0.0))
    >>> windy.leg_seconds([[0, 0], [100, 0], [0, 0]], [[100, 0], [0, 0], [0, 100]])
    array([15. , 27. , 16.5])
    """

    speed_mps: float
    accel_mps2: float
    airspeed_mps: float | None = None
    wind: tuple[float, float] = (0.0, 0.0)
    climb_mps: float | None = None
    descent_mps: float | None = None
    terrain: Terrain | None = None

    def __post_init__(self) -> None:
        limits = (
            ("speed", self.speed_mps),
            ("airspeed", self.airspeed_mps),
            ("climb", self.climb_mps),
            ("descent", self.descent_mps),
        )
        for name, limit in limits:
            if limit is not None and not (np.isfinite(limit) and limit > 0):
                raise InvalidProblemError(f"a greatest {name} of {limit} m/s came; expected a positive number")
        if not self.accel_mps2 > 0:
            raise InvalidProblemError(
                f"a greatest acceleration of {self.accel_mps2} m/s2 came; expected a positive number, or inf"
            )
        if len(self.wind) != 2 or not np.isfinite(self.wind).all():
            raise InvalidProblemError(f"a wind of {self.wind} came; expected metres a second east and north")

    def arrays(self) -> Arrays:
        """What the kernels `leg_s`, `legs_s` and `way_s` of `sooner.motion._pace_kernels` take after their places."""
        airspeed, climb, descent = (
            math.inf if limit is None else float(limit)
            for limit in (self.airspeed_mps, self.climb_mps, self.descent_mps)
        )
        flat = self.terrain is None or (climb == descent == math.inf)
        heights = np.empty((0, 0)) if self.terrain is None or flat else self.terrain.heights
        cell_m = 1.0 if self.terrain is None or flat else float(self.terrain.cell_m)
        east, north = map(float, self.wind)
        return (
            *(float(self.speed_mps), float(self.accel_mps2), airspeed, east, north),
            *(climb, descent, heights, cell_m),
        )

    def leg_seconds(self, starts: ArrayLike, ends: ArrayLike) -> NDArray[np.float64]:
        """Least time along straight legs, from rest to rest.

        speed over the ground <= min(speed_mps, w_1 + sqrt(airspeed^2 - w_2^2))         w_1 along, w_2 across the leg
        speed over the ground <= climb / slope uphill, descent / slope downhill

        and within these as `Dynamics.leg_seconds`: as fast as the acceleration lets it up to the most, and down again.
        Slopes are those between points half a cell apart at most; between them the acceleration holds too.

        Parameters
        ----------
        starts, ends : (n, 2) float    metres east and north

        Returns
        -------
        (n,) float                     seconds; inf where the wind is no weaker than the airspeed, as then no drone can
                                       stand still at a leg's ends; 0 for a leg without length
        """
        from sooner.motion._pace_kernels import legs_s

        starts, ends = _places(starts, "starts"), _places(ends, "ends")
        if len(starts) != len(ends):
            raise InvalidProblemError(f"{len(starts)} starts and {len(ends)} ends came; expected as many of each")
        found: NDArray[np.float64] = legs_s(starts, ends, *self.arrays())
        return found

    def flight(self, points: ArrayLike) -> Trajectory:
        """The flight along a polyline that stops where it turns and flies on through points that lie straight ahead.

        Over terrain it stops at those as well where that is quicker: slopes are those between points half a cell apart,
        counted from where a leg begins.

        Parameters
        ----------
        points : (n, 2) float      metres east and north, n >= 1

        Returns
        -------
        Trajectory                 over the plane: its duration is the sum of `leg_seconds` of its straight runs

        Raises
        ------
        InvalidProblemError        if the points make no sense, or the wind is no weaker than the airspeed

        Examples
        --------
        >>> flight = Pace(10.0, 2.0).flight([[0, 0], [50, 0], [100, 0], [100, 100]])
        >>> flight.duration, flight.times
        (30.0, array([ 0. ,  7.5, 15. , 30. ]))
        """
        from sooner.motion import _pace_kernels as kernels

        points = np.ascontiguousarray(checked_waypoints(points))
        check_wind(self.airspeed_mps, self.wind)
        pace = self.arrays()
        halts = kernels.halts(points, corners(points), *pace)
        course = Course.straight(points[halts])
        legs = [kernels.leg_knots(*(*points[a], *points[b], *pace)) for a, b in pairwise(halts)]
        knot_s, knot_m, knot_mps = _knots(legs, course.bounds_m)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        flown = np.interp(along, along[halts], course.bounds_m[: len(halts)])
        bare = Trajectory(points, np.empty(0), course, knot_s, knot_m, knot_mps)
        return Trajectory(points, bare.times_at(flown), course, knot_s, knot_m, knot_mps)


def _knots(
    legs: list[NDArray[np.float64]], bounds_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Time, metres flown and speed where the acceleration changes; where the speed jumps, two knots at one time."""
    if not any(map(len, legs)):
        return np.zeros(1), np.zeros(1), np.zeros(1)
    stretches = np.concatenate(legs)
    ends_s, before, after = np.cumsum(stretches[:, 0]), stretches[:, 2], stretches[:, 3]
    counts = np.array([len(leg) for leg in legs])
    ends_m = np.minimum(np.cumsum(stretches[:, 1]), np.repeat(bounds_m[1:], counts))
    ends_m[np.cumsum(counts)[counts > 0] - 1] = bounds_m[1:][counts > 0]
    begins_s, begins_m = np.append(0.0, ends_s[:-1]), np.append(0.0, ends_m[:-1])
    kept = np.column_stack([np.append(True, before[1:] != after[:-1]), np.ones(len(after), bool)])
    pairs = ((begins_s, ends_s), (begins_m, ends_m), (before, after))
    knot_s, knot_m, knot_mps = (np.column_stack(pair)[kept] for pair in pairs)
    return knot_s, knot_m, knot_mps


def _places(points: ArrayLike, name: str) -> NDArray[np.float64]:
    places = np.ascontiguousarray(points, np.float64)
    if places.ndim != 2 or places.shape[1] != 2 or not np.isfinite(places).all():
        raise InvalidProblemError(f"{name} of shape {places.shape} came; expected finite metres east and north, (n, 2)")
    return places
