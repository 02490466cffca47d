"""Void, unoccupied and occupied cells, against the whole joint table of state and levels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief import CellStates, odds_of_confidence
from sooner.errors import InvalidProblemError
from sooner.sensors import GradedSensor

MAP_SENSOR, TARGET_SENSOR = GradedSensor(4.0, 25), GradedSensor(3.0, 13)
MAP, TARGET = MAP_SENSOR.p_levels, TARGET_SENSOR.p_levels
G, Z = MAP_SENSOR.likelihood_ratios, TARGET_SENSOR.likelihood_ratios

shares = st.lists(st.floats(1e-6, 1.0), min_size=3, max_size=3)
looks = st.lists(st.tuples(st.integers(0, 24), st.integers(0, 12)), min_size=1, max_size=30)


def one_cell(weights: list[float], node: bool = False) -> CellStates:
    v, u, o = (np.array([w / sum(weights)]) for w in weights)
    return CellStates(v, u, o, np.zeros(1, bool), np.array([node]))


def joint_posterior(prior: list[float], seen: list[tuple[int, int]]) -> np.ndarray:
    """p(C | levels) from the table p(C, G, Z), (3, 25, 13), a level at a time."""
    belief = np.array(prior) / sum(prior)
    g_given = np.stack([MAP[0], MAP[1], MAP[1]])
    z_given = np.stack([TARGET[0], TARGET[0], TARGET[1]])
    for g, z in seen:
        joint = belief[:, None, None] * g_given[:, :, None] * z_given[:, None, :]
        assert joint.sum() == pytest.approx(1.0)
        belief = joint[:, g, z] / joint[:, g, z].sum()
    return belief


@given(shares, looks)
def test_looks_are_bayes_law_on_the_joint_table(prior: list[float], seen: list[tuple[int, int]]) -> None:
    states = one_cell(prior)
    for g, z in seen:
        states = states.see([0], [G[g]], [Z[z]])
    found = [states.void[0], states.unoccupied[0], states.occupied[0]]
    assert found == pytest.approx(joint_posterior(prior, seen), rel=1e-9, abs=1e-99)
    assert states.explored[0]


@given(shares, looks)
def test_looks_commute(prior: list[float], seen: list[tuple[int, int]]) -> None:
    forward, backward = one_cell(prior), one_cell(prior)
    for (g, z), (h, y) in zip(seen, reversed(seen), strict=True):
        forward, backward = forward.see([0], [G[g]], [Z[z]]), backward.see([0], [G[h]], [Z[y]])
    assert forward.occupied == pytest.approx(backward.occupied, rel=1e-9)


def test_a_blind_look_changes_nothing() -> None:
    blind = GradedSensor(0.0).likelihood_ratios
    states = CellStates.unknown(3).see([0, 2], blind[[3, 4]], blind[[5, 24]])
    for now, before in zip((states.void, states.occupied), (0.9, 0.1 * 0.5 / 3), strict=True):
        assert now == pytest.approx(before, rel=1e-14)
    assert states.explored.tolist() == [True, False, True]


def test_a_look_at_the_expected_levels_leaves_the_prior_on_average() -> None:
    """The law of total probability over all levels."""
    prior = [0.7, 0.2, 0.1]
    mean = np.zeros(3)
    for g in range(25):
        for z in range(13):
            chance = (
                prior[0] * MAP[0, g] * TARGET[0, z]
                + prior[1] * MAP[1, g] * TARGET[0, z]
                + prior[2] * MAP[1, g] * TARGET[1, z]
            )
            states = one_cell(prior).see([0], [G[g]], [Z[z]])
            mean += chance * np.array([states.void[0], states.unoccupied[0], states.occupied[0]])
    assert mean == pytest.approx(prior, abs=1e-12)


def test_probabilities_stay_probabilities_over_a_million_looks_and_no_cell_is_settled_for_ever() -> None:
    from sooner.belief._cell_state_kernels import see

    rng, n = np.random.default_rng(3), 2_000
    states = CellStates.unknown(n)
    arrays = states.void, states.unoccupied, states.occupied
    cells = np.arange(n, dtype=np.int32)

    def look(g: np.ndarray, z: np.ndarray) -> None:
        see(*arrays, states.explored, states.nodes, cells, G[g], Z[z], 0, n)

    for _ in range(500):
        look(rng.integers(25, size=n), rng.integers(13, size=n))
    for _ in range(200):  # every look says void as loudly as can be, then every look says node and target
        look(np.zeros(n, int), np.zeros(n, int))
    assert (states.void > 0.999).all()
    assert all((a > 0).all() and (a <= 1).all() for a in arrays)
    assert np.abs(sum(arrays) - 1.0).max() < 1e-12
    for _ in range(40):
        look(np.full(n, 24), np.full(n, 12))
    assert (states.occupied > 0.999).all()


@pytest.mark.parametrize("ratio", [0.0, -1.0, np.nan, np.inf])
def test_a_ratio_that_is_none_is_refused(ratio: float) -> None:
    with pytest.raises(InvalidProblemError, match="expected as many > 0"):
        CellStates.unknown(2).see([0], [1.0], [ratio])


def test_a_detected_node_is_not_updated_but_counts_as_seen() -> None:
    states = one_cell([0.1, 0.8, 0.1], node=True).see([0], [G[0]], [Z[0]])
    assert (states.void[0], states.occupied[0]) == pytest.approx((0.1, 0.1))
    assert states.explored[0]


def test_a_node_is_detected_once_its_odds_reach_the_threshold() -> None:
    v = np.array([0.06, 0.04, 0.04])
    explored = np.array([True, True, False])
    states, found = CellStates(v, 1 - v, np.zeros(3), explored, np.zeros(3, bool)).detect_nodes(19.0)
    assert found.tolist() == [1]
    assert states.nodes.tolist() == [False, True, False]
    assert states.detect_nodes(19.0)[1].size == 0


def test_the_target_is_detected_in_the_likeliest_cell_once_its_odds_reach_the_threshold() -> None:
    o = np.array([0.951, 0.97, 0.94])
    seen, none = np.ones(3, bool), np.zeros(3, bool)
    assert CellStates(1 - o, 0 * o, o, seen, none).detect_target(19.0) == 1
    assert CellStates(1 - o, 0 * o, o, seen, none).detect_target(99.0) is None


def test_95_percent_are_odds_of_19() -> None:
    assert odds_of_confidence(0.95) == pytest.approx(19.0)
    with pytest.raises(InvalidProblemError, match="expected one between 0 and 1"):
        odds_of_confidence(1.0)


def test_false_nodes_are_no_likelier_than_the_threshold_allows() -> None:
    """P(the odds ever reach 19 | void) <= prior odds / 19: Bayes factors are a martingale of mean one (Ville)."""
    rng, n, sensor = np.random.default_rng(11), 20_000, GradedSensor()
    states, empty, ratios = CellStates.unknown(n), np.zeros(n, bool), sensor.likelihood_ratios
    for _ in range(30):
        looks = (ratios[sensor.draw(empty, rng)] for _ in range(2))
        states, _ = states.see(np.arange(n), *looks).detect_nodes(19.0)
    assert 0 < states.nodes.mean() < (0.1 / 0.9) / 19.0 * 1.2


def test_ratios_set_the_cells_of_nodes() -> None:
    states = CellStates.unknown(4).with_ratios([1, 3], [0.0, 3.0])
    assert states.void[[1, 3]].tolist() == [0.0, 0.0]
    assert states.occupied[[1, 3]] == pytest.approx([0.0, 0.75])
    assert states.void[0] == 0.9
    with pytest.raises(InvalidProblemError, match="expected as many >= 0"):
        states.with_ratios([1], [float("nan")])


def test_the_prior_shares_the_target_among_all_cells() -> None:
    states = CellStates.unknown(1600, void=0.9, absent=0.5)
    assert states.occupied.sum() == pytest.approx(0.1 * 0.5)
    assert (states.void + states.unoccupied + states.occupied) == pytest.approx(1.0)


def test_expected_streets_reach_only_cells_never_in_view() -> None:
    states = CellStates.unknown(4).see([0], [G[20]], [Z[5]])
    after = states.expecting(np.array([0.5, 0.5, 0.2, 0.99]), absent=0.4)
    assert after.void[0] == states.void[0]
    assert after.void[1:].tolist() == [0.5, 0.2, 0.99]
    assert after.occupied[1:] == pytest.approx([0.5 * 0.2, 0.8 * 0.2, 0.01 * 0.2])


def test_a_known_map_leaves_only_the_target_open() -> None:
    states = CellStates.known_map([True, False, True], absent=0.5)
    assert states.void.tolist() == [0.0, 1.0, 0.0]
    assert states.occupied.sum() == pytest.approx(0.5)
    with pytest.raises(InvalidProblemError, match="some true"):
        CellStates.known_map([False])


@pytest.mark.parametrize("three", [([0.5], [0.2], [0.2]), ([1.5], [-0.5], [0.0]), ([np.nan], [0.5], [0.5])])
def test_three_that_are_no_probabilities_are_refused(three: tuple[list[float], ...]) -> None:
    with pytest.raises(InvalidProblemError, match="expected probabilities that total one"):
        CellStates(*(np.array(a) for a in three), np.zeros(1, bool), np.zeros(1, bool))


def test_states_of_unlike_shapes_are_refused() -> None:
    with pytest.raises(InvalidProblemError, match=r"expected \(M,\) five times"):
        CellStates(np.ones(2), np.zeros(2), np.zeros(2), np.zeros(3, bool), np.zeros(2, bool))


@pytest.mark.parametrize(("void", "absent"), [(0.0, 0.5), (1.0, 0.5), (0.9, 1.0), (0.9, -0.1), (float("nan"), 0.5)])
def test_an_impossible_prior_is_refused(void: float, absent: float) -> None:
    with pytest.raises(InvalidProblemError, match="expected probabilities below 1"):
        CellStates.unknown(5, void, absent)
