import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief import Belief
from sooner.errors import InvalidProblemError
from sooner.problem import Gains, detection_gains
from tests.strategies import gain_tables


@given(gain_tables(5), st.lists(st.integers(0, 6), min_size=5, max_size=5))
def test_gains_after_looks_are_the_later_gains(gains: Gains, looked: list[int]) -> None:
    cells, later = np.arange(5), np.array(looked)
    left = gains.after(later)
    for look in range(6):
        assert left.of(cells, np.full(5, look)) == pytest.approx(gains.of(cells, later + look))


@given(st.floats(0.05, 1), st.floats(0, 0.9))
def test_correlated_gains_never_pass_the_mass_of_their_cell(g: float, rho: float) -> None:
    gains = detection_gains(Belief.from_weights([[1.0, 3.0]]), g, rho)
    total = gains.of(np.ones(400, int), np.arange(400)).sum()
    assert total <= 0.75 + 1e-9


def test_correlation_leaves_the_first_look_and_lowers_the_second() -> None:
    belief = Belief.from_weights([[1.0]])
    one, other = detection_gains(belief, 0.5), detection_gains(belief, 0.5, 0.3)
    first, second = np.array([0]), np.array([1])
    assert other.of(first, first) == pytest.approx(one.of(first, first))
    assert other.of(first, second) < one.of(first, second)


@pytest.mark.parametrize(
    ("table", "ratio"),
    [
        ([[0.1, 0.2]], [0.5]),
        ([[-0.1]], [0.5]),
        ([[np.nan]], [0.5]),
        ([[0.1]], [1.5]),
        ([[0.1]], [np.nan]),
        ([[0.1]], [0.5, 0.5]),
        ([0.1], [0.5]),
    ],
)
def test_gains_that_make_no_sense_are_refused(table: list, ratio: list) -> None:
    with pytest.raises(InvalidProblemError):
        Gains(np.array(table), np.array(ratio))


@pytest.mark.parametrize("glimpse", [1.5, -0.1, np.nan, np.ones((2, 2))])
def test_glimpses_that_make_no_sense_are_refused(glimpse: object) -> None:
    with pytest.raises(InvalidProblemError, match="glimpse"):
        detection_gains(Belief.from_weights([[1.0, 1.0, 1.0]]), glimpse)  # type: ignore[arg-type]
