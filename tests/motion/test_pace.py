"""Time along legs: against `Dynamics` on level ground, against vectors in wind, against small steps over terrain."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.motion import Dynamics, Pace, Terrain
from sooner.motion._pace_kernels import height_at, leg_s, way_s

coordinates = st.integers(-300, 300).map(float)
places = st.tuples(coordinates, coordinates)
ways = st.lists(places, min_size=1, max_size=8).map(np.array)
speeds, accelerations = st.floats(1.0, 20.0), st.one_of(st.floats(0.5, 5.0), st.just(math.inf))


@st.composite
def terrains(draw):
    rows, cols = draw(st.integers(1, 7)), draw(st.integers(1, 7))
    seed = draw(st.integers(0, 2**32 - 1))
    return Terrain(np.random.default_rng(seed).uniform(0, 60, (rows, cols)), draw(st.floats(10.0, 40.0)))


@st.composite
def paces(draw):
    airspeed = draw(st.one_of(st.none(), st.floats(8.0, 20.0)))
    strength, heading = draw(st.floats(0.0, 7.9)), draw(st.floats(-np.pi, np.pi))
    terrain = draw(st.one_of(st.none(), terrains()))
    climb, descent = (draw(st.one_of(st.none(), st.floats(0.5, 5.0))) for _ in range(2))
    wind = (strength * math.cos(heading), strength * math.sin(heading))
    return Pace(draw(speeds), draw(accelerations), airspeed, wind, climb, descent, terrain)


# ---------------------------------------------------------------- level ground


@given(start=places, end=places, speed=speeds, accel=st.floats(0.5, 5.0))
def test_on_level_ground_a_leg_takes_what_bang_bang_takes(start, end, speed, accel):
    expected = Dynamics(speed, accel).leg_seconds([math.dist(start, end)])
    assert Pace(speed, accel).leg_seconds([start], [end]) == pytest.approx(expected, rel=1e-12)


@given(way=ways, speed=speeds)
def test_without_end_of_acceleration_time_is_length_over_speed(way, speed):
    flight = Pace(speed, math.inf).flight(way)
    assert flight.duration == pytest.approx(np.hypot(*np.diff(way, axis=0).T).sum() / speed, rel=1e-12)
    assert flight.at(flight.times)[0] == pytest.approx(way, abs=1e-6)


@given(way=ways, speed=speeds, accel=st.floats(0.5, 5.0))
def test_on_level_ground_a_flight_is_the_one_that_stops_at_turns(way, speed, accel):
    assert Pace(speed, accel).flight(way).duration == pytest.approx(Dynamics(speed, accel).seconds(way, "turns"))


# ---------------------------------------------------------------- the three ways to ask agree


@settings(max_examples=100)
@given(pace=paces(), way=ways)
def test_kernels_legs_and_flights_tell_one_time(pace, way):
    flight = pace.flight(way)
    runs = flight.course.origins, np.vstack([flight.course.origins[1:], way[-1:]])
    legs = pace.leg_seconds(*runs)
    assert legs.sum() == pytest.approx(flight.duration, abs=1e-9)
    assert way_s(way, *pace.arrays()) == pytest.approx(flight.duration, abs=1e-9)
    for start, end, seconds in zip(*runs, legs, strict=True):
        assert leg_s(*start, *end, *pace.arrays()) == pytest.approx(seconds, abs=1e-9)


@settings(max_examples=60)
@given(pace=paces(), way=ways, shares=st.lists(st.floats(0, 1), min_size=1, max_size=5))
def test_it_is_at_its_waypoints_when_it_says(pace, way, shares):
    flight = pace.flight(way)
    assert flight.at(flight.times)[0] == pytest.approx(way, abs=1e-6)
    assert flight.times[0] == 0.0
    assert flight.times[-1] == pytest.approx(flight.duration)
    assert (np.diff(flight.times) >= 0).all()
    flown = np.array(shares) * flight.length_m
    assert flight.metres_at(flight.times_at(flown))[0] == pytest.approx(flown, abs=1e-6)


@settings(max_examples=60)
@given(pace=paces(), way=ways)
def test_speed_and_acceleration_keep_their_limits_and_turns_are_stops(pace, way):
    flight = pace.flight(way)
    assert flight.knot_mps.max() <= pace.speed_mps * (1 + 1e-12)
    if pace.accel_mps2 < math.inf:
        grown = np.abs(np.diff(flight.knot_mps**2))
        assert (grown <= 2 * pace.accel_mps2 * np.diff(flight.knot_m) + 1e-6).all()
        assert flight.at(flight.times_at(flight.course.bounds_m))[1] == pytest.approx(0.0, abs=1e-4)


# ---------------------------------------------------------------- wind


@given(
    end=places.filter(lambda place: place != (0.0, 0.0)),
    airspeed=st.floats(5.0, 15.0),
    share=st.floats(0.0, 0.99),
    heading=st.floats(-np.pi, np.pi),
)
def test_the_ground_speed_closes_the_wind_triangle(end, airspeed, share, heading):
    wind = share * airspeed * np.array([math.cos(heading), math.sin(heading)])
    pace = Pace(1e6, math.inf, airspeed, tuple(wind))
    ground = np.array(end) / pace.leg_seconds([[0, 0]], [end])
    assert np.hypot(*(ground - wind)) == pytest.approx(airspeed)
    slow = Pace(3.0, math.inf, airspeed, tuple(wind))
    assert np.hypot(*ground) < 3.0 or slow.leg_seconds([[0, 0]], [end]) == pytest.approx(math.hypot(*end) / 3.0)


def test_no_leg_is_flown_in_a_wind_as_strong_as_the_airspeed():
    pace = Pace(10.0, 2.0, airspeed_mps=10.0, wind=(6.0, 8.0))
    ends = [[60, 80], [-60, -80], [80, -60], [0, 0]]
    assert pace.leg_seconds(np.zeros((4, 2)), ends).tolist() == [math.inf, math.inf, math.inf, 0.0]
    assert way_s(np.array([[0.0, 0.0], [1.0, 0.0]]), *pace.arrays()) == math.inf
    with pytest.raises(InvalidProblemError, match="a wind of 10 m/s came, and at most 10 m/s through the air"):
        pace.flight([[0, 0], [60, 80]])
    assert Pace(10.0, 2.0, wind=(60.0, 0.0)).leg_seconds([[0, 0]], [[-100, 0]]) == 15.0


# ---------------------------------------------------------------- terrain


def bilinear(terrain, x, y):
    rows, cols = terrain.heights.shape
    row = np.clip(rows - 1 - y / terrain.cell_m, 0, rows - 1)
    col = np.clip(x / terrain.cell_m, 0, cols - 1)
    near_rows = np.maximum(1 - np.abs(np.arange(rows) - row), 0)
    near_cols = np.maximum(1 - np.abs(np.arange(cols) - col), 0)
    return near_rows @ terrain.heights @ near_cols


@given(terrain=terrains(), place=places)
def test_heights_are_bilinear_between_centres_and_the_borders_beyond(terrain, place):
    expected = bilinear(terrain, *place)
    assert terrain.heights_at([place]) == pytest.approx(expected, abs=1e-9)
    assert height_at(*place, terrain.heights, terrain.cell_m) == pytest.approx(expected, abs=1e-9)


@settings(max_examples=60)
@given(terrain=terrains(), start=places, end=places, climb=st.floats(0.5, 3.0), descent=st.floats(0.5, 3.0))
def test_climb_and_descent_hold_all_along(terrain, start, end, climb, descent):
    flight = Pace(15.0, 3.0, climb_mps=climb, descent_mps=descent, terrain=terrain).flight([start, end])
    pieces = max(math.ceil(2 * flight.length_m / terrain.cell_m), 1)
    ends_m = np.linspace(0, flight.length_m, pieces + 1)
    up = np.diff(terrain.heights_at(flight.course.at(ends_m))) / max(flight.length_m, 1e-9) * pieces
    middles = (ends_m[:-1, None] + np.diff(ends_m)[:, None] * np.linspace(0.001, 0.999, 9)).ravel()
    rates = flight.metres_at(flight.times_at(middles))[1] * np.repeat(up, 9)
    assert rates.max(initial=0.0) <= climb * (1 + 1e-6)
    assert -rates.min(initial=0.0) <= descent * (1 + 1e-6)


def small_steps(pace, start, end, n=40_000):
    """Seconds along a leg by small steps: the fastest speeds that neighbouring steps allow."""
    length = math.dist(start, end)
    share = (np.arange(n + 1) / n)[:, None]
    heights = pace.terrain.heights_at(np.array(start) + share * (np.array(end) - np.array(start)))
    step = length / n
    slopes = np.diff(heights) / step
    most = np.minimum(pace.speed_mps, np.where(slopes > 0, pace.climb_mps, pace.descent_mps) / np.abs(slopes + 1e-300))
    squares = np.concatenate([[0.0], np.minimum(most[1:], most[:-1]) ** 2, [0.0]])
    for _ in range(2):  # forwards no faster than it can speed up, then likewise backwards
        for k in range(n):
            squares[k + 1] = min(squares[k + 1], squares[k] + 2 * pace.accel_mps2 * step)
        squares = squares[::-1]
    speed = np.sqrt(squares)
    return (2 * step / (speed[1:] + speed[:-1])).sum()


@pytest.mark.parametrize("seed", range(6))
def test_over_smooth_terrain_the_time_is_that_of_small_steps(seed):
    rng = np.random.default_rng(seed)
    rows, cols, (phase, turn) = *np.indices((30, 30)), rng.uniform(0, 6, 2)
    hills = 40 * np.sin(rows / 3 + phase) * np.cos(cols / 4 + turn) + rng.uniform(0, 5, (30, 30))
    terrain = Terrain(hills, 20.0).smoothed(20.0)
    pace = Pace(12.0, 2.0, climb_mps=2.0, descent_mps=1.5, terrain=terrain)
    start, end = rng.uniform(0, 150, 2), rng.uniform(430, 580, 2)
    seconds = pace.leg_seconds([start], [end])[0]
    assert seconds == pytest.approx(small_steps(pace, start, end), rel=0.02)
    assert seconds > 1.1 * Pace(12.0, 2.0).leg_seconds([start], [end])[0]  # slopes matter here


def test_uphill_the_climb_limits_and_downhill_the_descent():
    slope = Terrain(np.tile(np.arange(50.0), (3, 1)) * 10.0, cell_m=20.0)  # half a metre up for every metre east
    pace = Pace(10.0, math.inf, climb_mps=2.0, descent_mps=1.0, terrain=slope)
    here, there = [[100.0, 20.0]], [[500.0, 20.0]]
    assert pace.leg_seconds(here, there) == pytest.approx(200.0 / 2.0)
    assert pace.leg_seconds(there, here) == pytest.approx(200.0 / 1.0)
    assert Pace(10.0, math.inf, terrain=slope).leg_seconds(here, there) == pytest.approx(40.0)
    assert pace.leg_seconds([[100.0, 0.0]], [[100.0, 40.0]]) == pytest.approx(4.0)  # along the slope


@given(pace=paces(), start=places, end=places)
def test_level_terrain_costs_nothing_and_no_terrain_saves_time(pace, start, end):
    bare = Pace(pace.speed_mps, pace.accel_mps2, pace.airspeed_mps, pace.wind)
    level = Pace(pace.speed_mps, pace.accel_mps2, pace.airspeed_mps, pace.wind, 1.0, 1.0, Terrain(np.ones((4, 5)), 9.0))
    free = bare.leg_seconds([start], [end])[0]
    assert level.leg_seconds([start], [end])[0] == pytest.approx(free, rel=1e-9)
    assert pace.leg_seconds([start], [end])[0] >= free * (1 - 1e-9)


@given(terrain=terrains(), accel=accelerations)
def test_over_terrain_no_flight_takes_longer_than_one_that_stops_at_every_waypoint(terrain, accel):
    pace = Pace(10.0, accel, climb_mps=1.0, descent_mps=1.0, terrain=terrain)
    way = np.array([[0.0, 0.0], [13.0, 26.0], [13.0, 26.0], [20.0, 40.0], [31.0, 62.0], [80.0, 62.0], [95.0, 62.0]])
    taken = way_s(way, *pace.arrays())
    assert taken <= pace.leg_seconds(way[:-1], way[1:]).sum() + 1e-9
    assert pace.flight(way).duration == pytest.approx(taken, rel=1e-9)


@given(terrain=terrains(), radius=st.floats(0, 90), seed=st.integers(0, 1000))
def test_the_smoothed_surface_is_nowhere_beneath_the_ground(terrain, radius, seed):
    smooth = terrain.smoothed(radius)
    points = np.random.default_rng(seed).uniform(-50, 300, (40, 2))
    assert (smooth.heights_at(points) >= terrain.heights_at(points) - 1e-9).all()
    assert smooth.heights.max() <= terrain.heights.max() + 1e-9


def test_smoothing_makes_slopes_gentler():
    rough = Terrain(np.random.default_rng(4).uniform(0, 100, (40, 40)), 20.0)
    steepest = [np.abs(np.diff(each.heights, axis=1)).max() for each in (rough, rough.smoothed(20), rough.smoothed(80))]
    assert steepest[0] > 2 * steepest[1] > 4 * steepest[2]


# ---------------------------------------------------------------- refused


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"speed_mps": 0.0}, "greatest speed of 0.0 m/s"),
        ({"speed_mps": math.inf}, "greatest speed of inf m/s"),
        ({"accel_mps2": math.nan}, "acceleration of nan"),
        ({"airspeed_mps": -1.0}, "greatest airspeed of -1.0"),
        ({"climb_mps": 0.0}, "greatest climb of 0.0"),
        ({"descent_mps": math.inf}, "greatest descent of inf"),
        ({"wind": (math.nan, 0.0)}, "a wind of"),
        ({"wind": (1.0,)}, "a wind of"),
    ],
)
def test_limits_that_are_none_are_refused(fields, message):
    with pytest.raises(InvalidProblemError, match=message):
        Pace(**{"speed_mps": 10.0, "accel_mps2": 2.0, **fields})


def test_places_and_heights_that_are_none_are_refused():
    pace = Pace(10.0, 2.0)
    with pytest.raises(InvalidProblemError, match=r"ends of shape \(1, 3\)"):
        pace.leg_seconds([[0, 0]], [[1, 2, 3]])
    with pytest.raises(InvalidProblemError, match="1 starts and 2 ends"):
        pace.leg_seconds([[0, 0]], [[1, 2], [3, 4]])
    with pytest.raises(InvalidProblemError, match=r"waypoints of shape \(0,\)"):
        pace.flight([])
    for heights, cell_m in ((np.empty((0, 3)), 1.0), (np.full((2, 2), np.nan), 1.0), (np.ones((2, 2)), 0.0)):
        with pytest.raises(InvalidProblemError, match=r"heights of shape|cell size of"):
            Terrain(heights, cell_m)
    with pytest.raises(InvalidProblemError, match="radius of nan"):
        Terrain(np.ones((2, 2)), 1.0).smoothed(math.nan)
