"""Corners flown as arcs: a drone that need not stop between adjacent plow lines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import turns_rad
from sooner.motion.kinematics import Dynamics, checked_waypoints, corners
from sooner.motion.trajectory import Course, Trajectory

__all__ = ["rounded"]

SHARES = (1.0, 0.7, 0.5, 0.25, 0.1)  # of the largest radius that a corner allows
SHARPEST = 100.0  # tan(turn / 2) above which a turn is a reversal, where the drone stops


class _Choices(NamedTuple):
    """Ways to fly one corner; the first is to stop there."""

    radius: NDArray[np.float64]  # (S,) metres
    speed: NDArray[np.float64]  # (S,) metres per second on the arc
    cut: NDArray[np.float64]  # (S,) metres of both legs that the arc replaces: r tan(turn / 2)
    seconds: NDArray[np.float64]  # (S,) on the arc


def rounded(
    waypoints: ArrayLike, dynamics: Dynamics, radius_m: float | None = None, deviation_m: float = np.inf
) -> Trajectory:
    """The fastest flight along a polyline whose corners may be arcs, among a few radii for each corner.

    arc at a turn of q:  radius r, speed v <= sqrt(a_max r), from r tan(q / 2) before the corner to as much after it
    course leaves the polyline by r (1 - cos(q / 2)), and misses the corner by r (1 / cos(q / 2) - 1)

    These are the circles that connect adjacent plow lines [Kuhlman2017, sec. 5.4, fig. 4]: two quarters, or where the
    lines are close one half circle. The drone keeps its speed on an arc, where |u| = v^2 / r points to the centre,
    and speeds up or slows down on straights only. Radii are chosen for all corners together (dynamic programming over
    radius and speed), speeds then raised to the most that neighbours allow (one pass forwards, one back). To stop
    at every corner is among the choices; so the flight is never slower than `Trajectory.through` with its stops.

    Parameters
    ----------
    waypoints : (n, 2) float       metres east and north, n >= 1
    dynamics : Dynamics
    radius_m : float or None       largest radius allowed; left out, and at most: r_crit, where an arc is flown at v_max
    deviation_m : float            farthest that the course may leave the polyline

    Returns
    -------
    Trajectory                     `times` at a rounded corner are those of the middle of its arc

    Examples
    --------
    >>> drone, plow = Dynamics(2.0, 2.0), [[0, 0], [0, 40], [8.8, 40], [8.8, 0]]
    >>> drone.seconds(plow), round(rounded(plow, drone).duration, 3)
    (47.4, 44.542)
    """
    points = checked_waypoints(waypoints)
    radius_m = dynamics.r_crit if radius_m is None else radius_m
    if not (radius_m >= 0 and deviation_m >= 0):
        raise InvalidProblemError(
            f"a radius of {radius_m} m and a deviation of {deviation_m} m came; expected at least 0"
        )
    bends = corners(points)
    bare = points[bends]
    lengths, turns = np.hypot(*np.diff(bare, axis=0).T), turns_rad(bare)
    if len(turns) == 0:
        return Trajectory.through(points, dynamics, stops="turns")
    choices = [
        _choices(q, before, after, dynamics, min(radius_m, dynamics.r_crit), deviation_m)
        for q, before, after in zip(turns, lengths[:-1], lengths[1:], strict=True)
    ]
    radii = _fastest(choices, lengths, dynamics)
    return _flown(points, bends, lengths, turns, radii, dynamics)


def _choices(
    turn: float, before: float, after: float, dynamics: Dynamics, radius_m: float, deviation_m: float
) -> _Choices:
    """Stop, or radii up to the largest allowed, with half a leg's among them; each at its speed and slower ones."""
    tangent = np.tan(turn / 2)
    bulge = 1.0 - np.cos(turn / 2)
    stop = (np.zeros(1), np.zeros(1))
    if tangent < SHARPEST:
        top = min(radius_m, min(before, after) / tangent)
        if bulge > 0:
            top = min(top, deviation_m / bulge)
        radii = np.unique(np.minimum([*(top * s for s in SHARES), before / tangent / 2, after / tangent / 2], top))
        radii = radii[radii > 1e-9 * dynamics.r_crit]
        speeds = np.minimum(np.sqrt(dynamics.a_max * radii), dynamics.v_max)
        r, v = np.nonzero(np.tri(len(radii), dtype=bool))
        radius, speed = np.append(stop[0], radii[r]), np.append(stop[1], speeds[v])
    else:
        radius, speed = stop
    seconds = np.where(speed > 0, radius * turn / np.where(speed > 0, speed, 1.0), 0.0)
    return _Choices(radius, speed, radius * min(tangent, SHARPEST), seconds)


