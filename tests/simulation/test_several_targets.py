"""Several targets: each found is followed by a track of its own, and the search goes on for the others."""

from dataclasses import replace

import numpy as np
import pytest

from sooner.belief.cell_states import CellStates
from sooner.errors import DataFormatError, InvalidProblemError
from sooner.grid import Grid
from sooner.simulation import Call, Estimator, Scene, World, load_episode, replayed, save_episode, simulate
from sooner.simulation.command import CommandPost
from sooner.simulation.in_flight import Flight
from sooner.simulation.picture import picture_of
from sooner.simulation.strategies import Lawnmower, make_strategy
from sooner.simulation.strategies.presence import Presence
from tests.simulation.streets import blocks

GRAPH = blocks()
THREE = Scene(World(GRAPH, n_targets=3), seconds=120, estimator=Estimator(tracks="each"))
RESTARTED = replace(THREE, estimator=Estimator(tracks="restarted"))


@pytest.fixture(scope="module")
def flown():
    return [simulate(THREE, Lawnmower(1.0, 0.5, 0.5), seed) for seed in range(12)]


def test_targets_that_are_found_have_tracks_of_their_own(flown):
    for each in flown:
        numbers = np.unique(each.followed[:, 1]).tolist()
        assert numbers == list(range(1, len(each.calls) + 1))
        for number, call in enumerate(each.calls, 1):
            second, _, cell = each.followed[each.followed[:, 1] == number][0]
            assert (second, cell) == (call.second, call.cell)
        assert (np.diff(each.followed[:, 0]) >= 0).all()
    assert max(len(each.calls) for each in flown) >= 3


def test_a_target_is_found_once_where_a_tracker_that_begins_again_calls_it_again_and_again(flown):
    begun_again = [simulate(RESTARTED, Lawnmower(1.0, 0.5, 0.5), seed) for seed in range(12)]
    for one, other in zip(flown, begun_again, strict=True):
        np.testing.assert_array_equal(one.places_m, other.places_m)
    found = [sum((each.found_targets >= 0).sum() for each in some) for some in (flown, begun_again)]
    repeated = [sum(each.repeated_calls for each in some) for some in (flown, begun_again)]
    assert found[0] >= found[1] - 1
    assert found[0] > 12
    assert 4 * repeated[0] < repeated[1]


def test_until_the_first_call_and_with_no_other_setting_nothing_is_changed():
    strategy = make_strategy("joint")
    for seed in range(3):
        one, each = (
            simulate(replace(THREE, estimator=Estimator(prior="kriged", tracks=tracks)), strategy, seed)
            for tracks in ("one", "each")
        )
        first = one.calls[0].second
        assert each.calls[0] == one.calls[0]
        np.testing.assert_array_equal(one.sums[: first + 1], each.sums[: first + 1])
        np.testing.assert_array_equal(one.places_m[: first + 1], each.places_m[: first + 1])
        assert not len(one.followed)
        plain = simulate(replace(THREE, estimator=Estimator(prior="kriged")), strategy, seed)
        np.testing.assert_array_equal(one.places_m, plain.places_m)


def test_calls_are_finds_false_or_repeated(flown):
    calls = (Call(9, 0, -1), Call(30, 0, 1), Call(40, 0, 1), Call(50, 0, 2), Call(60, 0, 1), Call(61, 0, -1))
    scored = replace(flown[0], calls=calls)
    assert scored.found_targets.tolist() == [-1, 30, 50]
    assert (scored.false_calls, scored.repeated_calls) == (2, 2)


@pytest.mark.parametrize("tracks", ["each", "restarted"])
def test_strategies_are_told_that_another_is_sought_and_where_one_was_found(tracks):
    told = []

    class Listening:
        capture = 0.5

        def starts(self, grid, agents, drawn):
            return drawn

        def session(self, situation, rng):
            return self

        def watch(self, cells, target_ratios):
            self.cells, self.ratios = cells.copy(), target_ratios.copy()

        def found(self, cell):
            told.append(cell)

        def routes(self, situation):
            told.append((situation.sought, situation.found))
            return (np.array([[47.0, 47.0]]),) * 4

    scene = replace(THREE, estimator=Estimator(tracks=tracks))
    flown = simulate(scene, Listening(), 2)
    assert [each for each in told if isinstance(each, int)] == [call.cell for call in flown.calls]
    assert [each for each in told if isinstance(each, tuple)][-1] == (True, True)
    assert told[0] == (True, False)


