import itertools
from importlib import import_module

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.motion import Dynamics, Trajectory, integrated, rounded
from tests.motion.test_trajectory import drones, ways


def to_polyline(points: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Distance of every point to a polyline, by projection onto each leg."""
    if len(way) == 1:
        return np.hypot(*(points - way[0]).T)
    least = np.full(len(points), np.inf)
    for a, b in itertools.pairwise(way):
        t = np.clip(((points - a) @ (b - a)) / max((b - a) @ (b - a), 1e-300), 0, 1)
        least = np.minimum(least, np.hypot(*(points - a - t[:, None] * (b - a)).T))
    return least


def plow(lines: int = 6, length: float = 40.0, spacing: float = 8.8) -> np.ndarray:
    ends = [[(k * spacing, 0.0), (k * spacing, length)][:: 1 if k % 2 == 0 else -1] for k in range(lines)]
    return np.array(ends).reshape(-1, 2)


@settings(max_examples=60)
@given(way=ways, drone=drones, deviation=st.sampled_from([0.0, 0.3, np.inf]))
def test_never_slower_than_stopping_within_limits_and_as_near_as_it_says(way, drone, deviation) -> None:
    flight = rounded(way, drone, deviation_m=deviation)
    assert flight.duration <= drone.seconds(way, "turns") * (1 + 1e-9)
    flown = integrated(flight, dt=0.01)
    assert max(flown.end_m, flown.end_mps, flown.off_m) < 1e-3
    assert flown.top_mps <= drone.v_max * (1 + 1e-4)
    assert flown.top_mps2 <= drone.a_max * (1 + 1e-6)
    off = to_polyline(flight.sample(0.02)[1], way).max()
    assert off <= flight.deviation_m + 1e-6
    assert flight.deviation_m <= deviation + 1e-9
    assert (np.diff(flight.times) >= -1e-9).all()
    assert flight.times[-1] == pytest.approx(flight.duration)


def test_the_course_goes_on_where_each_piece_ends_and_never_turns_on_the_spot() -> None:
    course = rounded(plow(), Dynamics(2.0, 2.0)).course
    ends = course.bounds_m[1:-1]
    before, after = course.at(ends - 1e-9), course.at(ends + 1e-9)
    assert before == pytest.approx(after, abs=1e-6)
    turn = course.heading_at(ends + 1e-9) - course.heading_at(ends - 1e-9)
    assert np.cos(turn) == pytest.approx(np.ones(len(turn)), abs=1e-6)


def test_close_plow_lines_are_joined_by_half_circles_and_far_ones_by_quarters() -> None:
    near = rounded(plow(2, spacing=1.0), Dynamics(2.0, 2.0), radius_m=0.5)
    assert near.course.curvatures.tolist() == [0.0, -2.0, -2.0, 0.0]
    far = rounded(plow(2, spacing=8.8), Dynamics(2.0, 2.0))
    assert far.course.curvatures == pytest.approx([0.0, -0.5, 0.0, -0.5, 0.0])
    assert far.deviation_m == pytest.approx(2.0 * (1 - np.sqrt(0.5)))


def test_a_coverage_plan_keeps_its_speed_through_wide_turns() -> None:
    flight = rounded(plow(), Dynamics(2.0, 2.0))
    _, _, speed = flight.sample(0.1)
    assert speed[15:-15] == pytest.approx(np.full(len(speed) - 30, 2.0))
    assert flight.duration < Dynamics(2.0, 2.0).seconds(plow()) - 10


def test_no_choice_of_the_same_radii_by_hand_is_faster() -> None:
    """Brute force over radii of all corners; what is left to find is between the few radii that are tried."""
    drone, way = Dynamics(3.0, 1.5), np.array([[0, 0], [7, 0], [7, 4], [2, 9], [12, 9]], float)
    module = import_module("sooner.motion.rounded")
    bends, steps = np.arange(5), np.diff(way, axis=0)
    lengths, turns = np.hypot(*steps.T), module.turns_rad(way)
    choices = [
        np.unique(module._choices(q, a, b, drone, drone.r_crit, np.inf).radius)
        for q, a, b in zip(turns, lengths[:-1], lengths[1:], strict=True)
    ]
    best = np.inf
    for radii in itertools.product(*choices):
        cut = np.concatenate([[0], np.array(radii) * np.tan(turns / 2), [0]])
        straights = lengths - cut[:-1] - cut[1:]
        speeds = module._speeds(np.array(radii), np.maximum(straights, 0), drone)
        if straights.min() < 0 or ((speeds[1:-1] == 0) & (np.array(radii) > 0)).any():
            continue
        best = min(best, module._flown(way, bends, lengths, turns, np.array(radii), drone).duration)
    assert rounded(way, drone).duration == pytest.approx(best, rel=0.01)
    assert best < 0.9 * drone.seconds(way)


def test_waypoints_straight_ahead_are_passed_in_time() -> None:
    flight = rounded([[0, 0], [5, 0], [10, 0], [10, 10]], Dynamics(2.0, 2.0))
    position, speed = flight.at(flight.times[1])
    assert position == pytest.approx([5, 0])
    assert speed == 2.0


def test_arcs_become_chords_that_stay_close() -> None:
    flight = rounded(plow(), Dynamics(2.0, 2.0))
    points, flown = flight.polyline(sagitta_m=0.001)
    assert to_polyline(flight.sample(0.01)[1], points).max() <= 0.001 + 1e-9
    assert flown[-1] == flight.length_m
    assert flight.course.at(flown) == pytest.approx(points)


@pytest.mark.parametrize("way", [[[3, 4]], [[3, 4], [3, 4]], [[0, 0], [5, 0]], [[0, 0], [5, 0], [0, 0]]])
def test_ways_without_corners_stop_where_they_must(way: list) -> None:
    drone = Dynamics(2.0, 2.0)
    flight = rounded(way, drone)
    assert isinstance(flight, Trajectory)
    assert flight.duration == pytest.approx(drone.seconds(way))
    assert flight.deviation_m == 0.0
    assert flight.at(flight.duration)[0] == pytest.approx(way[-1])


def test_a_negative_radius_is_refused() -> None:
    with pytest.raises(InvalidProblemError, match="expected at least 0"):
        rounded([[0, 0], [1, 0]], Dynamics(1.0, 1.0), radius_m=-1.0)
