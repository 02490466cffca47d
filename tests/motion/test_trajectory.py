import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.motion import Dynamics, Trajectory, integrated

drones = st.builds(Dynamics, st.floats(0.5, 15.0), st.floats(0.5, 5.0))
places = st.tuples(st.integers(-20, 20), st.integers(-20, 20))
ways = st.lists(places, min_size=1, max_size=8).map(lambda way: np.array(way, float))
stops = st.sampled_from(["waypoints", "turns"])


@settings(max_examples=40)
@given(way=ways, drone=drones, stops=stops)
def test_small_steps_of_the_control_end_at_rest_where_and_when_it_says(way, drone, stops) -> None:
    flight = Trajectory.through(way, drone, stops)
    assert flight.duration == pytest.approx(drone.seconds(way, stops), rel=1e-12)
    flown = integrated(flight, dt=0.05)
    assert max(flown.end_m, flown.end_mps, flown.off_m) < 1e-6
    assert flown.top_mps <= drone.v_max * (1 + 1e-9)
    assert flown.top_mps2 <= drone.a_max * (1 + 1e-6)


@given(way=ways, drone=drones, stops=stops)
def test_it_is_at_its_waypoints_when_it_says(way, drone, stops) -> None:
    flight = Trajectory.through(way, drone, stops)
    position, speed = flight.at(flight.times)
    assert position == pytest.approx(way, abs=1e-6)
    assert flight.times[0] == 0.0
    assert flight.times[-1] == pytest.approx(flight.duration)
    assert (np.diff(flight.times) >= 0).all()
    if stops == "waypoints":
        assert speed == pytest.approx(np.zeros(len(way)), abs=1e-5)


@given(way=ways, drone=drones, stops=stops, shares=st.lists(st.floats(0, 1), min_size=1, max_size=6))
def test_time_and_metres_flown_are_inverse(way, drone, stops, shares) -> None:
    flight = Trajectory.through(way, drone, stops)
    metres = np.array(shares) * flight.length_m
    assert flight.metres_at(flight.times_at(metres))[0] == pytest.approx(metres, abs=1e-6)
    assert (np.diff(flight.times_at(np.sort(metres))) >= -1e-12).all()


def test_samples_lie_on_the_polyline_and_end_at_its_end() -> None:
    flight = Trajectory.through([[0, 0], [6, 0], [6, 3]], Dynamics(2.0, 1.0))
    times, position, speed = flight.sample(0.25)
    assert times[-1] == flight.duration
    assert ((position[:, 1] == 0) | np.isclose(position[:, 0], 6)).all()
    assert speed[0] == speed[-1] == 0.0
    assert position[-1] == pytest.approx([6, 3])
    assert speed.max() == 2.0


def test_before_its_start_it_waits_and_after_its_end_it_rests() -> None:
    flight = Trajectory.through([[1, 2], [4, 6]], Dynamics(2.0, 1.0))
    position, speed = flight.at([-5.0, flight.duration + 5.0])
    assert position == pytest.approx(np.array([[1, 2], [4, 6]]))
    assert np.array_equal(speed, [0, 0])


def test_a_wrong_duration_would_show_in_the_integration() -> None:
    flight = Trajectory.through([[0, 0], [10, 0]], Dynamics(2.0, 2.0))
    hasty = Trajectory(
        flight.waypoints, flight.times, flight.course, flight.knot_s * 0.999, flight.knot_m, flight.knot_mps
    )
    assert integrated(hasty).end_m > 1e-3 or integrated(hasty).top_mps2 > 2.0 * (1 + 1e-4)


def test_a_polyline_of_straights_is_its_corners() -> None:
    points, flown = Trajectory.through([[0, 0], [6, 0], [6, 3]], Dynamics(2.0, 1.0)).polyline()
    assert points == pytest.approx(np.array([[0, 0], [6, 0], [6, 3]]))
    assert flown == pytest.approx([0, 6, 9])


def test_what_makes_no_sense_is_refused() -> None:
    flight = Trajectory.through([[0, 0], [6, 0]], Dynamics(2.0, 1.0))
    with pytest.raises(InvalidProblemError, match="step of 0"):
        flight.sample(0.0)
    with pytest.raises(InvalidProblemError, match="expected 'waypoints' or 'turns'"):
        Trajectory.through([[0, 0], [6, 0]], Dynamics(2.0, 1.0), "never")  # type: ignore[arg-type]
