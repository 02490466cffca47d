"""The wind triangle, against worked examples of air navigation and against vectors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.motion.wind import check_wind, drifted, ground_speed, heading

angles = st.floats(-np.pi, np.pi)


def radians(bearing):
    """Counter-clockwise from east, of degrees clockwise from north."""
    return math.radians(90.0 - bearing)


def bearing(angle):
    return float(90.0 - np.degrees(angle)) % 360.0


def blowing(speed, from_deg):
    toward = radians(from_deg + 180.0)
    return speed * math.cos(toward), speed * math.sin(toward)


@pytest.mark.parametrize(
    ("course", "airspeed", "wind", "ground", "head"),
    [
        # e6b.noseapp.ca, "Heading and groundspeed": 10 kt from 270 degrees, course 0, 90 kt: 89.4 kt, heading 354
        (0.0, 90.0, (10.0, 270.0), (89.4, 0.05), (354.0, 0.5)),
        # Smithsonian, NASM.XXXX.0136, a wartime manual, p. 8, example 16, read off a slide rule: course 94, crabbing 10
        # degrees to the right (compass 104), 165 mph through the air and 146 over the ground in 34 mph from 154
        (94.0, 165.0, (34.0, 154.0), (146.0, 1.0), (104.0, 0.5)),
    ],
)
def test_the_worked_examples_of_a_course_come_out(course, airspeed, wind, ground, head):
    air = blowing(*wind)
    assert ground_speed(radians(course), airspeed, air) == pytest.approx(ground[0], abs=ground[1])
    assert bearing(heading(radians(course), airspeed, air)) == pytest.approx(head[0], abs=head[1])


def test_the_worked_example_of_a_heading_comes_out():
    # recreationalflying.com, "Wind vectors", 4.4.1: heading 045, 75 kt, wind of 20 kt from 135: about 15 degrees to the
    # left of the course after two hours, 150 nm to the north-east and 40 to the north-west
    course, speed = drifted(radians(45.0), 75.0, blowing(20.0, 135.0))
    assert bearing(course) == pytest.approx(45.0 - 15.0, abs=0.1)
    assert 2 * speed == pytest.approx(math.hypot(150.0, 40.0))


@given(course=angles, airspeed=st.floats(1.0, 30.0), share=st.floats(0.0, 0.999), to=angles)
def test_air_and_wind_add_up_to_the_ground(course, airspeed, share, to):
    wind = (share * airspeed * math.cos(to), share * airspeed * math.sin(to))
    speed, head = ground_speed(course, airspeed, wind), heading(course, airspeed, wind)
    assert speed > 0
    over_ground = airspeed * np.array([np.cos(head), np.sin(head)]) + wind
    assert over_ground == pytest.approx(speed * np.array([np.cos(course), np.sin(course)]), abs=1e-9)
    found, found_speed = drifted(head, airspeed, wind)
    assert found_speed == pytest.approx(speed)
    assert math.remainder(float(found) - course, 2 * np.pi) == pytest.approx(0.0, abs=1e-6)


@given(airspeed=st.floats(1.0, 30.0), share=st.floats(0.0, 0.99), course=angles)
def test_there_and_back_takes_no_less_than_in_still_air(airspeed, share, course):
    wind = (share * airspeed, 0.0)
    there, back = ground_speed([course, course + np.pi], airspeed, wind)
    assert 1 / there + 1 / back >= 2 / airspeed * (1 - 1e-9)


@pytest.mark.parametrize("wind", [(10.0, 0.0), (-6.0, 8.0), (0.0, -12.0)])
def test_a_wind_as_strong_as_the_airspeed_is_refused_with_numbers(wind):
    for refused in (lambda: ground_speed(0.0, 10.0, wind), lambda: heading(0.0, 10.0, wind)):
        with pytest.raises(InvalidProblemError, match=f"{math.hypot(*wind):g} m/s came, and at most 10 m/s through"):
            refused()
    check_wind(None, wind)
    assert drifted(0.0, 5.0, (-10.0, 0.0))[1] == 5.0  # who keeps a heading is blown backwards


def test_what_is_no_speed_or_no_wind_is_refused():
    with pytest.raises(InvalidProblemError, match=r"an airspeed of 0\.0 m/s"):
        ground_speed(0.0, 0.0, (0.0, 0.0))
    with pytest.raises(InvalidProblemError, match="a wind of"):
        drifted(0.0, 10.0, (math.nan, 0.0))
