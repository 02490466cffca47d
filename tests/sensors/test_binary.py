import pytest

from sooner.errors import InvalidProblemError
from sooner.sensors import BinarySensor


@pytest.mark.parametrize(("detect", "false_alarm"), [(1.1, 0.0), (-0.1, 0.0), (0.5, -0.1), (float("nan"), 0.0)])
def test_a_rate_that_is_no_probability_is_refused(detect: float, false_alarm: float) -> None:
    with pytest.raises(InvalidProblemError, match=r"expected a probability in \[0, 1\]"):
        BinarySensor(detect, false_alarm)


@pytest.mark.parametrize("rates", [(0.5, 0.5), (0.2, 0.8), (0.0, 0.0), (1.0, 1.0)])
def test_a_sensor_that_says_yes_no_more_often_where_a_target_is_is_refused(rates: tuple[float, float]) -> None:
    with pytest.raises(InvalidProblemError, match="expected detect to be the larger"):
        BinarySensor(*rates)


def test_without_false_alarms_it_is_the_glimpse_sensor() -> None:
    assert BinarySensor(0.6) == BinarySensor(0.6, 0.0)


def test_hits_and_misses_weigh_the_same_where_both_errors_are_as_likely() -> None:
    assert BinarySensor(0.85, 0.15).symmetric
    assert not BinarySensor(0.85, 0.1).symmetric
