"""Where a drone is at any time: a course over the ground, and the speed along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.motion.kinematics import Dynamics, Stops, checked_waypoints, corners

__all__ = ["Course", "Flown", "Trajectory", "integrated"]


@dataclass(frozen=True, eq=False)
class Course:
    """A line over the ground made of straights and arcs, each going on where the one before ends.

    Parameters
    ----------
    origins : (p, 2) float         metres east and north where each piece begins
    headings : (p,) float          its direction there, radians counter-clockwise from east
    curvatures : (p,) float        1 / radius, positive to the left; 0 is straight
    bounds_m : (p + 1,) float      metres flown where each piece begins, and at the very end

    Examples
    --------
    >>> quarter = Course(np.zeros((1, 2)), np.zeros(1), np.ones(1), np.array([0.0, np.pi / 2]))
    >>> quarter.at(np.pi / 2).round(12)
    array([1., 1.])
    """

    origins: NDArray[np.float64]
    headings: NDArray[np.float64]
    curvatures: NDArray[np.float64]
    bounds_m: NDArray[np.float64]

    @classmethod
    def straight(cls, points: NDArray[np.float64]) -> Course:
        """Course along a polyline, (n, 2) with n >= 1."""
        steps = np.diff(points, axis=0)
        steps = steps if len(steps) else np.zeros((1, 2))
        bounds = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
        return cls(points[: len(steps)], np.arctan2(steps[:, 1], steps[:, 0]), np.zeros(len(steps)), bounds)

    def piece(self, flown_m: NDArray[np.float64]) -> NDArray[np.intp]:
        """(...) int: the piece that holds each arc length."""
        return np.clip(np.searchsorted(self.bounds_m, flown_m, "right") - 1, 0, len(self.headings) - 1)

    def at(self, flown_m: ArrayLike) -> NDArray[np.float64]:
        """(..., 2) float: place after so many metres; a chord of the circle, x sinc(k x / 2) at half the turn."""
        flown = np.clip(np.asarray(flown_m, np.float64), 0.0, self.bounds_m[-1])
        k = self.piece(flown)
        x = flown - self.bounds_m[k]
        half = self.curvatures[k] * x / 2
        chord, heading = x * np.sinc(half / np.pi), self.headings[k] + half
        return self.origins[k] + np.stack([chord * np.cos(heading), chord * np.sin(heading)], axis=-1)

    def heading_at(self, flown_m: ArrayLike) -> NDArray[np.float64]:
        """(...) float: direction of flight after so many metres, radians counter-clockwise from east."""
        flown = np.asarray(flown_m, np.float64)
        k = self.piece(flown)
        return np.asarray(self.headings[k] + self.curvatures[k] * (flown - self.bounds_m[k]))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A flight through waypoints: where the drone is, how fast, and when.

    Between two knots the acceleration along the course is constant: s = s_k + v_k t + a_k t^2 / 2.

    Parameters
    ----------
    waypoints : (n, 2) float       metres east and north
    times : (n,) float             seconds at which the drone is there, or nearest to there
    course : Course
    knot_s, knot_m, knot_mps : (k,) float      time, metres flown and speed where the acceleration changes
    deviation_m : float            farthest that the course leaves the polyline through the waypoints

    Examples
    --------
    >>> flight = Trajectory.through([[0, 0], [10, 0], [10, 2]], Dynamics(v_max=2.0, a_max=2.0))
    >>> flight.duration, flight.times
    (8.0, array([0., 6., 8.]))
    >>> position, speed = flight.at(3.0)
    >>> position, float(speed)
    (array([5., 0.]), 2.0)
    """

    waypoints: NDArray[np.float64]
    times: NDArray[np.float64]
    course: Course
    knot_s: NDArray[np.float64]
    knot_m: NDArray[np.float64]
    knot_mps: NDArray[np.float64]
    deviation_m: float = 0.0

    @classmethod
    def through(cls, waypoints: ArrayLike, dynamics: Dynamics, stops: Stops = "waypoints") -> Trajectory:
        """The fastest flight along the polyline that stops where `stops` says; see `Dynamics.seconds`."""
        points = checked_waypoints(waypoints)
        if stops not in ("waypoints", "turns"):
            raise InvalidProblemError(f"stops={stops!r} came; expected 'waypoints' or 'turns'")
        flown = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        halts = corners(points) if stops == "turns" else np.arange(len(points))
        course = Course.straight(points[halts])
        rest = np.zeros(len(course.headings))
        return cls.timed(points, np.interp(flown, flown[halts], course.bounds_m[: len(halts)]), course, dynamics, rest)

    @classmethod
    def timed(
        cls,
        waypoints: NDArray[np.float64],
        flown_m: NDArray[np.float64],
        course: Course,
        dynamics: Dynamics,
        entry_mps: NDArray[np.float64],
        deviation_m: float = 0.0,
    ) -> Trajectory:
        """Fly a course whose pieces are begun at given speeds and whose end is at rest; arcs keep their speed.

        flown_m : (n,) metres flown at each waypoint; entry_mps : (p,) speed at the start of each piece.
        """
        lengths, exit_mps = np.diff(course.bounds_m), np.append(entry_mps[1:], 0.0)
        arcs = course.curvatures != 0
        leg = dynamics.profile(np.where(arcs, 0.0, lengths), entry_mps, np.where(arcs, entry_mps, exit_mps))
        spans = np.stack([leg.switches[:, 0], np.diff(leg.switches)[:, 0], leg.seconds - leg.switches[:, 1]], axis=1)
        spans[arcs, 1] = lengths[arcs] / entry_mps[arcs]
        ends_mps = np.stack([leg.peak, leg.peak, leg.end], axis=1)
        climbed = course.bounds_m[:-1] + spans[:, 0] * (leg.start + leg.peak) / 2
        ends_m = np.stack([climbed, climbed + spans[:, 1] * leg.peak, course.bounds_m[1:]], axis=1)
        real = spans.ravel() > 1e-12 * spans.sum()
        knot_s = np.concatenate([[0.0], np.cumsum(spans.ravel()[real])])
        knot_m = np.concatenate([[0.0], ends_m.ravel()[real]])
        knot_mps = np.concatenate([entry_mps[:1], ends_mps.ravel()[real]])
        knot_m[-1], knot_mps[-1] = course.bounds_m[-1], 0.0
        bare = cls(waypoints, np.empty(0), course, knot_s, knot_m, knot_mps)
        return cls(waypoints, bare.times_at(flown_m), course, knot_s, knot_m, knot_mps, deviation_m)

    @property
    def duration(self) -> float:
        """Seconds from the start at rest to the end at rest."""
        return float(self.knot_s[-1])

    @property
    def length_m(self) -> float:
        """Metres flown in all."""
        return float(self.course.bounds_m[-1])

    def _knot(self, values: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.intp]:
        return np.clip(np.searchsorted(values, at, "right") - 1, 0, max(len(values) - 2, 0))

    def _tangential(self, k: NDArray[np.intp]) -> NDArray[np.float64]:
        """(...) float: acceleration along the course after knot k; 0 where the speed jumps at once."""
        if len(self.knot_s) < 2:
            return np.zeros(k.shape)
        spans = np.diff(self.knot_s)
        return np.asarray(np.divide(np.diff(self.knot_mps), spans, out=np.zeros(len(spans)), where=spans > 0)[k])

    def metres_at(self, t: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Metres flown and speed at times (...), which are held within the flight's."""
        t = np.clip(np.asarray(t, np.float64), 0.0, self.duration)
        k = self._knot(self.knot_s, t)
        tau, a = t - self.knot_s[k], self._tangential(k)
        flown = np.asarray(self.knot_m[k] + (self.knot_mps[k] + a * tau / 2) * tau)
        return flown, np.maximum(self.knot_mps[k] + a * tau, 0.0)

    def at(self, t: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Place (..., 2) in metres and speed (...) in metres per second at times (...) in seconds.

        Before its start the drone waits at the first waypoint, after its end at the last.
        """
        flown, speed = self.metres_at(t)
        return self.course.at(flown), speed

    def times_at(self, flown_m: ArrayLike) -> NDArray[np.float64]:
        """Seconds at which so many metres (...) are flown; the inverse of `metres_at`.

        t = t_k + 2 x / (v_k + sqrt(v_k^2 + 2 a_k x)), where x metres were flown since knot k
        """
        flown = np.clip(np.asarray(flown_m, np.float64), 0.0, self.length_m)
        k = self._knot(self.knot_m, flown)
        x = np.maximum(flown - self.knot_m[k], 0.0)
        end_mps = np.sqrt(np.maximum(self.knot_mps[k] ** 2 + 2 * self._tangential(k) * x, 0.0))
        mean = (self.knot_mps[k] + end_mps) / 2
        tau = np.where(mean > 0, x / np.where(mean > 0, mean, 1.0), 0.0)
        return np.minimum(self.knot_s[k] + tau, self.knot_s[np.minimum(k + 1, len(self.knot_s) - 1)])

    def control(self, t: ArrayLike) -> NDArray[np.float64]:
        """(..., 2) float: u(t) of [Kuhlman2017, eq. (6)]: tangential, and on arcs v^2 / r towards the centre."""
        t = np.asarray(t, np.float64)
        flown, speed = self.metres_at(t)
        along = self._tangential(self._knot(self.knot_s, t))
        across = speed**2 * self.course.curvatures[self.course.piece(flown)]
        heading = self.course.heading_at(flown)
        east, north = np.cos(heading), np.sin(heading)
        return np.stack([along * east - across * north, along * north + across * east], axis=-1)

    def sample(self, dt: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Times (m,), places (m, 2) and speeds (m,) every `dt` seconds, start and end included."""
        if not (np.isfinite(dt) and dt > 0):
            raise InvalidProblemError(f"a step of {dt} s came; expected a positive number")
        times = np.append(np.arange(0.0, self.duration, dt), self.duration)
        return times, *self.at(times)

    def polyline(self, sagitta_m: float = 0.01) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The course as points (m, 2), no arc farther than `sagitta_m` from its chord, and metres flown at each (m,).

        For `sensors.swept_cells`, whose arc lengths along chords become metres flown by `np.interp`.
        """
        lengths, bends = np.diff(self.course.bounds_m), np.abs(self.course.curvatures)
        step_rad = 2 * np.arccos(np.clip(1.0 - sagitta_m * bends, 0.0, 1.0 - 1e-9))
        counts = np.where(bends > 0, np.ceil(lengths * bends / step_rad), 1).astype(int)
        pieces = [
            bound + length * np.arange(count) / count
            for bound, length, count in zip(self.course.bounds_m, lengths, np.maximum(counts, 1), strict=False)
        ]
        flown = np.concatenate([*pieces, [self.length_m]])
        return self.course.at(flown), flown


@dataclass(frozen=True)
class Flown:
    """What small steps of eq. (6) found: whether the drone is where it was said to be.

    Parameters
    ----------
    end_m : float              metres between where it ended and the course's end, at the stated duration
    end_mps : float            its speed then; it ought to rest
    off_m : float              farthest that it ever was from where the trajectory says
    top_mps, top_mps2 : float  its greatest speed and acceleration
    """

    end_m: float
    end_mps: float
    off_m: float
    top_mps: float
    top_mps2: float


def integrated(trajectory: Trajectory, dt: float = 0.01) -> Flown:
    """Integrate r'' = u(t) in the plane by small steps, from rest, knowing nothing but the control.

    v' = v + h (u_1 + u_2) / 2,   r' = r + h v + h^2 (w_1 u_1 + w_2 u_2) / 2          [Kuhlman2017, eq. (6)]

    u_1, u_2 at Gauss's two points t + c h of each step, w = 1 - c. Steps of at most `dt` seconds end where the control
    jumps, so that straights are exact and the error of an arc is of fourth order. A duration that is too short or too
    long shows as `end_m` and `end_mps`.

    Examples
    --------
    >>> flown = integrated(Trajectory.through([[0, 0], [10, 0], [10, 2]], Dynamics(2.0, 2.0)))
    >>> flown.end_m < 1e-9, flown.end_mps < 1e-9, round(flown.top_mps, 9), round(flown.top_mps2, 9)
    (True, True, 2.0, 2.0)
    """
    times = np.union1d(trajectory.sample(dt)[0], trajectory.knot_s)
    h = np.diff(times)[:, None]
    early, late = 0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)
    u_1, u_2 = (trajectory.control(times[:-1] + c * h[:, 0]) for c in (early, late))
    still = np.zeros((1, 2))
    v = np.concatenate([still, np.cumsum(h * (u_1 + u_2) / 2, axis=0)])
    moved = h * v[:-1] + h**2 * (late * u_1 + early * u_2) / 2
    r = trajectory.course.at(0.0) + np.concatenate([still, np.cumsum(moved, axis=0)])
    off = np.hypot(*(r - trajectory.at(times)[0]).T)
    speeds = np.hypot(*v.T)
    top = float(np.hypot(*u_1.T).max(initial=0.0))
    end = float(np.hypot(*(r[-1] - trajectory.course.at(trajectory.length_m))))
    return Flown(end, float(speeds[-1]), float(off.max()), float(speeds.max()), top)
