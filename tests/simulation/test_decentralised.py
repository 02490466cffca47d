"""Agents that each believe and plan for themselves: what they know is what they heard, and no look counts twice."""

import numpy as np
import pytest

from sooner.simulation import Estimator, Scene, World
from sooner.simulation.command import CommandPost
from sooner.simulation.in_flight import Flight
from sooner.simulation.sensing import LookLog
from sooner.simulation.strategies import make_strategy
from tests.simulation.streets import blocks

GRAPH = blocks()


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


@pytest.mark.parametrize("prior", ["uniform", "kriged"])
@pytest.mark.parametrize("name", ["information", "joint", "rollouts"])
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
        for name in ("void", "unoccupied", "occupied", "explored", "nodes"):
            np.testing.assert_array_equal(getattr(again.belief.states, name), getattr(once.belief.states, name))
        np.testing.assert_array_equal(again.belief.track.probability, once.belief.track.probability)
        np.testing.assert_array_equal(again.belief.node_seconds, once.belief.node_seconds)
        assert again.belief.has_called == once.belief.has_called
        if once.session is not None:
            np.testing.assert_array_equal(again.session, once.session)
