"""Where drones are when: sorties along legs as tracks in place, height and time, up and down among them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.io.flights import FlightPlan
from sooner.missions.leg_flights import homeward, label
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score
from sooner.missions.separation import SAMPLE_S, Track
from sooner.missions.vehicles import Vehicle
from sooner.motion.kinematics import Dynamics
from sooner.motion.pace import Terrain
from sooner.motion.trajectory import Trajectory
from sooner.problem.leg_moves import LegMoves, places_of

__all__ = ["leg_track"]

Floats = NDArray[np.float64]


def leg_track(score: Score, number: int, plan: FlightPlan) -> Track:
    """Where the drone is while it is in the air: up, along its legs, and down."""
    mission, sortie = score.mission, score.mission.sorties[number]
    moves = mission.problem.searchers[number].moves
    assert isinstance(moves, LegMoves)
    assert mission.area is not None
    line = places_of(score.plan.actions[number])
    line = np.concatenate([line, homeward(moves, line)[1]])
    flight = moves.pace.flight(line)
    base_m = plan.home_altitude_m or 0.0
    told_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(mission.area.frame.metres(plan.places), axis=0).T))])
    heights = base_m + np.array([each.altitude_m for each in plan.waypoints])
    times = np.union1d(np.arange(0.0, flight.duration, SAMPLE_S), np.append(flight.knot_s, flight.duration))
    flown_m = flight.metres_at(times)[0]
    level = np.column_stack([flight.course.at(flown_m), np.interp(flown_m, told_m, heights)])
    up = _column(sortie.vehicle, line[0], base_m, heights[0], plan.takeoff_s, True)
    foot_m = base_m if plan.finish == "return" else _foot(mission, line, base_m)
    down = _column(sortie.vehicle, line[-1], foot_m, heights[-1], plan.landing_s, False)
    begun = plan.departs_s + plan.takeoff_s
    parts = [(plan.departs_s, up), (begun, (times, level)), (begun + flight.duration, down)]
    all_s = np.concatenate([begins + each for begins, (each, _) in parts])
    return Track(number, sortie.drone, label(mission, number), all_s, np.concatenate([each for _, (_, each) in parts]))


def _foot(mission: Mission, line: Floats, base_m: float) -> float:
    """Height of the ground where a flight lands."""
    area = mission.area
    if area is None or area.elevation is None:
        return base_m
    return float(Terrain(area.elevation, area.ground.cell_m).heights_at(line[-1:])[0])


def _column(
    vehicle: Vehicle | None, place: Floats, low_m: float, high_m: float, lasts_s: float, up: bool
) -> tuple[Floats, Floats]:
    """Seconds and places, (n, 3), of taking off or landing; no time where nobody knows the vehicle."""
    if vehicle is None or high_m <= low_m:
        return np.zeros(0), np.zeros((0, 3))
    slow_m = 0.0 if up or vehicle.landing_mps is None else min(vehicle.landing_below_m, high_m - low_m)
    speed = vehicle.climb_mps if up else vehicle.descent_mps
    risen = Trajectory.through([[0.0, 0.0], [high_m - low_m - slow_m, 0.0]], Dynamics(speed, vehicle.accel_mps2))
    times = risen.sample(SAMPLE_S)[0]
    metres = risen.metres_at(times)[0]
    if up:
        times, heights = np.append(0.0, lasts_s - risen.duration + times), np.append(low_m, low_m + metres)
    else:
        times, heights = np.append(times, lasts_s), np.append(high_m - metres, low_m)
    return times, np.column_stack([np.broadcast_to(place, (len(times), 2)), heights])
