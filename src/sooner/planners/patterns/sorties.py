"""A pattern cut to sorties: each flies to where the last one left it, along it for as long as it can, and home."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sooner.decomposition.patterns import Tracks
from sooner.errors import InvalidProblemError
from sooner.planners.leg_ground import LegGround
from sooner.problem.leg_moves import place_numbers, places_of

__all__ = ["shared_out"]

_HALVINGS = 14  # of the leg in which a sortie turns home
_TRIED = 40  # places to which a sortie may skip ahead where it cannot reach the next

Route = NDArray[np.float64]


def shared_out(ground: LegGround, tracks: Tracks, numbers: Sequence[int]) -> dict[int, Route]:
    """The routes of sorties that share a pattern in consecutive parts, by their numbers.

    A sortie flies the shortest way to where the one before it turned home, on along the pattern until it only just
    comes home in time, and home. Where the pattern is out of its reach it skips ahead to where it is not; where there
    is no such place, or nothing is left of the pattern, it flies the least it may.

    Parameters
    ----------
    ground : LegGround
    tracks : tuple of (n, 2) float    in the order of flight, within what planners may fly in
    numbers : sequence of int         the searchers, in the order in which they fly
    """
    pattern = _Pattern(ground, tracks)
    routes, at = {}, 0.0
    for number in numbers:
        routes[number], at = pattern.flown(number, at)
    return routes


class _Pattern:
    """One polyline through all tracks, and places on it by the metres flown along it."""

    def __init__(self, ground: LegGround, tracks: Tracks) -> None:
        self.ground = ground
        points = places_of(place_numbers(np.concatenate(tracks))) if tracks else np.zeros((0, 2))
        self.points = _apart(ground.joined(points)) if len(points) else points
        self.points = places_of(place_numbers(self.points)) if len(points) else points
        self.along = np.append(0.0, np.cumsum(np.hypot(*np.diff(self.points, axis=0).T))) if len(points) else None

    def flown(self, number: int, at: float) -> tuple[Route, float]:
        """The route of one sortie that goes on at so many metres, and where the next goes on."""
        least = self.ground.least(number)
        if self.along is None or at >= self.along[-1]:
            return least, at
        begin = self._reached(number, at)
        if begin is None:
            return least, at
        route = self._fitting(number, begin, float(self.along[-1]))
        if route is not None:
            return route, float(self.along[-1])
        corners = self.along[self.along > begin]
        low, high = 0, len(corners) - 1  # the first `low` corners are known to fit, corner `high` not to
        while low < high:
            middle = (low + high) // 2
            if self._fitting(number, begin, float(corners[middle])) is not None:
                low = middle + 1
            else:
                high = middle
        return self._turning_home(number, begin, float(corners[low - 1]) if low else begin, float(corners[low]))

    def _turning_home(self, number: int, begin: float, fits: float, fails: float) -> tuple[Route, float]:
        """Within one leg, the furthest place from which the sortie still comes home in time."""
        best = self._fitting(number, begin, fits)
        assert best is not None
        for _ in range(_HALVINGS):
            middle = (fits + fails) / 2
            route = self._fitting(number, begin, middle)
            if route is None:
                fails = middle
            else:
                best, fits = route, middle
        return best, fits

    def _reached(self, number: int, at: float) -> float | None:
        """Metres to the first place from there on that the sortie can fly to and come home from."""
        assert self.along is not None
        ahead = np.append(at, self.along[self.along > at])
        moves, places = self.ground.moves[number], self._places(ahead)
        far = moves.airspace.metres_from(moves.home, places)
        if moves.end is not None:
            far = far + moves.airspace.metres_from(moves.end, places)
        near = ahead[far / moves.pace.speed_mps <= self.ground.budgets[number]]
        tried = (
            near[np.unique(np.linspace(0, len(near) - 1, min(len(near), _TRIED)).astype(int))] if len(near) else near
        )
        for metres in tried:
            if self._fitting(number, float(metres), float(metres)) is not None:
                return float(metres)
        return None

    def _fitting(self, number: int, begin: float, end: float) -> Route | None:
        """From home along the pattern between two distances, and home; None where that is not in time, or no way is."""
        assert self.along is not None
        moves = self.ground.moves[number]
        between = self.points[(self.along > begin) & (self.along < end)]
        part = places_of(place_numbers(np.concatenate([self._places([begin]), between, self._places([end])])))
        try:
            there = moves.airspace.way(moves.home, part[0])
            back = [] if moves.end is None else [moves.airspace.way(part[-1], moves.end)]
        except InvalidProblemError:
            return None
        route = _apart(places_of(place_numbers(np.concatenate([there, part, *back]))))
        return route if self.ground.seconds(number, route) <= self.ground.budgets[number] else None

    def _places(self, metres: Sequence[float] | NDArray[np.float64]) -> Route:
        assert self.along is not None
        return np.stack([np.interp(metres, self.along, self.points[:, axis]) for axis in (0, 1)], axis=1)


def _apart(points: Route) -> Route:
    """The polyline without places that it is at already; its two ends stay."""
    kept = np.append(True, np.abs(np.diff(points, axis=0)).max(axis=1) > 1e-9)
    out: Route = points[kept]
    return out
