"""Information about cell states, term by term as printed, and as looked up."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief import InformationTable, look_information, state_entropy, state_information
from sooner.errors import InvalidProblemError
from sooner.sensors import GradedSensor

PAPER = GradedSensor().p_levels

shares = st.lists(st.floats(1e-9, 1.0), min_size=3, max_size=3).map(lambda w: [x / sum(w) for x in w])
laws = st.builds(GradedSensor, st.floats(0, 8), st.integers(2, 9)).map(lambda sensor: sensor.p_levels)


def as_printed(v: float, u: float, o: float, p_map: np.ndarray, p_target: np.ndarray) -> float:
    """Equations (16) to (18) by loops."""
    left = 0.0
    for g_v, g_uo in p_map.T:
        for z_vu, z_o in p_target.T:
            k = [z_vu * g_v * v, z_vu * g_uo * u, z_o * g_uo * o]
            left -= sum(k_c * np.log2(k_c / sum(k)) for k_c in k if k_c > 0)
    return -np.log2(v**v * u**u * o**o) - left


@given(shares, laws, laws)
def test_information_is_the_paper_term_by_term(three: list[float], p_map: np.ndarray, p_target: np.ndarray) -> None:
    found = state_information(*([p] for p in three), p_map, p_target)[0]
    assert found == pytest.approx(as_printed(*three, p_map, p_target), abs=1e-9)


@given(shares, laws, laws)
def test_information_lies_between_nothing_and_the_entropy(
    three: list[float], p_map: np.ndarray, p_target: np.ndarray
) -> None:
    found = state_information(*([p] for p in three), p_map, p_target)[0]
    assert 0.0 <= found <= state_entropy(*three)


def test_a_blind_look_teaches_nothing_and_a_perfect_one_everything() -> None:
    blind, perfect = GradedSensor(0.0).p_levels, np.eye(2)
    three = [0.5, 0.9], [0.3, 0.08], [0.2, 0.02]
    assert state_information(*three, blind, blind) == pytest.approx(0.0, abs=1e-12)
    assert state_information(*three, perfect, perfect) == pytest.approx(state_entropy(*three))


@given(st.floats(0, 1))
def test_without_a_target_it_is_what_a_yes_or_no_teaches(theta: float) -> None:
    p_map = np.array([[0.85, 0.15], [0.1, 0.9]])
    found = state_information([1 - theta], [theta], [0.0], p_map, np.eye(2))
    assert found == pytest.approx(look_information([theta], 0.9, 0.15), abs=1e-9)


def test_information_is_what_looks_teach_on_average() -> None:
    """The mean fall of the entropy over draws from the joint law, within four standard errors."""
    rng, n = np.random.default_rng(2), 40_000
    prior = np.array([0.6, 0.3, 0.1])
    state = rng.choice(3, n, p=prior)
    g = np.array([rng.choice(25, p=PAPER[int(c > 0)]) for c in state])
    z = np.array([rng.choice(25, p=PAPER[int(c == 2)]) for c in state])
    joint = prior[:, None] * PAPER[[[0], [1], [1]], g] * PAPER[[[0], [0], [1]], z]
    fall = state_entropy(*prior) - state_entropy(*(joint / joint.sum(axis=0)))
    expected = state_information(*([p] for p in prior), PAPER, PAPER)[0]
    assert abs(fall.mean() - expected) < 4 * fall.std() / np.sqrt(n)


@pytest.mark.parametrize("sensitivity", [1.0, 4.0, 8.0, 30.0])
def test_looked_up_it_differs_by_less_than_four_tenths_of_a_thousandth_of_a_bit(sensitivity: float) -> None:
    p = GradedSensor(sensitivity).p_levels
    rng = np.random.default_rng(7)
    node, target = rng.uniform(-25, 25, (2, 20_000))
    v = 1 / (1 + np.exp(node))
    u, o = (1 / (1 + np.exp(-node)) / (1 + np.exp(sign * target)) for sign in (1, -1))
    exact = np.where(state_entropy(v, u, o) < 0.01, 0.0, state_information(v, u, o, p, p))
    assert np.abs(InformationTable(p, p).information(v, u, o) - exact).max() < 4e-4


def test_certain_cells_can_be_looked_up() -> None:
    three = np.array([[1.0, 0.0, 0.0, 0.5, 0.5, 0.0], [0.0, 1.0, 0.0, 0.5, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0, 0.5, 0.5]])
    found = InformationTable(PAPER, PAPER).information(*three)
    assert found == pytest.approx(state_information(*three, PAPER, PAPER), abs=4e-4)
    assert (found[:3] == 0).all()


def test_cells_of_which_next_to_nothing_is_unknown_count_as_known() -> None:
    v = np.array([0.9995, 0.998])
    table, all_of_it = InformationTable(PAPER, PAPER), InformationTable(PAPER, PAPER, least=0.0)
    assert (table.information(v, 1 - v, 0 * v) > 0).tolist() == [False, True]
    assert (all_of_it.information(v, 1 - v, 0 * v) > 0).all()


def test_nine_levels_teach_almost_all_that_25_do_and_three_do_not() -> None:
    three = [0.9], [0.0999], [0.0001]
    bits = {n: state_information(*three, GradedSensor(4.0, n).p_levels, PAPER)[0] for n in (3, 9, 25, 101)}
    assert bits[9] == pytest.approx(bits[101], rel=0.01)
    assert bits[25] == pytest.approx(bits[101], rel=0.002)
    assert bits[3] < 0.5 * bits[101]


@pytest.mark.parametrize("bad", [np.ones(3), np.full((2, 3), 0.5), np.array([[1.5, -0.5], [0.5, 0.5]])])
def test_levels_that_have_no_probabilities_are_refused(bad: np.ndarray) -> None:
    with pytest.raises(InvalidProblemError, match="of noise and of signal"):
        state_information([0.5], [0.5], [0.0], bad, PAPER)
    with pytest.raises(InvalidProblemError, match="of noise and of signal"):
        InformationTable(PAPER, bad)
    with pytest.raises(InvalidProblemError, match="expected one in"):
        InformationTable(PAPER, PAPER, least=2.0)
