"""Agents that each believe and plan for themselves: what they know is what they heard, and no look counts twice."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors.graded import GradedSensor
from sooner.simulation import (
    Agent,
    Estimator,
    Links,
    Scene,
    World,
    flight,
    load_episode,
    replayed,
    save_episode,
    simulate,
)
from sooner.simulation.command import CommandPost
from sooner.simulation.decentralised_command import DecentralisedCommand
from sooner.simulation.in_flight import Flight
from sooner.simulation.network import Network
from sooner.simulation.sensing import LookLog
from sooner.simulation.strategies import RandomWaypoints, make_strategy
from sooner.simulation.world import Purpose, generator
from sooner.streets import OccupancyGraph
from tests.simulation.streets import blocks

GRAPH = blocks()
SHARP = Agent(map_sensor=GradedSensor(8.0, 41), target_sensor=GradedSensor(8.0, 41))
STATES = ("void", "unoccupied", "occupied", "explored", "nodes")

some_links = st.builds(
    Links,
    range_m=st.sampled_from([0.0, 20.0, 45.0, 80.0, inf]),
    loss=st.sampled_from([0.0, 0.3, 0.8, 1.0]),
    delay_s=st.integers(0, 12),
    relays=st.booleans(),
)


def copied(log) -> LookLog:
    """The newest second of a log by itself."""
    part = LookLog(0)
    for name, column in vars(log).items():
        if isinstance(column, np.ndarray):
            setattr(part, name, column[log.start : log.end].copy())
    part.end = log.end - log.start
    return part


def flown(scene, strategy, seed):
    """A search by one command post: what it heard in each second, the post, and what it believed at the twentieth."""
    flight = Flight(scene, seed, scene.starts(strategy, seed), strategy.capture)
    post, heard, kept = CommandPost(scene, strategy, seed), [], None
    while not flight.over:
        flight.look()
        heard.append(copied(flight.log))
        post.see(flight)
        if flight.second % scene.replan_s == 0:
            routes = post.plan(flight)
            if routes is not None:
                flight.reroute(routes)
            if flight.second == 20:
                kept = post.kept()
        flight.go_on()
    return heard, post, kept


@pytest.mark.parametrize(("name", "prior"), [("information", "uniform"), ("joint", "kriged"), ("rollouts", "uniform")])
def test_a_command_post_that_goes_back_and_hears_again_believes_the_same(name, prior):
    scene, strategy = Scene(World(GRAPH), seconds=40, estimator=Estimator(prior=prior)), make_strategy(name)
    heard, post, kept = flown(scene, strategy, 3)
    once = post.kept()
    for _ in range(2):
        post.restore(kept)
        assert kept.belief.states.explored.sum() < once.belief.states.explored.sum()
        for second in range(21, 40):
            post.hear(second, heard[second])
            if second % scene.replan_s == 0:
                post.belief.predict()
        again = post.kept()
        for name in STATES:
            np.testing.assert_array_equal(getattr(again.belief.states, name), getattr(once.belief.states, name))
        np.testing.assert_array_equal(again.belief.track.probability, once.belief.track.probability)
        np.testing.assert_array_equal(again.belief.node_seconds, once.belief.node_seconds)
        assert again.belief.has_called == once.belief.has_called
        if once.session is not None:
            np.testing.assert_array_equal(again.session, once.session)


@pytest.mark.parametrize(
    ("name", "prior"),
    [
        ("random", "uniform"),
        ("lawnmower", "known"),
        ("information", "kriged"),
        ("information", "uniform"),
        ("joint", "kriged"),
        ("rollouts", "kriged"),
    ],
)
def test_links_that_lose_nothing_reach_all_and_are_prompt_are_one_command_post(name, prior):
    scene = Scene(World(GRAPH, n_targets=2), seconds=61, estimator=Estimator(prior=prior))
    together = simulate(scene, make_strategy(name), 5)
    apart = simulate(replace(scene, links=Links()), make_strategy(name), 5)
    for part in ("places_m", "node_seconds", "sums", "targets"):
        np.testing.assert_array_equal(getattr(apart, part), getattr(together, part))
    assert apart.calls == together.calls
    for plan, other in zip(apart.plans, together.plans, strict=True):
        for route, other_route in zip(plan, other, strict=True):
            np.testing.assert_array_equal(route, other_route)
    assert (apart.agents_node_seconds == together.node_seconds).all()
    assert apart.e_nodes_by_all == together.e_nodes == together.e_nodes_by_all


@pytest.mark.parametrize("tracks", ["restarted", "each"])
def test_perfect_links_are_one_command_post_for_several_tracks_too(tracks):
    scene = Scene(World(GRAPH, n_targets=3), (SHARP,) * 4, Estimator(tracks=tracks), seconds=60)
    together, apart = (simulate(each, make_strategy("joint"), 2) for each in (scene, replace(scene, links=Links())))
    assert len(together.calls) > 1
    assert apart.calls == together.calls
    np.testing.assert_array_equal(apart.places_m, together.places_m)


def test_perfect_links_are_one_command_post_for_tests_of_cells_too():
    scene = Scene(World(GRAPH, n_targets=3), seconds=90, estimator=Estimator("cbht"))
    together, apart = (simulate(each, RandomWaypoints(), 2) for each in (scene, replace(scene, links=Links())))
    assert apart.calls == together.calls
    np.testing.assert_array_equal(apart.sums, together.sums)


def believed_from(scene, heard, clock, second):
    """A belief that is made once, of the looks that a clock says are known."""
    belief = scene.estimator.begun(scene.world, scene.sensing.most_looks)
    for past in range(second + 1):
        belief.see(past, of_agents(heard[past], clock >= past))
        if past % scene.replan_s == 0:
            belief.predict()
    return belief


def of_agents(log, who) -> LookLog:
    part, which = LookLog(0), who[log.agents]
    for name, column in vars(log).items():
        if isinstance(column, np.ndarray):
            setattr(part, name, column[which])
    part.end = int(which.sum())
    return part


@settings(max_examples=12, deadline=None)
@given(
    some_links,
    st.sampled_from(["uniform", "kriged"]),
    st.sampled_from(["one", "restarted", "each"]),
    st.integers(0, 99),
)
def test_at_each_plan_a_belief_is_that_of_the_looks_that_the_agent_has_each_once(links, prior, tracks, seed):
    estimator = Estimator(prior=prior, tracks=tracks)
    scene = Scene(World(GRAPH, n_targets=3), (SHARP,) * 4, estimator, seconds=26, links=links)
    strategy = RandomWaypoints()
    flown = Flight(scene, seed, scene.starts(strategy, seed), strategy.capture)
    command, heard = DecentralisedCommand(scene, strategy, links, seed), []
    while not flown.over:
        flown.look()
        heard.append(copied(flown.log))
        command.see(flown)
        if flown.second % scene.replan_s == 0:
            flown.reroute(command.plan(flown))
            for clock, belief in zip(command.network.clocks, command.beliefs, strict=True):
                again = believed_from(scene, heard, clock, flown.second)
                for name in STATES:
                    np.testing.assert_array_equal(getattr(belief.states, name), getattr(again.states, name))
                np.testing.assert_array_equal(belief.track.probability, again.track.probability)
                assert belief.has_called == again.has_called
                assert belief.followed == again.followed
        for belief in command.beliefs:
            three = np.array([belief.states.void, belief.states.unoccupied, belief.states.occupied])
            assert ((three >= 0.0) & (three <= 1.0)).all()
            np.testing.assert_allclose(three.sum(axis=0), 1.0, atol=1e-9)
            np.testing.assert_allclose(belief.track.probability.sum(), 1.0, atol=1e-9)
        flown.go_on()


@pytest.mark.parametrize("delay_s", [1, 4, 7])
def test_what_is_late_but_never_lost_is_known_to_all_when_the_delay_has_passed(delay_s):
    scene = Scene(World(GRAPH), seconds=60, links=Links(delay_s=delay_s))
    strategy = make_strategy("lawnmower")
    flown = Flight(scene, 1, scene.starts(strategy, 1), strategy.capture)
    command, post, central = DecentralisedCommand(scene, strategy, scene.links, 1), CommandPost(scene, strategy, 1), {}
    while not flown.over:
        second = flown.second
        flown.look()
        command.see(flown)
        post.see(flown)
        if second % scene.replan_s == 0:
            post.plan(flown)
            routes = command.plan(flown)
            if routes is not None:
                flown.reroute(routes)
            central[second] = post.kept().belief
        off = ~np.eye(4, dtype=bool)
        assert (command.network.clocks[off] == max(second - delay_s, -1)).all()
        for aboard in command._aboard:
            surest = aboard._checkpoints[0]
            if second % scene.replan_s == 0 and second >= delay_s:
                assert second - delay_s - scene.replan_s < surest.second <= second - delay_s
                for name in STATES:
                    left, right = surest.kept.belief.states, central[surest.second].states
                    np.testing.assert_array_equal(getattr(left, name), getattr(right, name))
        flown.go_on()
    # lanes never change, so that flying on along the last route heard of is where the others are
    np.testing.assert_array_equal(
        [report.place_m for report in command._reckoned(flown, 0, command._aboard[0])][1:], flown.places_m[1:]
    )


@settings(max_examples=25, deadline=None)
@given(some_links, st.integers(0, 999), st.integers(2, 5))
def test_clocks_say_which_looks_came_and_messages_leave_out_only_what_all_have(links, seed, n_agents):
    rng, draws = np.random.default_rng(seed), generator(seed, Purpose.LINKS)
    places = rng.uniform(0.0, 100.0, (n_agents, 2))
    network, routes = Network(links, places, seed), (np.empty((0, 2)),) * n_agents
    have, due = [set() for _ in places], {}
    for second in range(30):
        before = [set(each) for each in have]
        places = places + rng.normal(0.0, 10.0, places.shape)
        since = network.exchange(second, places, np.zeros_like(places), routes)
        lost = draws.random((n_agents, n_agents)) < links.loss
        for agent in range(n_agents):
            have[agent].add((second, agent))
        for sender, receiver in np.argwhere(~lost & ~np.eye(n_agents, dtype=bool)).tolist():
            if np.linalg.norm(places[sender] - places[receiver]) <= links.range_m:
                all_of_it = {look for look in have[sender] if links.relays or look[1] == sender}
                due.setdefault(second + links.delay_s, []).append((receiver, all_of_it))
        for receiver, looks in due.pop(second, []):
            have[receiver] |= looks
        for agent, clock in enumerate(network.clocks):
            assert have[agent] == {(s, k) for k, last in enumerate(clock) for s in range(last + 1)}
            assert since[agent] == min(s for s, _ in have[agent] - before[agent])
            assert (network.known[agent] <= network.clocks).all()
            assert all(network.reports[agent][k].second == last for k, last in enumerate(clock) if last >= 0)


def test_prompt_links_hold_no_more_than_the_last_seconds_and_silent_ones_all():
    for links, most in ((Links(), 4), (Links(loss=1.0), 30)):
        network = Network(links, np.zeros((4, 2)), 1)
        for second in range(30):
            network.exchange(second, np.zeros((4, 2)), np.zeros((4, 2)), (np.empty((0, 2)),) * 4)
        assert (network.held == most).all()


def test_who_hears_at_a_loss_hears_at_a_smaller_one_whatever_the_range():
    def heard(links):
        network, places = Network(links, np.zeros((3, 2)), 4), np.array([[0.0, 0.0], [30.0, 0.0], [60.0, 0.0]])
        return np.array([network._hears(places) for _ in range(50)])

    most, some, few = (heard(Links(loss=loss)) for loss in (0.3, 0.6, 0.9))
    assert (most >= some).all()
    assert (some >= few).all()
    near = heard(Links(range_m=30.0, loss=0.6))
    assert (near[:, 0, 1] == some[:, 0, 1]).all()
    assert not near[:, 0, 2].any()


@pytest.mark.parametrize("links", [Links(range_m=0.0), Links(loss=1.0)])
def test_who_hears_nobody_knows_what_it_saw_and_no_more(links):
    scene = Scene(World(GRAPH), seconds=40, links=links)
    flown = simulate(scene, make_strategy("lawnmower"), 1)
    alone = simulate(replace(scene, links=None), make_strategy("lawnmower"), 1)
    np.testing.assert_array_equal(flown.places_m, alone.places_m)
    seen = flown.agents_node_seconds >= 0
    assert (seen.sum(axis=0) <= 1).mean() > 0.97
    assert flown.e_nodes_by_all == 0.0
    assert flown.e_nodes == pytest.approx(alone.e_nodes, abs=0.01)


def test_a_node_counts_when_the_first_agent_has_detected_it():
    flown = simulate(Scene(World(GRAPH), seconds=60, links=Links(40.0, 0.5, 3)), make_strategy("information"), 6)
    by_agent = np.where(flown.agents_node_seconds < 0, 1000, flown.agents_node_seconds)
    np.testing.assert_array_equal(np.where(flown.node_seconds < 0, 1000, flown.node_seconds), by_agent.min(axis=0))
    assert flown.e_nodes_by_all < flown.e_nodes


def test_looks_are_forgotten_that_nobody_can_be_led_back_to():
    scene = Scene(World(GRAPH), seconds=60, links=Links(delay_s=3))
    strategy = RandomWaypoints()
    flown = Flight(scene, 1, scene.starts(strategy, 1), strategy.capture)
    command = DecentralisedCommand(scene, strategy, scene.links, 1)
    while not flown.over:
        flown.look()
        command.see(flown)
        if flown.second % scene.replan_s == 0:
            flown.reroute(command.plan(flown))
        assert len(command._store) <= 3 + 2 * scene.replan_s
        flown.go_on()


def test_links_of_one_seed_are_the_same_twice_and_a_file_keeps_them(tmp_path):
    scene = Scene(World(GRAPH), seconds=40, links=Links(50.0, 0.3, 2, relays=False))
    flown = simulate(scene, make_strategy("rollouts"), 7)
    save_episode(flown, tmp_path / "episode.npz")
    loaded = load_episode(tmp_path / "episode.npz")
    assert loaded.scene.links == scene.links
    again = replayed(loaded)
    np.testing.assert_array_equal(again.places_m, flown.places_m)
    np.testing.assert_array_equal(again.agents_node_seconds, loaded.agents_node_seconds)


def test_an_infinite_range_can_be_kept():
    assert Links.of(Links(delay_s=3).said()) == Links(delay_s=3)


def test_others_are_thought_where_their_last_route_leads_them():
    scene = Scene(World(GRAPH), (Agent(), Agent(v_max=6.0)), seconds=40, links=Links(delay_s=3))
    strategy = make_strategy("lawnmower")
    flown = Flight(scene, 1, scene.starts(strategy, 1), strategy.capture)
    command = DecentralisedCommand(scene, strategy, scene.links, 1)
    report = command.network.reports[0][1]
    route = np.array([[50.0, 50.0], [80.0, 20.0]])
    told = command._flown_on(1, replace(report, second=4, route=route), 30)
    path = flight(scene.agents[1], report.place_m, route, capture_m=1.25, seconds=26)
    np.testing.assert_allclose(told.place_m, path[-1])
    assert told.second == 30
    assert told.route.tolist() == [[80.0, 20.0]]
    assert flown.second == 0


def test_those_not_heard_of_are_thought_to_fly_what_the_last_plan_had_in_mind_for_them():
    scene = Scene(World(GRAPH), seconds=20, links=Links(loss=1.0))
    strategy = make_strategy("joint")
    flown = Flight(scene, 1, scene.starts(strategy, 1), strategy.capture)
    command = DecentralisedCommand(scene, strategy, scene.links, 1)
    flown.look()
    command.see(flown)
    command.plan(flown)
    minded = command._aboard[0].thought[1]
    assert len(minded.route) > 1
    while flown.second < 5:
        flown.go_on()
    told = command._reckoned(flown, 0, command._aboard[0])[1]
    path = flight(scene.agents[1], minded.place_m, minded.route, capture_m=6.25, seconds=5)
    np.testing.assert_allclose(told.place_m, path[-1])
    assert np.linalg.norm(told.place_m - minded.place_m) > 5.0


@pytest.mark.parametrize(
    "bad", [{"range_m": -1.0}, {"range_m": np.nan}, {"loss": 1.1}, {"loss": np.nan}, {"delay_s": -1}, {"delay_s": 0.5}]
)
def test_impossible_links_are_refused(bad):
    with pytest.raises(InvalidProblemError, match="came"):
        Links(**bad)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"agents": (Agent(),)}, "between 1 agents"),
        ({"agents": (Agent(),) * 101}, "between 101 agents"),
        (
            {"world": World(OccupancyGraph.of(Grid((700, 700), "square8", 5.0), [0], np.empty((0, 2), int)))},
            "over 490,000 cells",
        ),
        ({"seconds": 100_000, "agents": (Agent(radius_m=30.0),) * 10}, "a shorter mission"),
    ],
)
def test_links_that_would_not_fit_are_refused(change, said):
    with pytest.raises(InvalidProblemError, match=said):
        replace(Scene(World(GRAPH), links=Links()), **change)
