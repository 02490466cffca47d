"""Separation: flights that are in the air at once keep apart in place or in height, or take off later.

A plan says where each sortie flies and how long that takes; what it is worth does not change if all of a sortie happens
a little later. So delays belong to flights, as height and fences do, and the plan stays as it was judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault

__all__ = ["SAMPLE_S", "STEP_S", "Apart", "Meeting", "Separation", "Track", "closest", "separated"]

STEP_S = 5.0  # of which delays are whole multiples
SAMPLE_S = 0.5  # between places of a track, at most: in between it is straight to within a few centimetres
MOST_TOLD = 50  # pairs

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Track:
    """Where a drone is while it is in the air, as planned.

    Parameters
    ----------
    number : int            of the flight
    drone : int             whose flights follow each other
    name : str
    times : (n,) float      seconds, rising
    places : (n, 3) float   metres east, north and up
    """

    number: int
    drone: int
    name: str
    times: Floats
    places: Floats

    def at(self, times: Floats) -> Floats:
        """(k, 3) float: where it is."""
        return np.column_stack([np.interp(times, self.times, self.places[:, axis]) for axis in range(3)])


@dataclass(frozen=True)
class Apart:
    """How far apart drones are to be: so far on the map, or so far in height.

    Parameters
    ----------
    horizontal_m, vertical_m : float
    wait_s : float or None              longest delay; None: any
    """

    horizontal_m: float
    vertical_m: float
    wait_s: float | None = None


@dataclass(frozen=True)
class Meeting:
    """Where two flights come nearest to each other, distances counted as shares of those that are to be kept.

    Parameters
    ----------
    flights : (int, int)
    time_s : float                      after the first of all take-offs was to be
    horizontal_m, vertical_m : float    then
    place : (float, float)              metres east and north, half way
    share : float                       max(horizontal / to be kept, vertical / to be kept): below 1 it is too near
    """

    flights: tuple[int, int]
    time_s: float
    horizontal_m: float
    vertical_m: float
    place: tuple[float, float]
    share: float


@dataclass(frozen=True)
class Separation:
    """Flights as they are kept apart.

    Parameters
    ----------
    apart : Apart
    delays_s : tuple of float           of each flight
    meetings : tuple of Meeting         of every two flights of different drones that are in the air at once
    planned_s, ends_s : float           when the last lands: by the plan, and with delays
    """

    apart: Apart
    delays_s: tuple[float, ...]
    meetings: tuple[Meeting, ...]
    planned_s: float
    ends_s: float

    def result(self) -> dict[str, Any]:
        """For JSON."""
        nearest = sorted(self.meetings, key=lambda each: each.share)[:MOST_TOLD]
        return {
            "horizontal_m": self.apart.horizontal_m,
            "vertical_m": self.apart.vertical_m,
            "delays_s": list(self.delays_s),
            "planned_s": self.planned_s,
            "operation_s": self.ends_s,
            "closest": [
                {
                    "flights": list(each.flights),
                    "at_s": round(each.time_s, 1),
                    "horizontal_m": round(each.horizontal_m, 1),
                    "vertical_m": round(each.vertical_m, 1),
                }
                for each in nearest
            ],
        }


def closest(a: Track, b: Track, apart: Apart, later_a: float = 0.0, later_b: float = 0.0) -> Meeting | None:
    """Where two tracks are nearest, each put off by some seconds; None where they are never in the air at once.

    Between moments at which either turns both go straight, so that the least distance on the map and the least in
    height are those of points from a line. The two may fall on different moments of half a second: what is told is
    then a little too near.

    Examples
    --------
    >>> east = Track(0, 0, "east", np.array([0.0, 100.0]), np.array([[0.0, 0, 60], [1000, 0, 60]]))
    >>> west = Track(1, 1, "west", np.array([0.0, 100.0]), np.array([[1000.0, 20, 60], [0, 20, 60]]))
    >>> met = closest(east, west, Apart(30.0, 10.0))
    >>> round(met.time_s), round(met.horizontal_m, 1), met.vertical_m, met.share < 1
    (50, 20.0, 0.0, True)
    >>> closest(east, west, Apart(30.0, 10.0), later_b=101.0) is None
    True
    """
    low = max(a.times[0] + later_a, b.times[0] + later_b)
    high = min(a.times[-1] + later_a, b.times[-1] + later_b)
    if low > high:
        return None
    knots = np.concatenate([a.times + later_a, b.times + later_b, np.arange(low, high, SAMPLE_S), [low, high]])
    times = np.unique(knots[(knots >= low) & (knots <= high)])
    here, there = a.at(times - later_a), b.at(times - later_b)
    away = there - here
    flat, share = _least_flat(away[:, :2])
    high_m = _least_high(away[:, 2])
    shares = np.maximum(flat / apart.horizontal_m, high_m / apart.vertical_m)
    k = int(np.argmin(shares))
    after = min(k + 1, len(times) - 1)
    middle = (here + there)[k, :2] / 2 + share[k] * ((here + there)[after, :2] - (here + there)[k, :2]) / 2
    time_s = float(times[k] + share[k] * (times[after] - times[k]))
    place = (float(middle[0]), float(middle[1]))
    return Meeting((a.number, b.number), time_s, float(flat[k]), float(high_m[k]), place, float(shares[k]))


def _least_flat(away: Floats) -> tuple[Floats, Floats]:
    """Least distance between every two samples, and at which share of the time between them."""
    if len(away) == 1:
        return np.hypot(*away.T), np.zeros(1)
    begin, step = away[:-1], np.diff(away, axis=0)
    squares = np.maximum((step**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(-(begin * step).sum(axis=1) / squares, 0.0, 1.0)
    return np.hypot(*(begin + share[:, None] * step).T), share


def _least_high(away: Floats) -> Floats:
    """Least difference in height between every two samples."""
    if len(away) == 1:
        return np.abs(away)
    passed = away[:-1] * away[1:] <= 0
    return np.where(passed, 0.0, np.minimum(np.abs(away[:-1]), np.abs(away[1:])))


def separated(tracks: Sequence[Track], apart: Apart, file: str = "") -> Separation:
    """Delays with which no two drones come too near to each other.

    Flight by flight, as they take off: each waits for the least whole multiple of `STEP_S`, no shorter than its drone
    waits already, with which it keeps clear of all before it. There is always one: when all others have landed.

    Raises
    ------
    DataFormatError         where a flight would have to wait longer than it may: which two, where and when
    """
    delays = dict.fromkeys((track.number for track in tracks), 0.0)
    placed: list[Track] = []
    waits: dict[int, float] = {}
    for track in sorted(tracks, key=lambda each: (each.times[0], each.number)):
        delay, first = waits.get(track.drone, 0.0), None
        while (met := _too_near(track, delay, placed, delays, apart)) is not None:
            first = first or met
            delay = (np.floor(delay / STEP_S) + 1.0) * STEP_S
            if apart.wait_s is not None and delay > apart.wait_s:
                raise DataFormatError(_fault(file, first, tracks, apart))
        delays[track.number] = waits[track.drone] = float(delay)
        placed.append(track)
    ends = max(float(track.times[-1]) + delays[track.number] for track in tracks)
    planned = max(float(track.times[-1]) for track in tracks)
    meetings = tuple(_meetings(tracks, delays, apart))
    return Separation(apart, tuple(delays[track.number] for track in tracks), meetings, planned, ends)


def _too_near(
    track: Track, delay: float, placed: list[Track], delays: dict[int, float], apart: Apart
) -> Meeting | None:
    """The first flight of another drone that this one would come too near to."""
    for other in placed:
        if other.drone != track.drone:
            met = closest(other, track, apart, delays[other.number], delay)
            if met is not None and met.share < 1.0:
                return met
    return None


def _meetings(tracks: Sequence[Track], delays: dict[int, float], apart: Apart) -> Iterator[Meeting]:
    for a, b in combinations(tracks, 2):
        if a.drone != b.drone:
            met = closest(a, b, apart, delays[a.number], delays[b.number])
            if met is not None:
                yield met


def _fault(file: str, met: Meeting, tracks: Sequence[Track], apart: Apart) -> Fault:
    names = {track.number: track.name for track in tracks}
    a, b = (names[number] for number in met.flights)
    where = f"({met.place[0]:.0f} m east, {met.place[1]:.0f} m north)"
    near = f"{met.horizontal_m:.1f} m on the map and {met.vertical_m:.1f} m in height"
    came = f"{a} and {b} come within {near} of each other at {where} after {met.time_s:.0f} s"
    kept = f"{apart.horizontal_m:g} m or {apart.vertical_m:g} m"
    expected = f"expected {kept}: give them heights of their own (searcher.altitude_m), or let one wait longer than "
    return Fault(file, "separation", came, f"{expected}wait_s = {apart.wait_s:g}")