def _fastest(choices: list[_Choices], lengths: NDArray[np.float64], dynamics: Dynamics) -> NDArray[np.float64]:
    """(m,) float: radius of every corner, best for all together by Bellman's recursion over the corners' choices."""
    best = _leg(dynamics, lengths[0] - choices[0].cut, np.zeros(1), choices[0].speed) + choices[0].seconds
    came = []
    for length, here, there in zip(lengths[1:], choices, choices[1:], strict=False):
        left = length - here.cut[:, None] - there.cut[None, :]
        total = best[:, None] + _leg(dynamics, left, here.speed[:, None], there.speed[None, :])
        came.append(total.argmin(axis=0))
        best = total.min(axis=0) + there.seconds
    best = best + _leg(dynamics, lengths[-1] - choices[-1].cut, choices[-1].speed, np.zeros(1))
    pick = [int(best.argmin())]
    for back in reversed(came):
        pick.append(int(back[pick[-1]]))
    return np.array([corner.radius[k] for corner, k in zip(choices, reversed(pick), strict=True)])


def _leg(
    dynamics: Dynamics, length: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Seconds along straights, infinite where arcs overlap or the speeds lie too far apart."""
    length, start, end = np.broadcast_arrays(np.where(np.abs(length) < 1e-9, 0.0, length), start, end)
    possible = dynamics.reachable(length, start, end)
    seconds = np.full(length.shape, np.inf)
    seconds[possible] = dynamics.leg_seconds(length[possible], start[possible], end[possible])
    return seconds


def _speeds(radii: NDArray[np.float64], straights: NDArray[np.float64], dynamics: Dynamics) -> NDArray[np.float64]:
    """(m + 2,) float: greatest speed at the start, on every arc and at the end that the straights between allow."""
    squares = np.minimum(dynamics.a_max * radii, dynamics.v_max**2)
    squares = np.concatenate([[0.0], squares, [0.0]])
    gains = 2 * dynamics.a_max * straights
    for k, gain in enumerate(gains):
        squares[k + 1] = min(squares[k + 1], squares[k] + gain)
    for k in range(len(gains) - 1, -1, -1):
        squares[k] = min(squares[k], squares[k + 1] + gains[k])
    return np.sqrt(squares)


def _flown(
    points: NDArray[np.float64],
    bends: NDArray[np.intp],
    lengths: NDArray[np.float64],
    turns: NDArray[np.float64],
    radii: NDArray[np.float64],
    dynamics: Dynamics,
) -> Trajectory:
    """The trajectory with these radii: straight, arc, straight, ..., straight; pieces without length left out."""
    bare, steps = points[bends], np.diff(points[bends], axis=0)
    units, m = steps / lengths[:, None], len(radii)
    cuts = radii * np.minimum(np.tan(turns / 2), SHARPEST)
    room = np.concatenate([[0.0], cuts]), np.concatenate([cuts, [0.0]])
    straights = np.maximum(lengths - room[0] - room[1], 0.0)
    straights[straights < 1e-9] = 0.0
    left = np.sign(units[:-1, 0] * units[1:, 1] - units[:-1, 1] * units[1:, 0])
    round_ = radii > 0
    speeds = _speeds(radii, straights, dynamics)
    piece_m, curvature, entry = np.empty(2 * m + 1), np.zeros(2 * m + 1), np.empty(2 * m + 1)
    piece_m[::2], piece_m[1::2] = straights, radii * turns
    curvature[1::2][round_] = left[round_] / radii[round_]
    entry[::2], entry[1::2] = speeds[:-1], speeds[1:-1]
    origins, headings = np.empty((2 * m + 1, 2)), np.repeat(np.arctan2(steps[:, 1], steps[:, 0]), 2)[:-1]
    origins[::2] = bare[:-1] + room[0][:, None] * units
    origins[1::2] = bare[1:-1] - cuts[:, None] * units[:-1]
    bounds = np.concatenate([[0.0], np.cumsum(piece_m)])
    flown = _flown_at(points, bends, room[0], straights, bounds)
    real = piece_m > 0
    course = Course(origins[real], headings[real], curvature[real], np.append(bounds[:-1][real], bounds[-1]))
    deviation = float((radii * (1.0 - np.cos(turns / 2))).max())
    return Trajectory.timed(points, flown, course, dynamics, entry[real], deviation)


def _flown_at(
    points: NDArray[np.float64],
    bends: NDArray[np.intp],
    cut: NDArray[np.float64],
    straights: NDArray[np.float64],
    bounds: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(n,) float: metres flown at each waypoint; what an arc cuts off counts as the arc's nearer end."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    leg = np.clip(np.searchsorted(bends, np.arange(len(points)), "right") - 1, 0, len(straights) - 1)
    flown = bounds[2 * leg] + np.clip(along - along[bends[leg]] - cut[leg], 0.0, straights[leg])
    flown[bends[1:-1]] = (bounds[1:-1:2] + bounds[2:-1:2]) / 2
    flown[bends[-1] :] = bounds[-1]
    return np.asarray(flown)
