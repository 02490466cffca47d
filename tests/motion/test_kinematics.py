import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.motion import Dynamics

limits = st.floats(0.2, 20.0)
drones = st.builds(Dynamics, limits, limits)


def flown_by_feedback(length: float, start: float, end: float, drone: Dynamics, steps: int = 8000) -> float:
    """Seconds for [Kuhlman2017, eq. (6)] in small steps: speed up, but no more than what is left suffices to undo.

    v' is the largest speed with  x + h (v + v') / 2 + (v'^2 - end^2) / 2a <= L.
    """
    a = drone.a_max
    h = min(length / drone.v_max + drone.v_max / a, 2 * math.sqrt(length / a)) / steps
    x, v, t = 0.0, start, 0.0
    while length - x > 1e-7 * length:
        room = max(length + end**2 / (2 * a) - x - h * v / 2, 0.0)
        next_v = min(v + a * h, drone.v_max, a * (math.sqrt(h**2 / 4 + 2 * room / a) - h / 2))
        x, v, t = x + h * (v + next_v) / 2, next_v, t + h
    return t


@settings(max_examples=15)
@given(drone=drones, length=st.floats(0.5, 100.0))
def test_small_steps_from_rest_to_rest_take_as_long(drone: Dynamics, length: float) -> None:
    assert flown_by_feedback(length, 0.0, 0.0, drone) == pytest.approx(float(drone.leg_seconds(length)), rel=1e-3)


@settings(max_examples=15)
@given(drone=drones, length=st.floats(0.5, 100.0), shares=st.tuples(st.floats(0, 0.99), st.floats(0, 0.99)))
def test_small_steps_between_speeds_take_as_long(drone: Dynamics, length: float, shares: tuple) -> None:
    reach = min(drone.v_max, np.sqrt(2 * drone.a_max * length))
    start, end = reach * shares[0], reach * shares[1]
    expected = float(drone.leg_seconds(length, start, end))
    assert flown_by_feedback(length, start, end, drone) == pytest.approx(expected, rel=1e-3)


@given(drone=drones, lengths=st.lists(st.floats(0.0, 1e4), min_size=2, max_size=2), end=st.floats(0, 1))
def test_time_never_falls_as_the_length_grows(drone: Dynamics, lengths: list, end: float) -> None:
    short, long = sorted(lengths)
    v = end * min(drone.v_max, np.sqrt(2 * drone.a_max * short))
    assert drone.leg_seconds(short, v_end=v) <= drone.leg_seconds(long, v_end=v) * (1 + 1e-12)


@given(drone=drones, length=st.floats(0.0, 1e4), shares=st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_a_leg_keeps_its_limits_and_covers_its_length_and_takes_as_long_backwards(
    drone: Dynamics, length: float, shares: tuple
) -> None:
    reach = min(drone.v_max, np.sqrt(2 * drone.a_max * length))
    start, end = reach * shares[0], reach * shares[1]
    leg = drone.profile(length, start, end)
    up, cruise, down = np.diff([0.0, *leg.switches, leg.seconds])
    assert min(up, cruise, down) >= -1e-12 * leg.seconds
    assert max(start, end) <= leg.peak <= drone.v_max * (1 + 1e-12)
    assert leg.peak - start == pytest.approx(drone.a_max * up, abs=1e-9)
    assert leg.peak - end == pytest.approx(drone.a_max * down, abs=1e-9)
    metres = up * (start + leg.peak) / 2 + cruise * leg.peak + down * (leg.peak + end) / 2
    assert metres == pytest.approx(length, rel=1e-9, abs=1e-9)
    assert drone.leg_seconds(length, end, start) == pytest.approx(float(leg.seconds), rel=1e-12)


def test_one_switch_up_to_the_critical_length_and_two_beyond() -> None:
    drone = Dynamics(3.0, 2.0)
    assert drone.r_crit == 4.5
    leg = drone.profile([1.0, 4.5, 4.6])
    assert np.array_equal(np.diff(leg.switches)[:, 0] > 0, [False, False, True])
    assert leg.seconds[:2] == pytest.approx(2 * np.sqrt(np.array([1.0, 4.5]) / 2.0))
    assert leg.seconds[2] == pytest.approx(2 * 3.0 / 2.0 + 0.1 / 3.0)


def test_to_fly_on_through_waypoints_straight_ahead_is_one_long_leg() -> None:
    drone = Dynamics(2.0, 1.0)
    way = np.array([[0, 0], [3, 4], [3, 4], [6, 8], [6, 0]], float)
    assert drone.seconds(way) == pytest.approx(float(2 * drone.leg_seconds(5) + drone.leg_seconds(8)))
    assert drone.seconds(way, stops="turns") == pytest.approx(float(drone.leg_seconds(10) + drone.leg_seconds(8)))
    assert drone.seconds([[1, 1], [1, 1]], stops="turns") == drone.seconds([[1, 1]]) == 0.0


def test_to_turn_straight_back_is_to_stop() -> None:
    drone = Dynamics(2.0, 1.0)
    assert drone.seconds([[0, 0], [9, 0], [0, 0]], stops="turns") == pytest.approx(float(2 * drone.leg_seconds(9)))


@pytest.mark.parametrize("limits", [(0.0, 1.0), (1.0, -1.0), (np.nan, 1.0), (1.0, np.inf)])
def test_limits_that_make_no_sense_are_refused(limits: tuple) -> None:
    with pytest.raises(InvalidProblemError, match="expected a positive number"):
        Dynamics(*limits)


def test_an_end_speed_out_of_reach_is_refused_with_those_in_reach() -> None:
    with pytest.raises(InvalidProblemError, match=r"a leg of 1 m from 0 to 3 m/s came.* can be 0 to 2 m/s"):
        Dynamics(5.0, 2.0).leg_seconds([10.0, 1.0], 0.0, 3.0)
    with pytest.raises(InvalidProblemError, match=r"outside \[0, 5.0\]"):
        Dynamics(5.0, 2.0).leg_seconds(10.0, 6.0)
    with pytest.raises(InvalidProblemError, match="length came negative"):
        Dynamics(5.0, 2.0).leg_seconds(-1.0)


@pytest.mark.parametrize("way", [[], [1.0, 2.0], [[1.0, np.nan]], [[1.0, 2.0, 3.0]]])
def test_waypoints_that_make_no_sense_are_refused(way: list) -> None:
    with pytest.raises(InvalidProblemError, match="waypoints of shape"):
        Dynamics(1.0, 1.0).seconds(way)
