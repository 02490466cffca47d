from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.belief.track_before_detect import Track, TrackBeforeDetect, start_ratio
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.streets import OccupancyGraph, TargetStates, TargetWalk
from tests.oracles.dense_track import one_second, pairs_of, walk_matrix
from tests.streets.graphs import random_graph

LINE = TargetStates(OccupancyGraph.of(Grid((1, 4), cell_m=5.0), range(4), [(0, 1), (1, 2), (2, 3)]))


def begun(states, walk=None, **settings) -> Track:
    return TrackBeforeDetect(**settings).begun(states, (walk or TargetWalk()).weights(states))


def by_pair(track, pairs):
    states = track.states
    number = {pair: s for s, pair in enumerate(zip(states.previous.tolist(), states.current.tolist(), strict=True))}
    return track.probability[[number[pair] for pair in pairs]]


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.95), st.floats(0.01, 1.0), st.floats(0, 0.9))
def test_a_track_is_that_of_dense_matrices_while_the_graph_grows(seed, absent, decay, rest):
    rng = np.random.default_rng(seed)
    graph = random_graph(rng)
    walk = TargetWalk(rest, rest_again=rest / 2)
    track = begun(TargetStates(graph), walk, absent=absent, decay=decay)
    detected = np.zeros(graph.n_nodes, bool)
    told, nothing = {}, 1.0  # p(s) by pair, p(phi)
    for _ in range(6):
        new = np.flatnonzero(~detected & (rng.random(graph.n_nodes) < 0.3))
        detected[new] = True
        begin = start_ratio(absent, graph.grid.n_cells) * nothing
        pairs, matrix = walk_matrix(graph, detected, walk)
        present = np.array([told.get(pair, begin) for pair in pairs])
        total = present.sum() + nothing
        nodes = rng.integers(graph.n_nodes, size=5)
        logs = rng.normal(0, 4, 5)
        log_of_node = {}
        for node, value in zip(nodes.tolist(), logs, strict=True):
            log_of_node[node] = log_of_node.get(node, 0.0) + value
        present, nothing = one_second(pairs, matrix, present / total, nothing / total, log_of_node, absent, decay)
        told = dict(zip(pairs, present, strict=True))

        track.explore(new)
        track.move()
        track.see(graph.cells[nodes], np.exp(logs))
        assert np.allclose(by_pair(track, pairs), present, rtol=1e-9, atol=1e-15)
        assert np.isclose(track.probability[-1], nothing, rtol=1e-9)
        assert np.count_nonzero(track.probability[:-1]) == len(pairs)


@given(st.integers(0, 2**32 - 1))
def test_a_track_is_bayes_over_all_paths(seed):
    """Every sequence of states, nothing among them, weighed by its probability and by what was seen."""
    rng = np.random.default_rng(seed)
    graph = OccupancyGraph.of(Grid((1, 3)), [0, 1, 2], [(0, 1), (1, 2)])
    states, settings, walk = TargetStates(graph), TrackBeforeDetect(absent=0.3, decay=0.4), TargetWalk(0.3)
    pairs, matrix = walk_matrix(graph, np.ones(3, bool), walk)
    n = len(pairs)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n] = (1 - settings.vanish) * matrix
    whole[n, :n] = settings.vanish
    whole[:n, n] = settings.appear / n
    whole[n, n] = 1 - settings.appear
    track = settings.begun(states, walk.weights(states))
    track.explore([0, 1, 2])
    began = np.append(by_pair(track, pairs), track.probability[-1])
    logs = rng.normal(0, 2, (3, 3))  # second, node
    weight = np.zeros(n + 1)
    for path in product(range(n + 1), repeat=4):
        here = began[path[0]]
        for second in range(3):
            at = path[second + 1]
            here *= whole[at, path[second]] * (np.exp(logs[second, pairs[at][1]]) if at < n else 1.0)
        weight[path[-1]] += here
    for second in range(3):
        track.move()
        track.see([0, 1, 2], np.exp(logs[second]))
    weight /= weight.sum()
    assert np.allclose(by_pair(track, pairs), weight[:n], rtol=1e-9)
    assert np.isclose(track.probability[-1], weight[n])


@pytest.mark.parametrize(("absent", "decay"), [(0.5, 0.1), (0.2, 0.05), (0.9, 1.0)])
def test_without_looks_the_integrated_ratio_decays_to_the_prior_odds(absent, decay):
    """At 1 - alpha a second, in probability [Wolek2020, sec. III.B]."""
    track = begun(LINE, absent=absent, decay=decay)
    track.explore(np.arange(4))
    track.see([1], [150.0])
    for _ in range(5):
        before = 1 - track.probability[-1] - (1 - absent)
        track.move()
        assert np.isclose(1 - track.probability[-1] - (1 - absent), (1 - decay) * before)
    for _ in range(600):
        track.move()
    assert np.isclose(track.integrated_ratio, (1 - absent) / absent)


