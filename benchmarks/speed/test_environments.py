"""Timings of environments for learners: nothing is asserted about the clock."""

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from sooner.environments import SearchEnv, SearchParallelEnv, generated_scenes

TURNS = 48  # of a search of 240 s

SCENES = generated_scenes(range(3))


@pytest.fixture
def actions():
    """Four agents' waypoints, anywhere, for all turns."""
    return np.random.default_rng(0).uniform(-1.0, 1.0, (TURNS, 4, 1, 2)).astype(np.float32)


def test_a_search_of_48_turns_by_one_policy(benchmark, actions):
    env = SearchEnv(SCENES)

    def fly():
        env.reset(seed=0)
        for action in actions:
            env.step(action)

    benchmark(fly)


def test_a_search_of_48_turns_by_a_policy_for_each(benchmark, actions):
    env = SearchParallelEnv(SCENES)

    def fly():
        env.reset(seed=0)
        for action in actions:
            env.step(dict(zip(env.agents, action, strict=True)))

    benchmark(fly)


def test_eight_searches_side_by_side(benchmark, actions):
    envs = SyncVectorEnv([lambda: SearchEnv(SCENES)] * 8)

    def fly():
        envs.reset(seed=0)
        for action in actions:
            envs.step(np.stack([action] * 8))

    benchmark(fly)


def test_a_picture(benchmark):
    env = SearchEnv(SCENES, render_mode="rgb_array")
    env.reset(seed=0)
    env.step(np.zeros((4, 1, 2)))
    benchmark(env.render)
