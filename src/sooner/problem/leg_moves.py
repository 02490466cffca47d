"""Moves along legs: straight from place to place, with honest time, and the sensor's swath swept along."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InfeasibleProblemError, InvalidProblemError
from sooner.grid.airspace import KEPT_M, Airspace
from sooner.motion.pace import Pace
from sooner.motion.trajectory import Trajectory
from sooner.motion.wind import check_wind
from sooner.problem.moves import Looks
from sooner.sensors.swath import Swath

if TYPE_CHECKING:
    from sooner.grid import Grid
    from sooner.problem.search_problem import Searcher

__all__ = ["LegMoves", "place_numbers", "places_of"]

ROUNDING_S = 1e-6  # a plan may be so much longer than its budget, because sums of seconds are rounded
_HALF, _BITS = 1 << 30, 31  # places as far as 10,000 km to either side


def place_numbers(points: ArrayLike) -> NDArray[np.int64]:
    """Places as the actions of a plan: whole centimetres east and north, in one number each.

    Parameters
    ----------
    points : (n, 2) float       metres east and north of the south-west cell's centre

    Raises
    ------
    InvalidProblemError         if a place is not finite, or farther off than 10,000 km

    Examples
    --------
    >>> places_of(place_numbers([[12.344, -3.0]]))
    array([[12.34, -3.  ]])
    """
    kept = np.rint(np.asarray(points, np.float64).reshape(-1, 2) / KEPT_M)
    if not (np.abs(kept) < _HALF).all():
        raise InvalidProblemError("a place came that is not finite or farther off than 10,000 km; expected metres")
    east, north = kept.astype(np.int64).T + _HALF
    return np.asarray((north << _BITS) | east)


def places_of(actions: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n, 2) float: the places that actions stand for; undoes `place_numbers`."""
    east, north = (actions & ((1 << _BITS) - 1)) - _HALF, (actions >> _BITS) - _HALF
    return np.stack([east, north], axis=-1) * KEPT_M


@dataclass(frozen=True, eq=False)
class LegMoves:
    """One sortie: straight legs from its home to where it lands, within the airspace and its budget of seconds.

    An action is a place, kept to the centimetre (`place_numbers`); a plan is the places in order, home first. Time is
    that of the flown legs: the drone speeds up, brakes, stops wherever it turns, and is slowed by wind and slopes.

    Parameters
    ----------
    airspace : Airspace
    pace : Pace                     how fast legs are flown
    swath : Swath                   what they see
    home : (float, float)           metres east and north: where it takes off
    end : (float, float) or None    where it lands; None: anywhere
    departs_s : float               when its first leg begins, after the first of all sorties began

    Raises
    ------
    InvalidProblemError             if a place does not lie in the airspace
    """

    airspace: Airspace
    pace: Pace
    swath: Swath
    home: tuple[float, float]
    end: tuple[float, float] | None = None
    departs_s: float = 0.0

    def __post_init__(self) -> None:
        for name in ("home", "end"):
            place = getattr(self, name)
            if place is None:
                continue
            kept = places_of(place_numbers(place))[0]
            if not self.airspace.sees(kept[None])[0]:
                raise InvalidProblemError(
                    f"{name} at {kept.round(2).tolist()} m came, which does not lie in the airspace, or within a "
                    "margin of its border; move it, or give a smaller margin"
                )
            object.__setattr__(self, name, (float(kept[0]), float(kept[1])))
        if not (np.isfinite(self.departs_s) and self.departs_s >= 0):
            raise InvalidProblemError(f"departs_s = {self.departs_s} came; expected seconds of at least 0")

    def check(self, grid: Grid, searcher: Searcher) -> None:
        """Seconds, and enough of them to get from home to the end; a wind that can be flown in."""
        if not (np.isfinite(searcher.budget) and searcher.budget > 0):
            raise InvalidProblemError(f"a budget of {searcher.budget} s came; expected a positive number")
        if len(self.swath.strength) != grid.n_cells:
            raise InvalidProblemError(
                f"a swath over {len(self.swath.strength)} cells came; the grid has {grid.n_cells}"
            )
        check_wind(self.pace.airspeed_mps, self.pace.wind)
        if self.end is None:
            return
        try:
            least = self.seconds(self.airspace.way(self.home, self.end))
        except InvalidProblemError as error:
            raise InfeasibleProblemError(str(error)) from None
        if least > searcher.budget + ROUNDING_S:
            raise InfeasibleProblemError(f"the way home alone takes {least:.1f} s; the budget is {searcher.budget:g} s")

    def n_items(self, grid: Grid) -> int:
        """One row for each cell."""
        return grid.n_cells

    def flight(self, actions: NDArray[np.int64]) -> Trajectory:
        """The actions as they are flown."""
        return self.pace.flight(places_of(actions))

    def seconds(self, points: ArrayLike) -> float:
        """How long a polyline, (n, 2) metres, takes from rest to rest; inf where it cannot be flown."""
        from sooner.motion._pace_kernels import way_s

        return float(way_s(np.ascontiguousarray(points, np.float64), *self.pace.arrays()))

    def fault(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> str | None:
        """Why these places cannot be flown, or None if they can."""
        if actions.ndim != 1 or len(actions) == 0:
            return "it has no places; expected at least its home"
        points = places_of(actions)
        for which, name, at in ((0, "starts", self.home), (-1, "ends", self.end)):
            if at is not None and np.abs(points[which] - at).max() > KEPT_M / 2:
                wanted = "its home is" if which == 0 else "it must land"
                return f"it {name} at {_told(points[which])}; {wanted} at {_told(np.asarray(at))}"
        leaves = self.airspace.leaves(points)
        if leaves is not None:
            last = min(leaves + 1, len(points) - 1)
            return (
                f"leg {leaves + 1}, from {_told(points[leaves])} to {_told(points[last])}, leaves the area, enters a "
                "no-fly zone, or comes within the margin of one"
            )
        seconds = self.seconds(points)
        if not np.isfinite(seconds):
            return "a leg cannot be flown: the wind or the slope along it is more than the aircraft can do"
        if seconds > searcher.budget + ROUNDING_S:
            return f"it takes {seconds:.1f} s; the budget is {searcher.budget:g} s"
        return None

    def looks(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> Looks:
        """Effort on every cell in view of a leg, when it is nearest to it; at last, landed, a look worth nothing."""
        cells, effort, at_m = self.swath.effort(grid, places_of(actions))
        flight = self.flight(actions)
        times = np.append(flight.times_at(at_m), flight.duration)
        return Looks(np.append(cells, 0), self.departs_s + times, np.append(effort, 0.0))


def _told(place: NDArray[np.float64]) -> str:
    return f"({place[0]:.2f} m east, {place[1]:.2f} m north)"