def test_nothing_is_forgotten_without_decay():
    track = begun(LINE, decay=0.0)
    track.explore(np.arange(4))
    track.see([1], [150.0])
    ratio = track.integrated_ratio
    for _ in range(50):
        track.move()
    assert np.isclose(track.integrated_ratio, ratio)


def test_a_new_state_begins_at_its_ratio_and_leaves_the_others_ratios_alone():
    track = begun(LINE)
    track.explore([0, 1])
    track.see([0], [20.0])
    before = track.log_ratios
    track.explore([1, 2])  # 1 was there before
    opened = ~np.isfinite(before) & np.isfinite(track.log_ratios)
    old = np.isfinite(before)
    assert np.allclose(track.log_ratios[old], before[old])
    assert opened.sum() == 3
    assert np.allclose(np.exp(track.log_ratios[opened]), start_ratio(0.5, 4))
    assert np.array_equal(np.isfinite(track.log_ratios), LINE.explored(track.detected))


def test_a_target_at_a_lone_explored_node_stays():
    track = begun(LINE, decay=0.0)
    track.explore([2])
    track.see([2], [50.0])
    before = track.probability.copy()
    track.move()
    assert np.allclose(track.probability, before)


def test_where_nothing_is_seen_the_target_is_less_likely_and_elsewhere_more():
    track = begun(LINE)
    track.explore(np.arange(4))
    track.move()
    before, ratio = track.node_ratios, track.integrated_ratio
    track.see([0, 1], [0.05, 0.05])
    assert (track.node_ratios[:2] < before[:2]).all()
    assert np.allclose(track.node_ratios[2:], before[2:])
    assert track.integrated_ratio < ratio
    share = before[2] / before.sum()
    assert track.node_ratios[2] / track.node_ratios.sum() > share


def test_looks_commute_and_a_blind_look_changes_nothing():
    one, two = begun(LINE), begun(LINE)
    for track in (one, two):
        track.explore(np.arange(4))
        track.move()
    one.see([0, 3, 0], [3.0, 0.1, 1.5])
    two.see([3], [0.1])
    two.see([0], [4.5])
    assert np.allclose(one.probability, two.probability)
    before = one.probability.copy()
    one.see([0, 1], [1.0, 1.0])
    one.see([], [])
    assert np.allclose(one.probability, before, rtol=1e-14)


def test_looks_at_cells_without_an_explored_node_teach_nothing():
    states = TargetStates(OccupancyGraph.of(Grid((1, 4), cell_m=5.0), [0, 1], [(0, 1)]))
    track = begun(states)
    track.explore([0])
    before = track.probability.copy()
    track.see([1, 2, 3], [9.0, 9.0, 9.0])
    assert np.allclose(track.probability, before, rtol=1e-14)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.1, 1.0]), st.sampled_from([0.0, 0.5]))
def test_probabilities_total_one_and_logarithms_are_finite_whatever_comes(seed, decay, rest):
    rng = np.random.default_rng(seed)
    states = TargetStates(random_graph(rng))
    track = begun(states, TargetWalk(rest), decay=decay)
    ratios = np.zeros(states.n_nodes)
    n = states.n_nodes
    for _ in range(60):
        new = np.flatnonzero(rng.random(n) < 0.1)
        nodes = rng.integers(n, size=8)
        logs = rng.choice([0.0, 1e-300, 1e-9, 1.0, 1e9, 1e300, np.inf], 8)
        integrated, likeliest = track.second(new, states.graph.cells[nodes].astype(np.int32), logs, ratios)
        assert np.isclose(track.probability.sum(), 1.0)
        assert ((track.probability >= 0.0) & (track.probability <= 1.0)).all()
        assert np.isfinite(track.log_ratios[states.explored(track.detected)]).all()
        assert np.isfinite(integrated)
        assert integrated >= 0
        assert np.allclose(ratios, track.node_ratios)
        assert likeliest == -1 or np.isclose(ratios[likeliest], ratios.max())
        assert np.isclose(integrated, track.integrated_ratio)