def test_what_is_seen_of_a_target_that_is_followed_says_nothing_of_another():
    scene = replace(THREE, world=World(GRAPH, n_targets=1), starts_m=np.tile([[47.0, 47.0]], (4, 1)))
    strategy = Lawnmower()
    for seed in range(30):
        flight = Flight(scene, seed, scene.starts(strategy, seed), 0.5)
        post = CommandPost(scene, strategy, seed)
        while not flight.over:
            flight.look()
            _, calls = post.see(flight)
            seen = flight.log.newest_cells == scene.world.graph.cells[flight.truth.nodes_at(flight.second)[0]]
            if post.belief.followed and not calls and seen.any():
                left = np.prod(post.belief.newest_ratios[seen])
                assert left <= max(np.prod(flight.log.newest_target_ratios[seen]), 1.0) + 1e-9
                if flight.second > 60:
                    return
            flight.go_on()


def test_near_a_target_that_was_found_the_presence_of_another_is_as_elsewhere():
    grid = Grid((20, 20), "square8", 5.0)
    presence = Presence(grid, CellStates.unknown(grid.n_cells))
    presence.watch(np.array([210, 30], np.int32), np.array([500.0, 0.01]))
    before = presence.shares.copy()
    presence.found(210)
    likely = 1.0 - presence.states.void
    assert (presence.shares * likely).sum() == pytest.approx(1.0)
    assert presence.shares[210] == pytest.approx(presence.shares[310], rel=0.2)
    np.testing.assert_allclose(presence.shares[30] / presence.shares[399], before[30] / before[399])


def test_a_command_post_goes_back_to_the_targets_that_it_followed():
    scene, strategy = replace(THREE, seconds=60), make_strategy("joint")
    flight = Flight(scene, 5, scene.starts(strategy, 5), strategy.capture)
    post, kept, then = CommandPost(scene, strategy, 5), None, {}
    while not flight.over:
        flight.look()
        post.see(flight)
        if flight.second % scene.replan_s == 0:
            routes = post.plan(flight)
            if routes is not None:
                flight.reroute(routes)
        if post.belief.followed and kept is None:
            kept, then = post.kept(), dict(post.belief.followed)
            ratios = post.belief.track.node_ratios
        flight.go_on()
    assert kept is not None
    assert post.belief.followed != then
    post.restore(kept)
    assert post.belief.followed == then
    np.testing.assert_array_equal(post.belief.track.node_ratios, ratios)
    assert post.belief.tracks.search is post.belief.track


def test_an_episode_with_several_tracks_is_kept_flown_again_and_drawn(flown, tmp_path):
    episode = max(flown, key=lambda each: len(each.followed))
    save_episode(episode, tmp_path / "e.npz")
    loaded = load_episode(tmp_path / "e.npz")
    np.testing.assert_array_equal(loaded.followed, episode.followed)
    again = replayed(loaded)
    np.testing.assert_array_equal(again.followed, episode.followed)
    assert again.calls == episode.calls
    assert picture_of(episode).startswith(b"\x89PNG")


@pytest.mark.parametrize("wrong", [[[10**6, 1, 0]], [[0, 10**6, 0]], [[0, 1, 10**6]], [[-1, 1, 0]]])
def test_targets_followed_that_cannot_be_are_refused(flown, tmp_path, wrong):
    save_episode(replace(flown[0], followed=np.array(wrong)), tmp_path / "e.npz")
    with pytest.raises(DataFormatError, match="came"):
        load_episode(tmp_path / "e.npz")


@pytest.mark.parametrize("bad", [{"tracks": "two"}, {"tracks": "each", "detector": "cbht"}])
def test_impossible_tracks_are_refused(bad):
    with pytest.raises(InvalidProblemError, match="came"):
        Estimator(**bad)
