"""The camera against the paper's worked examples, and the two of its statements that do not hold."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.sensors import Camera, speed_to_steer, speed_to_stop, steering_distance, stopping_distance

PAPER = Camera(np.pi / 2, pixels=1200, exposure=2e-3)
positive = st.floats(0.1, 100)


@pytest.mark.parametrize(
    ("speed", "altitude", "pixels"),
    [(10, 10, 1.8), (5, 20, 0.9), (20, 5, 5.4)],  # the paper prints 0.9 for the last, which is the one before
)
def test_blur_is_that_of_the_worked_examples_on_the_short_side(speed: float, altitude: float, pixels: float) -> None:
    assert PAPER.blur(speed, altitude) == pytest.approx(pixels)


def test_the_long_side_gives_another_figure_than_the_paper() -> None:
    assert Camera(np.pi / 2, 1600, 2e-3).blur(10, 10) == pytest.approx(2.4)


def test_ninety_degrees_see_as_far_as_they_are_high() -> None:
    assert PAPER.footprint_radius(8.8) == pytest.approx(8.8)


def test_the_ground_moves_with_the_vehicle_and_with_its_turns() -> None:
    assert PAPER.ground_speed([10.0, -10.0], 8.0) == pytest.approx(np.array([14.0, 14.0]))


@given(st.floats(0.2, 3.0), st.integers(100, 4000), st.floats(1e-4, 1e-2), st.floats(0, 1), positive)
def test_the_largest_speed_just_blurs_and_the_lowest_altitude_undoes_it(
    field: float, pixels: int, exposure: float, rate: float, altitude: float
) -> None:
    camera = Camera(field, pixels, exposure, rate)
    speed = camera.largest_speed(altitude)
    if speed > 1e-6 * altitude:
        assert camera.blur(speed, altitude) == pytest.approx(1.0)
        assert camera.lowest_altitude(speed) == pytest.approx(altitude)
    elif speed == 0:
        assert camera.blur(0.0, altitude) >= 1.0 - 1e-9
        assert np.isinf(camera.lowest_altitude(1.0))


def test_outdoors_the_papers_ten_metres_a_second_are_sharp_from_its_own_altitude_on() -> None:
    camera = Camera(np.pi / 2, 1200, 1e-3)
    assert camera.blur(10.0, 8.8) < 1.0 < camera.blur(10.0, 8.5)


def test_stopping_within_range_takes_four_times_the_range_for_twice_the_speed() -> None:
    assert stopping_distance(10.0, 2.0) == pytest.approx(25.0)
    assert speed_to_stop(np.array([25.0, 100.0]), 2.0) == pytest.approx(np.array([10.0, 20.0]))


@given(positive, positive, positive)
def test_steering_is_half_of_what_is_printed_as_flying_it_shows(speed: float, ahead: float, push: float) -> None:
    steps = 2000
    tick = ahead / speed / steps
    flown = np.sum(push * tick * (np.arange(steps) + 0.5) * tick)  # sideways speed, halfway through each tick
    assert steering_distance(speed, ahead, push) == pytest.approx(flown)
    assert steering_distance(speed, ahead, push, printed=True) == pytest.approx(2 * flown)
    assert speed_to_steer(ahead, steering_distance(speed, ahead, push), push) == pytest.approx(speed)


@pytest.mark.parametrize(
    "wrong",
    [(0.0, 10, 1e-3, 0.5), (np.pi, 10, 1e-3, 0.5), (1.0, 0, 1e-3, 0.5), (1.0, 10, 0.0, 0.5), (1.0, 10, 1e-3, -1.0)],
)
def test_a_camera_that_cannot_be_is_refused(wrong: tuple) -> None:
    with pytest.raises(InvalidProblemError):
        Camera(*wrong)


def test_an_altitude_of_nothing_is_refused() -> None:
    with pytest.raises(InvalidProblemError, match="altitude"):
        PAPER.blur(1.0, 0.0)
