"""Several tracks: what one explains starts no other, and two do not gather about one target."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.belief import _tracks_kernels as kernels
from sooner.belief.track_before_detect import TrackBeforeDetect
from sooner.belief.tracks import Following, Tracks
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.streets import OccupancyGraph, TargetStates, TargetWalk
from tests.streets.graphs import random_graph

NOBODY = np.empty(0, np.int64)
STREET = TargetStates(OccupancyGraph.of(Grid((1, 40), "square8", 5.0), range(40), [(n, n + 1) for n in range(39)]))


def begun(states, following=None, explored=True) -> Tracks:
    search = TrackBeforeDetect().begun(states, TargetWalk().weights(states))
    tracks = Tracks(search, following or Following())
    if explored:
        search.explore(np.arange(states.n_nodes))
    return tracks


def watched(tracks, paths, rng, sensitivity=4.0, in_view=None):
    """All, or some, nodes are looked at every second, with unit normal readings; what is found where, and when."""
    states = tracks.search.states
    n = states.n_nodes
    calls, ratios = [], np.zeros(n)
    for second, nodes in enumerate(paths):
        seen = np.arange(n) if in_view is None else in_view(second)
        z = rng.normal(0, 1, len(seen)) + sensitivity * np.isin(seen, nodes)
        told = np.exp(sensitivity * (z - sensitivity / 2))
        total, likeliest = tracks.second(NOBODY, states.graph.cells[seen].astype(np.int32), told, ratios)
        if total >= 19:
            tracks.confirm(likeliest)
            calls.append((second, likeliest))
    return calls


def walked(states, rng, seconds, n_targets):
    walk = TargetWalk()
    return states.current[walk.walked(states, walk.started(states, rng, n_targets), seconds, rng)]


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_beside_one_confirmed_target_the_search_is_bayes_law_over_both(seed):
    """Every pair of a place of the confirmed target and a state of the other, weighed by all looks of a second."""
    rng = np.random.default_rng(seed)
    states = TargetStates(random_graph(rng))
    graph, n = states.graph, states.n_nodes
    tracks = begun(states)
    tracks.confirm(int(rng.integers(n)))
    for track in (tracks.search, tracks.confirmed[1]):
        track.hold(rng.random(states.n_states) ** 8)
    first, other = tracks.confirmed[1].copy(), tracks.search.copy()
    first.move()
    other.move()

    cells = rng.choice(graph.cells, 7).astype(np.int32)  # some cells come more than once
    told = np.exp(rng.normal(0, 3, 7))
    together = np.ones(n)
    np.multiply.at(together, graph.node_of_cell[cells], told)
    likelihood = np.append(together, 1.0)  # a target at each node, or nowhere
    where = np.append(states.current, n)
    joint = first.probability[:, None] * other.probability[None, :]
    same = where[:, None] == where[None, :]
    joint *= np.where(same, likelihood[where][:, None], likelihood[where][:, None] * likelihood[where][None, :])
    tracks.second(NOBODY, cells, told, np.zeros(n))
    expected = joint.sum(axis=0) / joint.sum()
    assert np.allclose(tracks.search.probability, expected, rtol=1e-7, atol=1e-12)
    alone = first.probability * likelihood[where]
    assert np.allclose(tracks.confirmed[1].probability, alone / alone.sum(), rtol=1e-7, atol=1e-12)
    here = np.bincount(states.current, alone[:-1] / alone.sum(), n)
    assert np.allclose(tracks.explained[graph.cells], here, atol=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_what_is_left_of_the_looks_at_a_cell_lies_between_nothing_and_all(seed):
    rng = np.random.default_rng(seed)
    cells = rng.integers(9, size=20).astype(np.int32)
    ratios = rng.choice([0.0, 1e-300, 0.01, 1.0, 30.0, 1e90, np.inf], 20)
    explained = rng.choice([0.0, 0.3, 1.0], 9)
    left = np.empty(20)
    kernels.unexplained(cells, ratios, explained, np.empty(9), left)
    assert np.isfinite(left).all()
    for cell in np.unique(cells):
        all_of_it = 1.0
        for ratio in ratios[cells == cell]:
            all_of_it = np.clip(all_of_it * np.clip(ratio, 1e-100, 1e100), 1e-100, 1e100)
        expected = explained[cell] + (1 - explained[cell]) * all_of_it
        assert np.isclose(np.prod(left[cells == cell]), expected, rtol=1e-12)


def test_the_first_target_found_and_no_other_is_told_of_as_by_one_track():
    rng = np.random.default_rng(1)
    tracks = begun(STREET)
    alone = tracks.search.copy()
    ratios, same = np.zeros(40), np.zeros(40)
    for _ in range(5):
        told = rng.random(10) * 1.5
        cells = rng.integers(40, size=10).astype(np.int32)
        assert tracks.second(NOBODY, cells, told, ratios) == alone.second(NOBODY, cells, told, same)
        np.testing.assert_array_equal(ratios, same)


def test_a_target_that_is_followed_in_view_is_found_once():
    for seed in range(10):
        rng = np.random.default_rng(seed)
        states = TargetStates(random_graph(rng, 10, 10, 0.6, 0.8))
        tracks = begun(states)
        paths = walked(states, rng, 80, 1)
        calls = watched(tracks, paths, rng)
        assert [states.graph.node_of_cell[states.graph.cells[node]] for _, node in calls] == [paths[calls[0][0]][0]]
        assert tracks.places[1] == paths[-1][0]


def test_three_targets_in_view_are_found_each_with_few_calls_beside():
    calls_by_one = calls_by_each = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        states = TargetStates(random_graph(rng, 12, 12, 0.7, 0.8))
        tracks, paths = begun(states), walked(states, rng, 60, 3)
        calls = watched(tracks, paths, rng)
        assert {int(np.flatnonzero(paths[second] == node)[0]) for second, node in calls if node in paths[second]} == {
            0,
            1,
            2,
        }
        assert set(paths[-1]) <= set(tracks.places.values())
        calls_by_each += len(calls)
        restarted = begun(states)
        restarted.confirm = lambda _, track=restarted.search: track.restart()
        calls_by_one += len(watched(restarted, paths, np.random.default_rng(seed)))
    assert 24 <= calls_by_each < calls_by_one / 4


def test_two_tracks_of_one_belief_do_not_gather_about_one_target():
    tracks = begun(STREET)
    tracks.confirm(10)
    tracks.confirmed[2], tracks.places[2], tracks.found = tracks.confirmed[1].copy(), 10, 2
    for track in tracks.confirmed.values():
        track.hold(np.abs(STREET.current - 20) <= 8)
    rng, held = np.random.default_rng(0), []
    for node in [20, 21, 21, 20] * 5:
        assert not watched(tracks, [[node]], rng, in_view=lambda _: np.arange(15, 26))
        at = [np.bincount(STREET.current, track.probability[:-1], 40)[node] for track in tracks.confirmed.values()]
        held.append([at[0], at[1] if len(at) > 1 else 0.0])
    assert np.median(held, axis=0)[0] > 0.99
    assert np.median(held, axis=0)[1] < 0.5


def test_two_that_part_are_two_though_they_came_as_one():
    """Both hide in one signal; when they part, what the first leaves unexplained is found."""
    rng = np.random.default_rng(3)
    paths = [[20, 20]] * 15 + [[20 - n, 20 + n] for n in range(1, 12)]
    tracks = begun(STREET)
    calls = watched(tracks, paths, rng)
    assert calls[0][0] < 5
    assert [second >= 15 for second, _ in calls[1:]].count(True) >= 1
    assert sorted(tracks.places.values())[:: len(tracks.places) - 1] == [9, 31]


def test_of_two_in_view_at_once_the_likelier_is_found_and_what_was_believed_of_the_other_stays():
    tracks = begun(STREET)
    ratios = np.zeros(40)
    tracks.second(NOBODY, np.array([5, 30], np.int32), np.array([5e3, 4e3]), ratios)
    before = tracks.search.node_ratios[30] / tracks.search.node_ratios[25]
    assert tracks.confirm(5) == 1
    assert tracks.search.likeliest == 30
    assert np.isclose(tracks.search.node_ratios[30] / tracks.search.node_ratios[25], before)
    assert np.isclose(tracks.search.node_ratios[5], tracks.search.resting / tracks.search.probability[-1] * 3)
    assert tracks.confirmed[1].likeliest == 5
    assert tracks.confirmed[1].node_ratios[30] < 1e-200


def test_a_target_out_of_sight_explains_less_and_less_and_is_dropped():
    tracks = begun(STREET)
    tracks.search.see([20], [1e6])
    tracks.confirm(20)
    explained, ratios = [], np.zeros(40)
    while tracks.confirmed:
        tracks.second(NOBODY, np.empty(0, np.int32), np.empty(0), ratios)
        explained.append(tracks.explained.sum())
    assert np.allclose(np.array(explained[1:-1]) / explained[:-2], 0.8)
    assert 55 < len(explained) < 70
    assert tracks.found == 1


def test_a_target_is_followed_onto_nodes_that_are_detected_later():
    tracks = begun(STREET, explored=False)
    tracks.search.explore(np.arange(10))
    rng = np.random.default_rng(5)
    watched(tracks, [[8]] * 8, rng)
    track = tracks.confirmed[1]
    assert not track.detected[12]
    ratios = np.zeros(40)
    tracks.second(np.arange(10, 20), np.array([8], np.int32), np.array([1e3]), ratios)
    assert track.detected[12]
    assert np.bincount(STREET.current, track.probability[:-1], 40)[12] < 1e-9
    watched(tracks, [[9], [10], [11], [12], [13]], rng)
    assert tracks.places[1] == 13


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_probabilities_total_one_whatever_comes(seed):
    rng = np.random.default_rng(seed)
    states = TargetStates(random_graph(rng))
    tracks, n = begun(states, explored=False), states.n_nodes
    ratios = np.zeros(n)
    for _ in range(60):
        new, nodes = np.flatnonzero(rng.random(n) < 0.1), rng.integers(n, size=8)
        told = rng.choice([0.0, 1e-300, 1e-9, 1.0, 1e9, 1e300, np.inf], 8)
        total, likeliest = tracks.second(new, states.graph.cells[nodes].astype(np.int32), told, ratios)
        if likeliest >= 0 and rng.random() < 0.3:
            tracks.confirm(likeliest)
        assert np.isfinite(total)
        for track in (tracks.search, *tracks.confirmed.values()):
            assert np.isclose(track.probability.sum(), 1.0)
            assert ((track.probability >= 0.0) & (track.probability <= 1.0)).all()
        assert ((tracks.explained >= 0.0) & (tracks.explained <= 1.0)).all()
        assert not np.isnan(tracks.left).any()


def test_copies_go_on_by_themselves_and_can_be_gone_back_to():
    rng = np.random.default_rng(2)
    tracks = begun(STREET)
    paths = walked(STREET, rng, 40, 2)
    watched(tracks, paths, rng)
    kept = tracks.copy(tracks.search.copy())
    before = tracks.places | {}, tracks.found, tracks.confirmed[1].probability.copy()
    watched(tracks, walked(STREET, rng, 40, 2), rng)
    assert not np.array_equal(tracks.confirmed[1].probability if 1 in tracks.confirmed else 0, before[2])
    tracks.restore(kept)
    assert (tracks.places, tracks.found) == before[:2]
    np.testing.assert_array_equal(tracks.confirmed[1].probability, before[2])


def test_a_track_that_begins_again_believes_what_it_does_where_nothing_was_seen_for_long():
    track = begun(STREET).search
    track.see([7], [1e5])
    track.restart()
    long_ago = track.copy()
    for _ in range(300):
        long_ago.move()
    assert np.isclose(track.integrated_ratio, 1.0)
    assert np.isclose(long_ago.integrated_ratio, 1.0)
    assert np.allclose(track.probability[track.probability > 0].min(), track.probability[0])


@pytest.mark.parametrize(
    "bad", [{"lose": -0.1}, {"lose": np.nan}, {"apart_m": -1.0}, {"apart_m": np.inf}, {"drop": 0.0}]
)
def test_impossible_followings_are_refused(bad):
    with pytest.raises(InvalidProblemError, match="came"):
        replace(Following(), **bad)
