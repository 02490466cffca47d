"""With links every agent is shown what it believes itself, of what it has seen and heard."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from sooner.environments import PolicyStrategy, SearchEnv, SearchParallelEnv, StrategyPolicy
from sooner.errors import InvalidProblemError
from sooner.simulation import Links, simulate
from sooner.simulation.strategies import RandomWaypoints
from tests.environments.small import assert_same_flight, scene, wandering

DEAF = Links(loss=1.0)


def flown(env, seed):
    """Fly anywhere: observations and rewards of every turn."""
    rng = np.random.default_rng(seed)
    observations, _ = env.reset(seed=seed)
    told = [(observations, None)]
    while env.agents:
        actions = {agent: rng.uniform(-1.0, 1.0, (1, 2)) for agent in env.agents}
        observations, rewards, *_ = env.step(actions)
        told.append((observations, rewards))
    return told


def test_over_lossless_links_it_is_the_environment_without_links():
    linked, plain = (SearchParallelEnv(replace(scene(), links=links)) for links in (Links(), None))
    for seed in (0, 1):
        np.testing.assert_equal(flown(linked, seed), flown(plain, seed))
        assert_same_flight(linked.episode, plain.episode)


def test_an_agent_that_hears_nobody_is_shown_what_it_saw_alone():
    env = SearchParallelEnv(replace(scene(), links=DEAF))
    told = flown(env, 2)
    places, grid = env.episode.places_m, env.turns.scene.grid
    for turn, (observations, _) in enumerate(told[:-1]):
        for agent in range(4):
            track = places[: 5 * turn + 1, agent]
            apart = np.hypot(*(track[:, None] - grid.centres_m).transpose(2, 0, 1))
            seen = (apart <= 12.5).any(axis=0).reshape(grid.shape)
            np.testing.assert_array_equal(observations[f"agent_{agent}"]["maps"][2] > 0, seen)


def test_an_agent_knows_its_own_place_whatever_it_hears():
    env = SearchParallelEnv(replace(scene(), links=DEAF))
    env.reset(seed=3)
    rng = np.random.default_rng(3)
    for _ in range(6):
        actions = {agent: rng.uniform(-1.0, 1.0, (1, 2)) for agent in env.agents}
        observations, *_ = env.step(actions)
        for number, agent in enumerate(env.agents):
            own = observations[agent]["agents"][0]
            np.testing.assert_allclose(-2.5 + 50.0 * (own[:2] + 1.0), env.turns.flight.places_m[number], atol=1e-4)
            np.testing.assert_allclose(own[4:], actions[agent][0], atol=1e-6)


def test_the_checks_of_pettingzoo_pass_and_the_return_is_e():
    linked = replace(scene(), links=Links(range_m=40.0, loss=0.3, delay_s=2))
    parallel_api_test(SearchParallelEnv(linked), num_cycles=20)
    parallel_seed_test(lambda: SearchParallelEnv(linked), num_cycles=20)
    env = SearchParallelEnv(linked)
    total = sum(rewards["agent_1"] for _, rewards in flown(env, 4)[1:])
    assert total == pytest.approx(env.episode.e, rel=0, abs=1e-12)


def test_the_state_is_what_each_believes():
    env = SearchParallelEnv(replace(scene(), links=DEAF))
    told = flown(env, 5)[-1][0]
    assert env.state() in env.state_space
    for agent, state in enumerate(np.split(env.state(), 4)):
        own = gymnasium.spaces.unflatten(env.observation_space("agent_0"), state)
        np.testing.assert_array_equal(own["maps"], told[f"agent_{agent}"]["maps"])


def test_a_policy_flies_over_links_aboard_every_agent():
    linked = replace(scene(), links=Links())
    one, other = (simulate(each, PolicyStrategy(wandering()), 1) for each in (linked, scene()))
    np.testing.assert_array_equal(one.places_m, other.places_m)
    assert simulate(replace(scene(), links=DEAF), PolicyStrategy(wandering()), 1).e_nodes > 0.0


def test_one_policy_for_a_team_of_many_beliefs_is_refused():
    linked = replace(scene(), links=Links())
    with pytest.raises(InvalidProblemError, match="scenes with links came"):
        SearchEnv(linked)
    with pytest.raises(InvalidProblemError, match="with links and without"):
        SearchParallelEnv((linked, scene()))
    env = SearchParallelEnv(linked)
    env.reset(seed=0)
    with pytest.raises(InvalidProblemError, match="expected a scene without links"):
        StrategyPolicy(RandomWaypoints(), env)({})
