import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.streets import Evasive, OccupancyGraph, TargetStates, TargetWalk, turn_weights
from sooner.streets._walk_kernels import step, step_biased
from tests.streets.graphs import random_graph

LINE = TargetStates(OccupancyGraph.of(Grid((1, 5), cell_m=5.0), range(5), [(i, i + 1) for i in range(4)]))
CROSS = TargetStates(OccupancyGraph.of(Grid((3, 3), cell_m=5.0), [1, 3, 4, 5, 7], [(0, 2), (1, 2), (2, 3), (2, 4)]))


def row(states, q, previous, current):
    """Probability of each next node, from (previous, current)."""
    state = np.flatnonzero((states.previous == previous) & (states.current == current))[0]
    entries = slice(states.outgoing_starts[state], states.outgoing_starts[state + 1])
    return dict(zip(states.current[states.outgoing_states[entries]].tolist(), q[entries], strict=True))


@given(st.integers(0, 2**32 - 1), st.floats(0, 0.99), st.floats(0, 5), st.floats(0.01, 5))
def test_what_leaves_a_state_totals_one(seed, rest, scale, shape):
    states = TargetStates(random_graph(np.random.default_rng(seed)))
    q = TargetWalk(rest, scale, shape).weights(states)
    assert (q >= 0).all()
    assert np.allclose(np.add.reduceat(q, states.outgoing_starts[:-1]), 1.0)


def test_straight_on_is_twice_as_likely_as_straight_back():
    next_node = row(LINE, TargetWalk().weights(LINE), 1, 2)
    assert np.isclose(next_node[3], 2 * next_node[1])
    assert np.isclose(next_node[2], 0.5)


def test_at_a_crossing_the_turn_decides():
    next_node = row(CROSS, TargetWalk().weights(CROSS), 1, 2)  # came from the west
    quarter = (0.1 - 1 / np.pi) * np.pi / 2 + 2
    side = quarter / (1 + 0.1 * np.pi / 2)
    total = 2 + 2 * side + 1
    assert np.isclose(next_node[3], 0.5 * 2 / total)
    assert np.isclose(next_node[0], 0.5 * side / total)
    assert np.isclose(next_node[4], next_node[0])
    assert np.isclose(next_node[1], 0.5 * 1 / total)


def test_a_resting_target_leaves_in_every_direction_alike():
    for again, stays, goes in ((0.0, 0.0, 0.25), (0.6, 0.6, 0.1), (None, 0.2, 0.2)):
        next_node = row(CROSS, TargetWalk(rest=0.3, rest_again=again).weights(CROSS), 2, 2)
        assert np.isclose(next_node.pop(2), stays)
        assert np.allclose(list(next_node.values()), goes)


def test_a_target_at_a_lone_node_stays():
    states = TargetStates(OccupancyGraph.of(Grid((1, 1)), [0], []))
    assert TargetWalk().weights(states).tolist() == [1.0]
    assert TargetWalk().walked(states, 0, 5, np.random.default_rng(0)).ravel().tolist() == [0] * 6


def test_a_dead_end_turns_back():
    next_node = row(LINE, TargetWalk().weights(LINE), 1, 0)
    assert next_node == pytest.approx({0: 0.5, 1: 0.5})


def test_turns_are_the_smallest_between_two_headings():
    """Through west, where headings jump from pi to -pi, straight on is still straight on."""
    next_node = row(LINE, TargetWalk().weights(LINE), 3, 2)
    assert np.isclose(next_node[1], 2 * next_node[3])


def test_weights_fall_with_the_turn():
    weights = turn_weights(np.linspace(0, np.pi, 50), TargetWalk())
    assert (np.diff(weights) < 0).all()


def test_walks_are_as_often_where_their_probabilities_say():
    """After three seconds, against powers of the dense transition matrix; 5 sigma."""
    states, walk, n = CROSS, TargetWalk(rest=0.3), 40_000
    dense = np.zeros((states.n_states, states.n_states))
    rows = np.repeat(np.arange(states.n_states), np.diff(states.outgoing_starts))
    dense[rows, states.outgoing_states] = walk.weights(states)
    rng = np.random.default_rng(11)
    start = walk.started(states, rng, n)
    path = walk.walked(states, start, 3, rng)
    assert path.shape == (4, n)
    began = np.where(states.is_rest, 1 / states.n_nodes, 0.0)
    for second in (0, 1, 3):
        expected = began @ np.linalg.matrix_power(dense, second)
        seen = np.bincount(path[second], minlength=states.n_states) / n
        assert np.all(abs(seen - expected) <= 5 * np.sqrt(expected * (1 - expected) / n) + 1e-12)


