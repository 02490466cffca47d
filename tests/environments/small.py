"""Searches small enough to fly many of, and strategies to fly them."""

from functools import cache

import numpy as np

from sooner.simulation import Estimator, Scene, World
from tests.simulation.streets import blocks


@cache
def scene(seconds: int = 40, replan_s: int = 5, n_targets: int = 1, side: int = 20, prior: str = "kriged") -> Scene:
    """Four agents over blocks, with a prior that changes at every replan."""
    world = World(blocks(side), n_targets=n_targets)
    return Scene(world, estimator=Estimator(prior=prior), seconds=seconds, replan_s=replan_s)


def wandering(n_agents: int = 4, waypoints: int = 1):
    """A policy whose answer depends on all that it is shown, as a network's would, in float32."""
    rng = np.random.default_rng(5)
    mixes: dict[str, np.ndarray] = {}

    def policy(observation):
        answer = np.zeros(n_agents * waypoints * 2)
        for name, array in sorted(observation.items()):
            if name not in mixes:
                mixes[name] = rng.normal(0.0, 100.0 / array.size, (answer.size, array.size))
            answer += mixes[name] @ array.ravel().astype(float)
        return np.sin(answer).round(6).astype(np.float32).reshape(n_agents, waypoints, 2)

    return policy


def flown(env, policy, **reset):
    """Fly an environment to its end: (rewards, infos, observations)."""
    observation, info = env.reset(**reset)
    rewards, infos, observations, over = [], [info], [observation], False
    while not over:
        observation, reward, over, truncated, info = env.step(policy(observation))
        assert not truncated
        rewards.append(reward)
        infos.append(info)
        observations.append(observation)
    return rewards, infos, observations


def assert_same_flight(one, other, atol=0.0):
    """Two episodes of one flight, as far as places tell within `atol` metres."""
    np.testing.assert_allclose(one.places_m, other.places_m, atol=atol, rtol=0.0)
    np.testing.assert_array_equal(one.targets, other.targets)
    np.testing.assert_array_equal(one.node_seconds, other.node_seconds)
    np.testing.assert_array_equal(one.sums, other.sums)
    assert one.calls == other.calls
    np.testing.assert_equal([one.seed, one.e_nodes, one.e_targets], [other.seed, other.e_nodes, other.e_targets])
