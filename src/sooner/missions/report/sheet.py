"""What a pilot needs of one flight: where it begins, every leg, when, how high, and what is left in the battery."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, degrees, radians, sin

import numpy as np
from numpy.typing import NDArray

from sooner.io.flights import FlightPlan
from sooner.io.georeference import Georeference, ground_m
from sooner.missions.fleet import Sortie
from sooner.missions.flight_plans import Flights
from sooner.missions.over_regions import dynamics_of
from sooner.missions.report.lines import Line, flown_lines, name_of
from sooner.missions.score import Score
from sooner.motion.kinematics import corners
from sooner.problem import CellMoves
from sooner.problem.leg_moves import LegMoves

__all__ = ["Sheet", "Stop", "sheets"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stop:
    """A place that is flown to.

    Parameters
    ----------
    at : (float, float) or None         latitude and longitude, where they are known
    metres : (float, float)             east and north of the south-west cell's centre
    leg_m : float                       from the place before
    bearing_deg : float or None         clockwise from north; None where there is no leg
    altitude_m : float or None          above home
    speed_mps : float or None           on the way to it
    time_s : float or None              since its first leg began; None where nobody knows the speed
    hold_s : float
    """

    at: tuple[float, float] | None
    metres: tuple[float, float]
    leg_m: float
    bearing_deg: float | None
    altitude_m: float | None
    speed_mps: float | None
    time_s: float | None
    hold_s: float = 0.0


@dataclass(frozen=True, eq=False)
class Sheet:
    """One flight as its pilot is told it.

    Parameters
    ----------
    name : str
    stops : of Stop                     the first where its legs begin
    flight : FlightPlan or None         as exported; None where the map has no place on the globe
    sortie : Sortie or None             along legs
    departs_s : float                   take-off, since the search began, as its file says
    waits_s : float                     of that, so that it keeps apart from others: no plan counts it
    flying_s : float or None            on legs, by the plan; without a way home that is not planned
    notes : of str                      what whoever flies it should know
    """

    name: str
    stops: tuple[Stop, ...]
    flight: FlightPlan | None
    sortie: Sortie | None
    departs_s: float
    waits_s: float
    flying_s: float | None
    notes: tuple[str, ...]

    @property
    def length_m(self) -> float:
        """Metres over ground from the first place to the last."""
        return sum(stop.leg_m for stop in self.stops)

    @property
    def flies(self) -> bool:
        """Whether it leaves the ground at all."""
        return self.length_m > 0.0 or self.flying_s != 0.0

    @property
    def airborne_s(self) -> float | None:
        """From motors on to motors off, as far as it is known."""
        if self.flying_s is None or not self.flies:
            return self.flying_s
        return self.flying_s + (0.0 if self.sortie is None else self.sortie.takeoff_s + self.sortie.landing_s)

    @property
    def legs_end_s(self) -> float:
        """When it has flown its last leg, since the search began."""
        return self.departs_s + (0.0 if self.sortie is None else self.sortie.takeoff_s) + (self.flying_s or 0.0)

    @property
    def path(self) -> Floats:
        """(n, 2) float: its places, metres east and north."""
        return np.array([stop.metres for stop in self.stops])


def sheets(score: Score, told: Flights | None) -> tuple[Sheet, ...]:
    """A sheet for each flight of the plan: from its export where there is one, else from the plan itself."""
    lines = flown_lines(score)
    return tuple(_sheet(score, number, line, told) for number, line in enumerate(lines))


def _sheet(score: Score, number: int, line: Line, told: Flights | None) -> Sheet:
    mission = score.mission
    sortie = mission.sorties[number] if mission.sorties else None
    moves = mission.problem.searchers[number].moves
    begins = moves.departs_s if isinstance(moves, LegMoves) else 0.0
    departs, waits = max(begins - (0.0 if sortie is None else sortie.takeoff_s), 0.0), 0.0
    if told is not None:
        plan = told.plans[number]
        departs, waits = plan.departs_s, 0.0 if told.separation is None else told.separation.delays_s[number]
        notes = (*told.own[number], *told.shared)
        stops, flying = _of_flight(score, number, plan), plan.duration_s
    else:
        plan, notes = None, ()
        stops = _of_line(score, line, begins)
        flying = None if score.durations is None else score.durations[number]
    return Sheet(name_of(mission, number), stops, plan, sortie, departs, waits, flying, notes)


def _of_flight(score: Score, number: int, plan: FlightPlan) -> tuple[Stop, ...]:
    """The waypoints of an export."""
    ground = score.mission.ground
    assert ground is not None
    places = np.array(plan.places)
    points = _metres(score, ground, places)
    times = _times(score, number, points, np.array([each.hold_s for each in plan.waypoints]))
    lengths = np.append(0.0, ground_m(places))
    speeds = tuple(plan.speeds)
    return tuple(
        Stop(
            plan.places[k],
            (float(points[k, 0]), float(points[k, 1])),
            float(lengths[k]),
            _bearing(plan.places[k - 1], plan.places[k]) if lengths[k] > 0 else None,
            waypoint.altitude_m,
            speeds[k] if k else None,
            None if times is None else float(times[k]),
            waypoint.hold_s,
        )
        for k, waypoint in enumerate(plan.waypoints)
    )


def _metres(score: Score, ground: Georeference, places: Floats) -> Floats:
    """(n, 2) float: metres east and north in the frame of the grid, of latitudes and longitudes."""
    grid = score.mission.problem.grid
    rows, cols = ground.cells(places).T
    return np.column_stack([cols, grid.shape[0] - 1 - rows]) * grid.cell_m


def _times(score: Score, number: int, points: Floats, hold_s: Floats) -> Floats | None:
    """(n,) float: seconds until each waypoint is reached, as the plan counts them."""
    mission, moves = score.mission, score.mission.problem.searchers[number].moves
    if isinstance(moves, LegMoves):
        return moves.pace.flight(points).times
    steps = np.abs(np.diff(points, axis=0))
    if isinstance(moves, CellMoves):
        if mission.step_s is None:
            return None
        legs = steps.max(axis=1, initial=0.0) / mission.problem.grid.cell_m * mission.step_s
    else:
        legs = dynamics_of(mission.settings, number).leg_seconds(np.hypot(*steps.T))
    return np.append(0.0, np.cumsum(legs + hold_s[:-1]))


def _of_line(score: Score, line: Line, begins: float) -> tuple[Stop, ...]:
    """The turns of a plan that no map places on the globe."""
    kept = corners(line.points)
    points, unit = line.points[kept], score.mission.unit_s
    steps = np.diff(points, axis=0)
    lengths = np.append(0.0, np.hypot(*steps.T))
    found = []
    for k, point in enumerate(points):
        bearing = degrees(atan2(*steps[k - 1])) % 360.0 if lengths[k] > 0 else None
        time_s = None if unit is None else (float(line.times[kept[k]]) - begins) * unit
        found.append(Stop(None, (float(point[0]), float(point[1])), float(lengths[k]), bearing, None, None, time_s))
    return tuple(found)


def _bearing(here: tuple[float, float], there: tuple[float, float]) -> float:
    """Degrees clockwise from true north in which a leg begins, on a sphere.

    >>> round(_bearing((46.0, 11.0), (46.0, 11.01)), 1)
    90.0
    """
    (lat, lon), (lat_there, lon_there) = ((radians(each) for each in place) for place in (here, there))
    across = sin(lon_there - lon) * cos(lat_there)
    up = cos(lat) * sin(lat_there) - sin(lat) * cos(lat_there) * cos(lon_there - lon)
    return degrees(atan2(across, up)) % 360.0