@given(st.integers(0, 2**32 - 1))
def test_a_walk_takes_transitions_only(seed):
    rng = np.random.default_rng(seed)
    states = TargetStates(random_graph(rng))
    walk = TargetWalk()
    path = walk.walked(states, walk.started(states, rng, 3), 20, rng)
    for before, after in zip(path[:-1].ravel(), path[1:].ravel(), strict=True):
        assert after in states.outgoing(before)


def test_one_seed_one_walk():
    one, two = (TargetWalk().walked(CROSS, 2, 50, np.random.default_rng(4)) for _ in range(2))
    assert np.array_equal(one, two)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"rest": 1.0}, "probability to rest of 1.0"),
        ({"rest": -0.1}, "probability to rest"),
        ({"rest": float("nan")}, "probability to rest"),
        ({"rest_again": 1.1}, "probability to rest again of 1.1"),
        ({"turn_scale": -1.0}, "scale of turns"),
        ({"turn_shape": 0.0}, "shape of turns"),
    ],
)
def test_a_walk_that_cannot_be_is_refused(settings, said):
    with pytest.raises(InvalidProblemError, match=said):
        TargetWalk(**settings)


@pytest.mark.parametrize("bad", [np.ones(2), np.full(LINE.n_transitions, -1.0), np.full(LINE.n_transitions, np.nan)])
def test_a_bias_that_gives_no_factors_is_refused(bad):
    with pytest.raises(InvalidProblemError, match="one factor for each of"):
        TargetWalk(bias=lambda states, weights: bad).weights(LINE)


def test_a_bias_of_zero_everywhere_makes_the_target_rest():
    q = TargetWalk(bias=lambda states, weights: np.zeros_like(weights)).weights(LINE)
    assert np.array_equal(q, LINE.is_rest[LINE.outgoing_states].astype(float))


def test_an_evasive_target_goes_where_no_searcher_is_near():
    near_east = TargetWalk(bias=Evasive(np.array([[20.0, 0.0]]))).weights(LINE)
    plain, shy = row(LINE, TargetWalk().weights(LINE), 1, 2), row(LINE, near_east, 1, 2)
    assert shy[3] < plain[3]
    assert shy[1] > plain[1]
    assert np.isclose(shy[2], plain[2])
    nobody = TargetWalk(bias=Evasive(np.empty((0, 2)))).weights(LINE)
    assert np.allclose(nobody, TargetWalk().weights(LINE))
    assert np.allclose(TargetWalk(bias=Evasive(np.array([[5.0, 0.0]]), boldness=1.0)).weights(LINE), nobody)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"places_m": [[np.nan, 0.0]]}, "no numbers"),
        ({"places_m": [[0.0, 0.0]], "reach_m": 0.0}, "reach"),
        ({"places_m": [[0.0, 0.0]], "reach_m": 1e300}, "expected 0.001 to 1e6 m"),
        ({"places_m": [[0.0, 0.0]], "boldness": 0.0}, "boldness"),
    ],
)
def test_an_evasive_bias_that_cannot_be_is_refused(settings, said):
    with pytest.raises(InvalidProblemError, match=said):
        Evasive(**settings)


@given(st.integers(0, 2**32 - 1))
def test_a_biased_step_is_the_step_of_biased_weights(seed):
    rng = np.random.default_rng(seed)
    states = TargetStates(random_graph(rng))
    graph, evasive = states.graph, Evasive(rng.random((2, 2)) * 20)
    base, biased = TargetWalk().weights(states), TargetWalk(bias=evasive).weights(states)
    factors = evasive.factors(graph.positions_m)
    for state in range(states.n_states):
        draw = rng.random()
        told = step(state, draw, states.current, graph.starts, states.outgoing_starts, biased)
        rows = states.current, graph.starts, graph.neighbours, states.outgoing_starts
        assert step_biased(state, draw, *rows, base, factors) == told
