import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from sooner.errors import InvalidProblemError
from sooner.sensors import GradedSensor

sensors = st.builds(GradedSensor, st.floats(0, 30), st.integers(2, 40))


@given(sensors)
def test_levels_have_probabilities_that_total_one_and_tell_a_finite_amount(sensor: GradedSensor) -> None:
    for p in (sensor.p_noise, sensor.p_signal):
        assert p.shape == (sensor.levels,)
        assert p.sum() == pytest.approx(1.0, abs=1e-12)
        assert (p > 0).all()
    assert np.isfinite(np.log(sensor.likelihood_ratios)).all()


@given(sensors)
def test_a_signal_seen_from_the_other_end_is_noise(sensor: GradedSensor) -> None:
    assert sensor.p_signal[::-1] == pytest.approx(sensor.p_noise, rel=1e-9)


@given(sensors)
def test_one_level_more_multiplies_the_odds_by_the_same(sensor: GradedSensor) -> None:
    """log L(z) = m (z - m / 2), in which the sums that normalise cancel by symmetry [Wolek2020, section III.B]."""
    m, z = sensor.sensitivity, sensor.values
    assert np.log(sensor.likelihood_ratios) == pytest.approx(m * (z - m / 2), rel=1e-9, abs=1e-9)


def test_a_blind_sensor_tells_nothing() -> None:
    assert GradedSensor(0.0).likelihood_ratios == pytest.approx(1.0)


@pytest.mark.parametrize("signal", [False, True])
@pytest.mark.parametrize("sensor", [GradedSensor(), GradedSensor(2.0, 9), GradedSensor(4.0, 3)])
def test_draws_are_the_normal_law_cut_halfway_between_levels(sensor: GradedSensor, signal: bool) -> None:
    n = 200_000
    drawn = np.bincount(sensor.draw(np.full(n, signal), np.random.default_rng(5)), minlength=sensor.levels) / n
    cuts = np.concatenate([[-np.inf], (sensor.values[1:] + sensor.values[:-1]) / 2, [np.inf]])
    expected = np.diff(stats.norm.cdf(cuts - sensor.sensitivity * signal))
    assert (np.abs(drawn - expected) <= 5.0 * np.sqrt(expected * (1 - expected) / n) + 1e-12).all()


def test_with_25_levels_draws_follow_what_bayes_assumes_of_them_to_a_thousandth() -> None:
    sensor = GradedSensor()
    cuts = np.concatenate([[-np.inf], (sensor.values[1:] + sensor.values[:-1]) / 2, [np.inf]])
    assert np.diff(stats.norm.cdf(cuts)) == pytest.approx(sensor.p_noise, abs=1.5e-3)


@pytest.mark.parametrize("sensitivity", [-1.0, 31.0, float("nan"), float("inf")])
def test_an_impossible_sensitivity_is_refused(sensitivity: float) -> None:
    with pytest.raises(InvalidProblemError, match=r"sensitivity of .* came; expected one in \[0, 30\]"):
        GradedSensor(sensitivity)


@pytest.mark.parametrize("levels", [1, 0, -3, 2.5])
def test_fewer_than_two_levels_are_refused(levels: int) -> None:
    with pytest.raises(InvalidProblemError, match="expected a whole number of at least 2"):
        GradedSensor(4.0, levels)