def test_a_second_is_its_three_parts():
    rng = np.random.default_rng(2)
    states = TargetStates(random_graph(rng))
    one, two = begun(states), begun(states)
    ratios = np.zeros(states.n_nodes)
    for _ in range(10):
        new, nodes = (rng.integers(states.n_nodes, size=size) for size in (3, 5))
        cells, told = states.graph.cells[nodes].astype(np.int32), np.exp(rng.normal(0, 3, 5))
        one.second(new, cells, told, ratios)
        two.explore(new)
        two.move()
        two.see(cells, told)
        assert np.array_equal(one.probability, two.probability)


def test_nothing_explored_is_no_target_and_no_fault():
    track = begun(LINE)
    track.move()
    assert track.second(np.empty(0, np.int64), np.array([1], np.int32), np.array([9.0]), np.empty(4)) == (0.0, -1)
    assert track.likeliest == -1
    assert track.probability[-1] == 1.0


def test_a_copy_goes_on_by_itself():
    track = begun(LINE)
    track.explore([0])
    other = track.copy()
    other.explore([1])
    other.see([0], [50.0])
    assert track.detected.tolist() == [True, False, False, False]
    assert track.integrated_ratio < other.integrated_ratio


def test_the_target_is_found_where_it_walks():
    """Unit normal measurements, shifted by 4 where the target is, all cells in view."""
    rng = np.random.default_rng(6)
    graph = random_graph(rng, 10, 10, 0.6, 0.8)
    states, walk = TargetStates(graph), TargetWalk()
    track = begun(states, walk)
    track.explore(np.arange(graph.n_nodes))
    path = states.current[walk.walked(states, walk.started(states, rng), 30, rng)[:, 0]]
    right = []
    for node in path:
        z = rng.normal(0, 1, graph.n_nodes) + 4.0 * (np.arange(graph.n_nodes) == node)
        track.move()
        track.see(graph.cells, np.exp(4.0 * (z - 2.0)))
        right.append(track.likeliest == node)
    assert track.integrated_ratio > 19
    assert np.mean(right[5:]) > 0.9


def test_explored_states_are_those_of_the_oracle():
    graph = random_graph(np.random.default_rng(1))
    detected = np.random.default_rng(2).random(graph.n_nodes) < 0.5
    assert TargetStates(graph).explored(detected).sum() == len(pairs_of(graph, detected))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"absent": 0.0}, "no target of 0.0"),
        ({"absent": 1.0}, "no target of 1.0"),
        ({"decay": 1.1}, "rate of decay"),
        ({"decay": float("nan")}, "rate of decay"),
        ({"start": 0.0}, "to begin at"),
    ],
)
def test_a_track_that_cannot_be_is_refused(settings, said):
    with pytest.raises(InvalidProblemError, match=said):
        TrackBeforeDetect(**settings)


def test_weights_of_another_graph_are_refused():
    with pytest.raises(InvalidProblemError, match="there are 26 transitions"):
        TrackBeforeDetect().begun(LINE, np.ones(3))


def test_nodes_cells_and_numbers_that_are_not_there_are_refused():
    track = begun(LINE)
    with pytest.raises(InvalidProblemError, match="expected numbers from 0 to 3"):
        track.explore([4])
    with pytest.raises(InvalidProblemError, match="expected numbers from 0 to 3"):
        track.see([-1], [1.0])
    with pytest.raises(InvalidProblemError, match="one >= 0 for each"):
        track.see([1], [np.nan])
    with pytest.raises(InvalidProblemError, match="one >= 0 for each"):
        track.see([1, 2], [0.0])
    with pytest.raises(InvalidProblemError, match="one >= 0 for each"):
        track.see([1], [-1.0])


def test_probabilities_total_one_after_a_hundred_thousand_updates():
    rng = np.random.default_rng(1)
    for number in range(20):
        states = TargetStates(random_graph(rng))
        track = begun(states, TargetWalk(rng.choice([0.0, 0.5])), decay=rng.choice([0.0, 0.1, 1.0]))
        choices = np.exp(4 * (np.linspace(-3, 7, 25) - 2)) if number % 2 else np.array([0.0, 1e-300, 0.3, 3.0, np.inf])
        cells = rng.choice(states.graph.cells, (5_000, 6)).astype(np.int32)
        told = rng.choice(choices, cells.shape)
        found = np.sort(rng.integers(5_000, size=states.n_nodes))
        ratios = np.zeros(states.n_nodes)
        for second in range(5_000):
            new = np.flatnonzero(found == second)
            integrated, _ = track.second(new, cells[second], told[second], ratios)
            assert abs(track.probability.sum() - 1.0) < 1e-12
            assert np.isfinite(integrated)
        assert np.isfinite(track.log_ratios[track.explored]).all()
        assert track.explored.all()
