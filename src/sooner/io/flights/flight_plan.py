"""A flight as aircraft are told it: where it begins, the places it flies to, how fast, and how it ends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Literal
from uuid import NAMESPACE_URL, uuid5

import numpy as np

from sooner.errors import InvalidProblemError
from sooner.io.georeference import ground_m

__all__ = ["Fence", "Finish", "FlightPlan", "Place", "Waypoint"]

Place = tuple[float, float]
Finish = Literal["return", "land", "loiter"]

MOST_LAT = 89.9  # nearer to a pole longitudes mean little, and the maps of ground stations have ended
HALF_WAY = 180.0  # degrees of longitude between two places: the line between them would go round the wrong way
STRAIGHT_RAD = 0.002  # a turn below this is none: what degrees and projections bend a straight line by is less
MOST_M, MOST_MPS, MOST_HOLD_S = 10_000.0, 1_000.0, 86_400.0


@dataclass(frozen=True)
class Waypoint:
    """A place that is flown to.

    Parameters
    ----------
    lat, lon : float            degrees of WGS 84
    altitude_m : float          above the place where the flight began; below 0 in a valley beneath it
    speed_mps : float or None   on the way to it; None: the flight's
    hold_s : float              seconds to stay there

    Raises
    ------
    InvalidProblemError         if it is no place, or nothing can fly so

    Examples
    --------
    >>> Waypoint(91.0, 11.2, 60.0)
    Traceback (most recent call last):
    ...
    sooner.errors.InvalidProblemError: a latitude of 91.0 came; expected -89.9 to 89.9 degrees
    """

    lat: float
    lon: float
    altitude_m: float
    speed_mps: float | None = None
    hold_s: float = 0.0

    def __post_init__(self) -> None:
        _check_place(self.lat, self.lon)
        _check("an altitude", self.altitude_m, -MOST_M, MOST_M, "metres")
        _check("a hold", self.hold_s, 0.0, MOST_HOLD_S, "seconds")
        if self.speed_mps is not None:
            _check("a speed", self.speed_mps, 0.001, MOST_MPS, "metres a second")


@dataclass(frozen=True)
class Fence:
    """A line around ground that an aircraft must stay in, or out of.

    Parameters
    ----------
    corners : of (lat, lon)     at least three, in order; the last is joined to the first
    inclusion : bool            it must stay in
    """

    corners: tuple[Place, ...]
    inclusion: bool

    def __post_init__(self) -> None:
        if len(self.corners) < 3:
            raise InvalidProblemError(f"a fence of {len(self.corners)} corners came; expected at least 3")
        for lat, lon in self.corners:
            _check_place(lat, lon)
        _check_side(self.corners, "a fence")


@dataclass(frozen=True)
class FlightPlan:
    """One flight of one aircraft.

    It takes off at home, climbs to the first waypoint's altitude, flies straight from waypoint to waypoint, and then
    goes home and lands, lands where it is, or circles there until its pilot lands it.

    Parameters
    ----------
    name : str
    searcher : int                      number of the drone
    home : (lat, lon)                   where it takes off
    waypoints : of Waypoint             at least one
    finish : str                        "return", "land" or "loiter"
    speed_mps : float or None           of the flight; None: the aircraft's own
    duration_s : float or None          of what is planned, without a way home that is not
    takeoff_s, landing_s : float        before and after that, from motors on to motors off; 0 where nobody knows
    departs_s : float                   when it takes off, after the first of all flights was to
    home_altitude_m : float or None     of home, above the sea; None where nobody knows
    fences : of Fence
    landings : of (lat, lon)            where else it may come down
    kind : str                          "copter" or "fixed_wing"

    Raises
    ------
    InvalidProblemError                 if there is no waypoint, a number makes no sense, or the date line is crossed

    Examples
    --------
    >>> flight = FlightPlan("ridge", 0, (46.0, 11.0), (Waypoint(46.0, 11.0, 60.0), Waypoint(46.001, 11.0, 60.0)))
    >>> round(flight.length_m, 1)
    111.2
    """

    name: str
    searcher: int
    home: Place
    waypoints: tuple[Waypoint, ...]
    finish: Finish = "return"
    speed_mps: float | None = None
    duration_s: float | None = None
    home_altitude_m: float | None = None
    fences: tuple[Fence, ...] = ()
    landings: tuple[Place, ...] = ()
    kind: Literal["copter", "fixed_wing"] = "copter"
    takeoff_s: float = 0.0
    landing_s: float = 0.0
    departs_s: float = 0.0

    def __post_init__(self) -> None:
        if not self.waypoints:
            raise InvalidProblemError("a flight without waypoints came; expected at least one")
        for lat, lon in (self.home, *self.landings):
            _check_place(lat, lon)
        _check_side([self.home, *self.places, *self.landings], "a flight")
        if self.speed_mps is not None:
            _check("a speed", self.speed_mps, 0.001, MOST_MPS, "metres a second")
        if self.duration_s is not None:
            _check("a duration", self.duration_s, 0.0, np.inf, "seconds")
        for name in ("takeoff_s", "landing_s", "departs_s"):
            _check(name, getattr(self, name), 0.0, np.inf, "seconds")
        if self.home_altitude_m is not None:
            _check("the altitude of home", self.home_altitude_m, -MOST_M, MOST_M, "metres")

    @property
    def places(self) -> tuple[Place, ...]:
        """Where its waypoints lie."""
        return tuple((waypoint.lat, waypoint.lon) for waypoint in self.waypoints)

    @property
    def length_m(self) -> float:
        """Metres over ground from the first waypoint to the last."""
        return float(ground_m(self.places).sum())

    @property
    def stays(self) -> bool:
        """Whether it goes nowhere: its drone is left on the ground."""
        return self.duration_s == 0.0 and len(set(self.places)) == 1

    @property
    def height(self) -> str:
        """How high it flies, in words.

        >>> FlightPlan("ridge", 0, (46.0, 11.0), (Waypoint(46.0, 11.0, 60.0), Waypoint(46.1, 11.0, 75.2))).height
        '60 to 75 m above home'
        """
        heights = [each.altitude_m for each in self.waypoints]
        low, high = min(heights), max(heights)
        return f"{low:g} m above home" if low == high else f"{low:.0f} to {high:.0f} m above home"

    @property
    def passed(self) -> tuple[bool, ...]:
        """Whether each waypoint is passed without a stop: between two others, straight ahead, and not held.

        >>> line = [Waypoint(46.0 + k * 0.001, 11.0, 60.0 + k) for k in range(3)]
        >>> FlightPlan("ridge", 0, (46.0, 11.0), (*line, Waypoint(46.002, 11.002, 60.0))).passed
        (False, True, False, False)
        """
        lat, lon = np.array(self.places).T
        north, east = np.diff(lat), np.diff(lon) * np.cos(np.radians(lat[:-1] + lat[1:]) / 2)
        turned = east[:-1] * north[1:] - north[:-1] * east[1:]
        ahead = east[:-1] * east[1:] + north[:-1] * north[1:]
        straight = np.abs(np.arctan2(turned, ahead)) < STRAIGHT_RAD
        moved = np.hypot(north, east) > 0
        kept = straight & moved[:-1] & moved[1:]
        waits = [each.hold_s > 0 for each in self.waypoints[1:-1]]
        between = [bool(on) and not wait for on, wait in zip(kept, waits, strict=True)]
        return (False, *between, False)[: len(self.waypoints)]

    @property
    def speeds(self) -> Iterator[float | None]:
        """How fast each waypoint is flown to."""
        return (self.speed_mps if each.speed_mps is None else each.speed_mps for each in self.waypoints)

    def identifier(self, part: str) -> str:
        """A name for a part of it that nothing else has, and that is the same whenever the same flight is written."""
        flown = f"sooner {self.name} {self.searcher} {self.home} {self.places} {part}"
        return str(uuid5(NAMESPACE_URL, flown.encode("utf-8", "backslashreplace").decode()))


def _check(name: str, came: float, least: float, most: float, unit: str) -> None:
    if not (isfinite(came) and least <= came <= most):
        within = f"{least:g} to {most:g}" if isfinite(most) else f"at least {least:g}"
        raise InvalidProblemError(f"{name} of {came} came; expected {within} {unit}")


def _check_place(lat: float, lon: float) -> None:
    _check("a latitude", lat, -MOST_LAT, MOST_LAT, "degrees")
    _check("a longitude", lon, -180.0, 180.0, "degrees")


def _check_side(places: list[Place] | tuple[Place, ...], what: str) -> None:
    """All places lie on one side of the date line, as far as formats that know no other can tell."""
    lons = [lon for _, lon in places]
    if max(lons) - min(lons) > HALF_WAY:
        came = f"{what} with longitudes from {min(lons):g} to {max(lons):g} came"
        raise InvalidProblemError(f"{came}; expected all on one side of the date line")
