"""A sortie along legs as a flight on the globe: where it turns, how high it is above the ground, and how fast."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sooner.io.flights import FlightPlan, Waypoint
from sooner.io.flights.flight_plan import Finish
from sooner.io.georeference import Georeference
from sooner.io.leg_plans import places_on_globe
from sooner.missions.drawn_fences import drawn_fences
from sooner.missions.mission_file import Mission
from sooner.missions.over_legs import SMOOTHED_CELLS
from sooner.missions.score import Score
from sooner.missions.settings import Place as OnGlobe
from sooner.motion.following import followed
from sooner.motion.kinematics import corners
from sooner.motion.pace import Pace, Terrain
from sooner.problem.leg_moves import LegMoves, places_of

__all__ = ["OFF_M", "Sky", "homeward", "label", "leg_flight"]

OFF_M = 2.0  # from the surface that is followed, by straight lines between waypoints
ALIKE = 0.005  # share by which speeds may differ untold

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sky:
    """The way of one sortie, in metres.

    Parameters
    ----------
    points : (n, 2) float       east and north, where waypoints lie
    heights : (n,) float        above the sea; above home where nobody knows how high that is
    speeds : (n,) float         metres a second on the way to each; the first is the flight's own
    ground_m : float            height of the ground at home, in the same count
    """

    points: Floats
    heights: Floats
    speeds: Floats
    ground_m: float = 0.0


def label(mission: Mission, number: int) -> str:
    """How a sortie is called beside others of its mission."""
    sortie = mission.sorties[number]
    batteries = sum(each.drone == sortie.drone for each in mission.sorties)
    drone = f"drone {sortie.drone}"
    return drone if batteries == 1 else f"{drone}, battery {sortie.battery}"


def leg_flight(score: Score, number: int, ground: Georeference) -> tuple[FlightPlan, tuple[str, ...]]:
    """The flight of one sortie, and what whoever flies it should know."""
    mission = score.mission
    sortie, moves = mission.sorties[number], mission.problem.searchers[number].moves
    assert isinstance(moves, LegMoves)
    said = mission.settings.searcher[sortie.drone]
    line = places_of(score.plan.actions[number])
    finish, home_line, notes = homeward(moves, line)
    sky = _sky(mission, moves, np.concatenate([line, home_line]), sortie.altitude_m)
    places = [(float(lat), float(lon)) for lat, lon in places_on_globe(mission.problem, ground, sky.points)]
    if finish == "land" and isinstance(said.end, OnGlobe):
        places[-1] = (said.end.lat, said.end.lon)
    fenced, fence_notes = drawn_fences(mission, sky.points, finish == "return")
    plan = FlightPlan(
        name=mission.name if len(mission.sorties) == 1 else f"{mission.name}, {label(mission, number)}",
        searcher=number,
        home=(said.start.lat, said.start.lon) if isinstance(said.start, OnGlobe) else places[0],
        waypoints=_waypoints(places, sky, moves.pace.speed_mps),
        finish=finish,
        speed_mps=moves.pace.speed_mps,
        duration_s=moves.seconds(line),
        home_altitude_m=None if mission.area is None or mission.area.elevation is None else sky.ground_m,
        fences=fenced,
        landings=() if finish == "return" else (places[-1],),
        takeoff_s=sortie.takeoff_s,
        landing_s=sortie.landing_s,
        departs_s=max(moves.departs_s - sortie.takeoff_s, 0.0),
    )
    if plan.stays:
        return plan, ("the plan leaves it on the ground: it has no file",)
    return plan, (*notes, *fence_notes)


def _waypoints(places: list[tuple[float, float]], sky: Sky, usual_mps: float) -> tuple[Waypoint, ...]:
    above = np.ceil((sky.heights - sky.ground_m) * 1000.0 - 1e-6) / 1000.0  # files keep millimetres
    told = zip(places, above.tolist(), sky.speeds.tolist(), strict=True)
    return tuple(
        Waypoint(lat, lon, height, None if abs(speed - usual_mps) <= ALIKE * usual_mps else speed)
        for (lat, lon), height, speed in told
    )


def homeward(moves: LegMoves, line: Floats) -> tuple[Finish, Floats, tuple[str, ...]]:
    """How a flight ends, the way home where the plan has none, and what the plan does not count."""
    none = np.zeros((0, 2))
    if moves.end is not None:
        return ("return" if moves.end == moves.home else "land"), none, ()
    if len(line) == 1:
        return "return", none, ()
    way = moves.airspace.way(line[-1], moves.home)[1:]
    metres = float(np.hypot(*np.diff(np.concatenate([line[-1:], way]), axis=0).T).sum())
    seconds = moves.seconds(np.concatenate([line[-1:], way]))
    note = f"the mission has no end, so the plan does not count the {metres:.0f} m, about {seconds:.0f} s, home"
    return "return", way, (note,) if metres >= 1.0 else ()


# ---------------------------------------------------------------- how high, how fast


@dataclass(frozen=True, eq=False)
class _Relief:
    """The ground of a mission, and the surface above it that drones follow."""

    elevation: Floats
    cell_m: float

    @cached_property
    def ground(self) -> Terrain:
        return Terrain(self.elevation, self.cell_m)

    @cached_property
    def surface(self) -> Terrain:
        return self.ground.smoothed(SMOOTHED_CELLS * self.cell_m)


def _sky(mission: Mission, moves: LegMoves, line: Floats, above_m: float) -> Sky:
    """Waypoints where the line turns, and where a straight line would leave the surface that is followed."""
    line = line[corners(line)] if len(line) > 1 else line
    area = mission.area
    if area is None or area.elevation is None:
        return Sky(line, np.full(len(line), above_m), _speeds(moves.pace, line))
    relief = _Relief(area.elevation, area.ground.cell_m)
    surface = moves.pace.terrain or relief.surface
    along, heights = followed(line, surface, relief.ground, above_m, OFF_M)
    flown = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    points = np.column_stack([np.interp(along, flown, line[:, axis]) for axis in (0, 1)])
    return Sky(points, heights, _speeds(moves.pace, points), float(relief.ground.heights_at(line[:1])[0]))


def _speeds(pace: Pace, points: Floats) -> Floats:
    """(n,) float: speed on the way to each place that takes as long as wind and slopes let the plan's drone take.

    v = L / integral of max(1 / cruise, s+ / climb, s- / descent)    s+ and s- the slope of the surface, up and down
    """
    from sooner.motion._pace_kernels import cruise_mps

    speed, _, airspeed, east, north, climb, descent, _, _ = pace.arrays()
    found = np.full(len(points), speed)
    for k, (start, end) in enumerate(pairwise(points), start=1):
        dx, dy = end - start
        length = float(np.hypot(dx, dy))
        if length == 0.0:
            continue
        found[k] = cruise_mps(dx, dy, length, speed, airspeed, east, north)
        if pace.terrain is not None and np.isfinite([climb, descent]).any():
            count = max(int(np.ceil(2.0 * length / pace.terrain.cell_m)), 1)
            shares = np.linspace(0.0, 1.0, count + 1)[:, None]
            rises = np.diff(pace.terrain.heights_at(start + shares * (end - start)))
            vertical = np.maximum(rises / climb, -rises / descent)
            found[k] = length / np.maximum(length / count / found[k], vertical).sum()
    return found
