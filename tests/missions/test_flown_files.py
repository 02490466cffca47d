"""Told durations against an autopilot of small steps that reads nothing but the exported file."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sooner.io.flights import FlightPlan, Waypoint
from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.qgroundcontrol import qgroundcontrol_plan
from sooner.missions import read_mission, score_plan
from sooner.missions.flight_plans import flights
from sooner.missions.over_regions import dynamics_of
from sooner.missions.vehicles import Vehicle
from sooner.missions.winds import WindSettings
from sooner.motion import Dynamics, Pace, Terrain
from sooner.planners import solve
from sooner.planners.registry import make_planner
from tests.georeferenced import DOLOMITES, greedily, hills, located, over_regions, rocks
from tests.oracles.flown_file import Limits, fly_file

CLOSE = 0.01  # relative; small steps and rounded stops are worth less than that


def flown(folder, plan, limits):
    path = folder / f"{plan.searcher}.plan"
    path.write_bytes(qgroundcontrol_plan(plan, Aircraft()))
    return fly_file(path, limits)


def limits_of(pace: Pace, **others):
    unlimited = {"climb": pace.climb_mps or 5.0, "descent": pace.descent_mps or 5.0}
    return Limits(pace.accel_mps2, **unlimited, airspeed=pace.airspeed_mps or math.inf, wind=pace.wind, **others)


def told(points, speed, heights=60.0, finish="return"):
    """A flight through points of a grid's frame: metres east and north of its south-west cell's centre."""
    rows, cols = 99 - np.asarray(points)[:, 1] / 24.0, np.asarray(points)[:, 0] / 24.0
    places = DOLOMITES.places(np.column_stack([rows, cols]))
    heights = np.broadcast_to(heights, len(places)).tolist()
    waypoints = tuple(Waypoint(lat, lon, height) for (lat, lon), height in zip(places.tolist(), heights, strict=True))
    landings = () if finish == "return" else (tuple(places[-1].tolist()),)
    return FlightPlan("test", 0, tuple(places[0].tolist()), waypoints, finish, speed, landings=landings)


def ridges(rng):
    """Hills of up to some 250 m, a few hundred metres apart."""
    rows, cols = np.indices((63, 63))
    hills = [
        height * np.exp(-((rows - row) ** 2 + (cols - col) ** 2) / (2 * width**2))
        for row, col, width, height in rng.uniform([0, 0, 5, 50], [63, 63, 10, 150], (12, 4))
    ]
    return Terrain(np.sum(hills, axis=0), 24.0)


# ---------------------------------------------------------------- the autopilot itself


@pytest.mark.parametrize(("length", "speed", "accel"), [(400.0, 10.0, 2.0), (30.0, 10.0, 1.0), (5.0, 12.0, 3.0)])
def test_small_steps_fly_a_leg_as_long_as_the_textbook_says(tmp_path, length, speed, accel):
    told_plan = told([[0, 0], [length, 0]], speed)
    done = flown(tmp_path, told_plan, Limits(accel, 5.0, 5.0))
    assert done.between_s == pytest.approx(float(Dynamics(speed, accel).leg_seconds(length)), rel=0.01, abs=0.1)
    assert done.metres == pytest.approx(2 * length, rel=1e-3)  # and home
    assert done.top["speed"] <= speed * 1.001
    assert done.top["accel"] <= accel * 1.001


def test_it_stops_where_the_line_turns_and_flies_on_where_it_does_not(tmp_path):
    straight = flown(tmp_path, told([[0, 0], [100, 0], [200, 0], [300, 0]], 10.0), Limits(2.0, 5.0, 5.0))
    bent = flown(tmp_path, told([[0, 0], [100, 0], [100, 100], [200, 100]], 10.0), Limits(2.0, 5.0, 5.0))
    assert straight.between_s == pytest.approx(35.0, rel=0.01)
    assert bent.between_s == pytest.approx(45.0, rel=0.01)


def test_it_does_not_stop_to_change_its_speed(tmp_path):
    plan = told([[0, 0], [100, 0], [200, 0]], 10.0)
    slow = replace(plan, waypoints=(*plan.waypoints[:2], replace(plan.waypoints[2], speed_mps=5.0)))
    seconds = (5.0 + 5.625 + 2.5) + (18.75 + 2.5)  # up to 10 m/s, on, down to 5; on, and to a stop
    assert flown(tmp_path, slow, Limits(2.0, 5.0, 5.0)).between_s == pytest.approx(seconds, rel=0.01)


# ---------------------------------------------------------------- durations that are told


@pytest.mark.parametrize("end", ["", "end = [3, 3]\n", "end = [10, 14]\n"])
@pytest.mark.parametrize("area", ["", 'obstacles = "rocks.tif"'])
def test_missions_over_regions_take_what_they_say(tmp_path, end, area):
    text = over_regions(f"start = [3, 3]\n{end}", area=area)
    score = greedily(read_mission(located(tmp_path, text, 0.05 + 0.45 * hills(), rocks=rocks())))
    (plan,) = flights(score).plans
    drone = dynamics_of(score.mission.settings, 0)
    done = flown(tmp_path, plan, Limits(drone.a_max, 3.0, 3.0))
    assert done.between_s == pytest.approx(plan.duration_s, rel=CLOSE)
    assert (done.top["speed"], done.top["accel"]) <= (drone.v_max * 1.001, drone.a_max * 1.001)
    if end:
        assert done.between_s == pytest.approx(score.durations[0], rel=CLOSE)


LEGS = """
[area]
poc = "poc.tif"
obstacles = "rocks.tif"
[sensor]
glimpse = 1
radius_m = 20.0
[[searcher]]
moves = "legs"
start = [3, 3]
vehicle = "drone.toml"
batteries = 2
altitude_m = 60
[wind]
speed_mps = 6
from_deg = 240
[budget]
seconds = 1000
"""

DRONE = """
speed_mps = 10
accel_mps2 = 2
airspeed_mps = 14
climb_mps = 4
descent_mps = 2
endurance_s = 400
reserve = 0.2
swap_s = 60
"""


def test_sorties_along_legs_in_wind_take_what_they_say_and_keep_the_reserve(tmp_path):
    (tmp_path / "drone.toml").write_text(DRONE)
    mission = read_mission(located(tmp_path, LEGS, hills(), rocks=rocks()))
    plan = solve(mission.problem, make_planner("parallel-track")).best.plan
    made = flights(score_plan(mission, plan)).plans
    assert len(made) == 2
    for flight, searcher in zip(made, mission.problem.searchers, strict=True):
        done = flown(tmp_path, flight, limits_of(searcher.moves.pace))
        assert done.between_s == pytest.approx(flight.duration_s, rel=CLOSE)
        assert done.whole_s <= (400 - 80) * 1.005


@pytest.mark.parametrize("seed", range(4))
def test_a_pace_in_wind_is_what_small_steps_fly(tmp_path, seed):
    rng = np.random.default_rng(seed)
    wind = WindSettings(speed_mps=rng.uniform(2, 9), from_deg=rng.uniform(0, 360)).blows_to
    pace = Pace(rng.uniform(8, 14), rng.uniform(1, 3), airspeed_mps=rng.uniform(10, 15), wind=wind)
    points = rng.uniform(0, 1500, (8, 2))
    done = flown(tmp_path, told(points, pace.speed_mps), limits_of(pace))
    assert done.between_s == pytest.approx(pace.flight(points).duration, rel=CLOSE)
    assert done.top["air"] <= pace.airspeed_mps * 1.01


@pytest.mark.parametrize("seed", range(4))
def test_a_pace_over_terrain_is_what_small_steps_fly(tmp_path, seed):
    rng = np.random.default_rng(seed)
    wind = (rng.uniform(-5, 5), rng.uniform(-5, 5))
    surface = ridges(rng).smoothed(48.0)
    pace = Pace(12.0, 2.0, 14.0, wind, climb_mps=2.5, descent_mps=1.5, terrain=surface)
    corners = rng.uniform(0, 1480, (6, 2))
    flight = pace.flight(corners)
    along = np.union1d(np.arange(0.0, flight.length_m, 24.0), flight.course.bounds_m)
    points = flight.course.at(along)
    heights = 300.0 + surface.heights_at(points) - surface.heights_at(points[:1])
    done = flown(tmp_path, told(points, pace.speed_mps, heights), limits_of(pace))
    assert done.between_s == pytest.approx(flight.duration, rel=CLOSE)
    assert done.between_s > 1.1 * Pace(12.0, 2.0, 14.0, wind).flight(corners).duration  # slopes matter here
    assert (done.top["climb"], done.top["descent"]) <= (2.5 * 1.001, 1.5 * 1.001)
    assert done.top["off"] < 3.0


@pytest.mark.parametrize("finish", ["return", "land"])
@pytest.mark.parametrize("altitude", [40.0, 110.0])
def test_a_vehicle_takes_off_and_lands_in_the_time_that_it_keeps_for_that(tmp_path, finish, altitude):
    vehicle = Vehicle("any", 12.0, 2.0, 4.0, 3.0, 1800.0, 300.0, 15.0, landing_mps=0.5, landing_below_m=10.0)
    pace = vehicle.pace(altitude, wind=(5.0, -3.0))
    points = np.array([[0.0, 0.0], [600.0, 200.0], [300.0, 700.0], *([[0.0, 0.0]] if finish == "return" else [])])
    plan = told(points, vehicle.speed_mps, altitude, finish)
    done = flown(tmp_path, plan, limits_of(pace, landing=(0.5, 10.0)))
    up_and_down = vehicle.climb_s(altitude) + vehicle.landing_s(altitude)
    assert done.between_s == pytest.approx(pace.flight(points).duration, rel=CLOSE)
    assert done.whole_s - done.between_s == pytest.approx(up_and_down, rel=CLOSE)
