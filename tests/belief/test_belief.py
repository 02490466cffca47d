import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sooner.belief import Belief, predict, update_on_miss
from sooner.errors import ImpossibleObservationError, InvalidProblemError
from sooner.grid import Grid
from sooner.motion import drift_transition

weights = arrays(float, (3, 4), elements=st.floats(0, 1e300)).filter(lambda w: w.max() > 0)
probabilities = arrays(float, 12, elements=st.floats(0, 0.99))


@given(weights, st.floats(0, 0.99))
def test_poc_and_outside_total_one_however_large_the_weights(w: np.ndarray, outside: float) -> None:
    belief = Belief.from_weights(w, outside)
    assert belief.poc.sum() + belief.outside == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("bad", [[[0.0, 0.0]], [[1.0, -1.0]], [[np.nan, 1.0]], [[np.inf, 1.0]], [1.0, 2.0], [[]]])
def test_weights_that_make_no_sense_are_refused(bad: list) -> None:
    with pytest.raises(InvalidProblemError):
        Belief.from_weights(bad)


@pytest.mark.parametrize("outside", [-0.1, 1.0, float("nan")])
def test_outside_must_be_a_probability_below_one(outside: float) -> None:
    with pytest.raises(InvalidProblemError, match="outside"):
        Belief.from_weights([[1.0]], outside)


@given(weights, probabilities, st.floats(0, 0.9))
def test_a_miss_conserves_mass_and_never_raises_poc_where_it_looked_best(
    w: np.ndarray, glimpse: np.ndarray, outside: float
) -> None:
    belief = Belief.from_weights(w, outside)
    prior = belief.poc.ravel()
    after = update_on_miss(prior, glimpse)
    outside_after = outside / (1 - prior @ glimpse)
    assert after.sum() + outside_after == pytest.approx(1.0)
    best = int(np.argmax(glimpse))
    assert after[best] <= prior[best] * (1 + 1e-9)


@given(weights)
def test_a_blind_look_changes_nothing(w: np.ndarray) -> None:
    prior = Belief.from_weights(w).poc.ravel()
    assert np.array_equal(update_on_miss(prior, np.zeros(12)), prior)


@given(weights, probabilities, probabilities)
def test_misses_at_a_still_target_commute(w: np.ndarray, g: np.ndarray, h: np.ndarray) -> None:
    prior = Belief.from_weights(w).poc.ravel()
    one, other = update_on_miss(update_on_miss(prior, g), h), update_on_miss(update_on_miss(prior, h), g)
    assert one == pytest.approx(other)


def test_a_miss_that_cannot_be_is_refused() -> None:
    with pytest.raises(ImpossibleObservationError):
        update_on_miss(np.array([0.5, 0.5]), np.ones(2))


@pytest.mark.parametrize("connectivity", ["square4", "square8", "hex"])
@pytest.mark.parametrize("heading", [None, 0.7])
def test_drift_conserves_mass_and_keeps_off_obstacles(connectivity: str, heading: float | None) -> None:
    obstacles = np.zeros((4, 5), bool)
    obstacles[1, 2] = True
    grid = Grid((4, 5), connectivity, obstacles=obstacles)  # type: ignore[arg-type]
    transition = drift_transition(grid, 0.6, heading, persistence=2.0)
    belief = np.where(grid.passable, 1.0, 0.0) / grid.passable.sum()
    for _ in range(20):
        belief = predict(belief, transition)
    assert belief.sum() == pytest.approx(1.0)
    assert belief[grid.index((1, 2))] == 0.0


def test_a_biased_walk_goes_where_it_is_heading() -> None:
    grid = Grid((9, 9))
    belief = np.zeros(81)
    belief[grid.index((4, 4))] = 1.0
    for _ in range(5):
        belief = predict(belief, drift_transition(grid, 0.8, heading=np.pi / 2, persistence=2.0))
    east, north = belief @ grid.centres_m - grid.centres_m[grid.index((4, 4))]
    assert north > 2.0
    assert abs(east) < 1e-9


def test_a_probability_to_move_above_one_is_refused() -> None:
    with pytest.raises(InvalidProblemError, match="probability to move"):
        drift_transition(Grid((2, 2)), 1.5)
