"""The checks that Gymnasium and PettingZoo ship pass; the test run takes their warnings for errors."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test
from pettingzoo.utils import parallel_to_aec

from sooner.environments import SearchEnv, SearchParallelEnv
from tests.environments.small import flown, scene, wandering


@pytest.mark.parametrize("waypoints", [1, 3])
def test_the_checks_of_gymnasium_pass(waypoints):
    env = gymnasium.make("sooner/UnknownCity-v0", scenes=(scene(), scene(60)), waypoints=waypoints)
    check_env(env.unwrapped)


def test_the_environment_is_made_by_its_name_in_cities_of_its_own():
    env = gymnasium.make("sooner/UnknownCity-v0")
    observation, info = env.reset(seed=1)
    assert observation in env.observation_space
    assert len(env.unwrapped.scenes) == 12
    assert info["seed"] == 1


def test_the_checks_of_pettingzoo_pass():
    parallel_api_test(SearchParallelEnv(scene(), waypoints=2), num_cycles=100)
    parallel_seed_test(lambda: SearchParallelEnv((scene(), scene(60))), num_cycles=20)


@pytest.mark.filterwarnings(  # observations are several arrays in a dictionary, which is legal
    "ignore:Observation is not a NumPy array", "ignore:Observation space for each agent probably should be"
)
def test_agents_that_take_turns_pass_the_checks_as_well():
    api_test(parallel_to_aec(SearchParallelEnv(scene())), num_cycles=40)


def test_the_state_is_the_common_observation():
    env = SearchParallelEnv(scene())
    first = env.reset(seed=0)[0]["agent_0"]
    assert env.state() in env.state_space
    unflat = gymnasium.spaces.unflatten(env.observation_space("agent_0"), env.state())
    for name, array in first.items():
        np.testing.assert_array_equal(unflat[name], array)


def test_several_fly_side_by_side_as_each_does_alone():
    scenes, policy = (scene(), scene(60)), wandering()
    envs = SyncVectorEnv([lambda: SearchEnv(scenes)] * 3, autoreset_mode=AutoresetMode.DISABLED)
    observations, _ = envs.reset(seed=[4, 5, 6], options={"scene": 0})
    total = np.zeros(3)
    for _ in range(8):
        actions = [policy({name: array[n] for name, array in observations.items()}) for n in range(3)]
        observations, rewards, over, _, _ = envs.step(np.stack(actions))
        total += rewards
    assert over.all()
    alone = [sum(flown(SearchEnv(scenes), policy, seed=seed, options={"scene": 0})[0]) for seed in (4, 5, 6)]
    np.testing.assert_allclose(total, alone, rtol=0, atol=1e-12)


def test_made_by_number_they_begin_again_by_themselves():
    envs = gymnasium.make_vec("sooner/UnknownCity-v0", num_envs=2, vectorization_mode="sync", scenes=(scene(),))
    envs.reset(seed=0)
    over = [envs.step(envs.action_space.sample())[2].all() for _ in range(18)]
    assert [n for n, each in enumerate(over) if each] == [7, 16]  # eight turns, and one to begin again


def test_wrappers_that_learners_use_go_round_it():
    env = gymnasium.make("sooner/UnknownCity-v0", scenes=(scene(),))
    env = gymnasium.wrappers.RescaleAction(env, np.float32(0.0), np.float32(1.0))
    env = gymnasium.wrappers.RecordEpisodeStatistics(gymnasium.wrappers.FlattenObservation(env))
    env.reset(seed=3)
    over = False
    while not over:
        observation, _, over, _, info = env.step(env.action_space.sample())
    assert observation in env.observation_space
    assert info["episode"]["r"] == pytest.approx(info["e"])
