import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.sensors import glimpse_from_difficulty, miss_after_looks


def test_three_levels_give_the_glimpses_of_the_real_maps() -> None:
    assert glimpse_from_difficulty([[0, 1, 2]]) == pytest.approx(np.array([[1, 2 / 3, 1 / 3]]))


def test_levels_one_to_three_give_those_of_the_synthetic_scenario() -> None:
    assert glimpse_from_difficulty([[1, 2, 3]]) == pytest.approx(np.array([[0.75, 0.5, 0.25]]))


@pytest.mark.parametrize("bad", [[[-1, 0]], [[np.nan, 0]], [[np.inf]], [[]]])
def test_levels_that_make_no_sense_are_refused(bad: list) -> None:
    with pytest.raises(InvalidProblemError):
        glimpse_from_difficulty(bad)


@given(st.floats(0, 1), st.floats(0.01, 0.99), st.integers(1, 12))
def test_correlated_looks_miss_as_the_beta_mixture_of_independent_ones(g: float, rho: float, looks: int) -> None:
    """E[(1 - G)^k] by moments of the Beta law, an oracle that never multiplies ratios."""
    from scipy.special import betaln

    total = 1 / rho - 1
    a, b = g * total, (1 - g) * total
    found = miss_after_looks(np.array([g]), looks, rho)[0]
    if min(a, b) < 1e-6:
        expected = 1.0 * (np.arange(looks + 1) == 0) if b < 1e-6 else np.ones(looks + 1)
        assert found == pytest.approx(expected, abs=1e-4)
    else:
        expected = np.exp(betaln(a, b + np.arange(looks + 1)) - betaln(a, b))
        assert found == pytest.approx(expected, abs=1e-9)


@given(st.floats(0, 1), st.floats(0, 1), st.integers(1, 12))
def test_a_further_look_never_hurts_and_helps_less(g: float, rho: float, looks: int) -> None:
    gains = -np.diff(miss_after_looks(np.array([g]), looks, rho)[0])
    assert (gains >= -1e-12).all()
    assert (np.diff(gains) <= 1e-12).all()


def test_no_correlation_is_the_papers_independence() -> None:
    assert miss_after_looks(np.array([1 / 3]), 4, 0.0)[0] == pytest.approx((2 / 3) ** np.arange(5))


def test_a_correlation_above_one_is_refused() -> None:
    with pytest.raises(InvalidProblemError, match="correlation"):
        miss_after_looks(np.array([0.5]), 2, 1.5)
