"""A policy flies in `simulate` as in the environment, and a strategy in the environment as in `simulate`."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from sooner.environments import PolicyStrategy, SearchEnv, StrategyPolicy
from sooner.errors import InvalidProblemError
from sooner.simulation import Estimator, load_episode, save_episode, simulate
from sooner.simulation.strategies import Information, RandomWaypoints, make_strategy
from tests.environments.small import assert_same_flight, flown, scene, wandering


@pytest.mark.parametrize(("waypoints", "n_targets"), [(1, 1), (3, 0), (2, 2)])
def test_a_policy_flies_as_a_strategy_to_the_last_bit_as_in_the_environment(waypoints, n_targets):
    search, policy = scene(60, n_targets=n_targets), wandering(waypoints=waypoints)
    env = SearchEnv(search, waypoints=waypoints)
    for seed in (0, 7):
        flown(env, policy, seed=seed)
        assert_same_flight(env.episode, simulate(search, PolicyStrategy(policy), seed))


@pytest.mark.parametrize("prior", ["uniform", "kriged"])
@pytest.mark.parametrize(
    ("strategy", "waypoints"),
    [
        (RandomWaypoints(), 1),
        (Information(tasks=40), 3),
        (Information(tasks=40, waypoints=2), 1),
        (make_strategy("rollouts"), 50),
    ],
)
def test_a_strategy_flies_the_environment_as_simulate_flies_it(strategy, waypoints, prior):
    """Within what turning metres into shares and back rounds off."""
    search = scene(60, prior=prior)
    env = SearchEnv(search, waypoints=waypoints, capture=strategy.capture)
    policy = StrategyPolicy(strategy, env)
    for seed in (1, 2):
        flown(env, policy, seed=seed)
        assert_same_flight(env.episode, simulate(search, strategy, seed), atol=1e-9)


class Watcher:
    """A strategy whose sessions write down what they are shown; its routes differ in length."""

    capture = 0.5

    def __init__(self):
        self.shown = []

    def starts(self, grid, agents, drawn):
        return drawn

    def session(self, situation, rng):
        self.shown.append([])
        return self

    def watch(self, cells, target_ratios):
        self.shown[-1].append((cells.copy(), target_ratios.copy()))

    def found(self, cell):
        self.shown[-1].append(cell)

    def routes(self, situation):
        self.shown[-1].append([route.round(9) for route in situation.routes])
        way = np.array([[10.0, 10.0], [50.0, 50.0], [50.0, 50.0], [90.0, 10.0], [10.0, 90.0]])
        return tuple(way[first:] for first in (0, 1, 3, 4))


def test_sessions_are_told_in_an_environment_what_they_are_told_in_simulate():
    """What is left of their routes and, if they believe for themselves, every second's looks once and what is found."""
    here, there = Watcher(), Watcher()
    search = replace(scene(62, n_targets=3), estimator=Estimator(tracks="each"))
    env = SearchEnv(search, waypoints=7, capture=0.5)
    policy = StrategyPolicy(here, env)
    n_calls = []
    for seed in (3, 4):
        flown(env, policy, seed=seed)
        n_calls.append(len(simulate(search, there, seed).calls))
    assert sum(n_calls) > 0
    for one, other, found in zip(here.shown, there.shown, n_calls, strict=True):
        assert len(one) == 62 + 13 + found
        np.testing.assert_equal(one, other)


class Tired:
    """A policy that draws and remembers; every search has its own."""

    def __init__(self, rng=None):
        self.rng, self.turns = rng, 0

    def begun(self, rng):
        return Tired(rng)

    def __call__(self, observation):
        self.turns += 1
        return self.rng.uniform(-1.0, 1.0, (4, 1, 2)) / self.turns


def test_a_policy_that_draws_begins_anew_with_every_search():
    strategy = PolicyStrategy(Tired())
    one, other, again = (simulate(scene(), strategy, seed) for seed in (1, 2, 1))
    assert_same_flight(one, again)
    assert not np.array_equal(one.places_m, other.places_m)


def test_an_episode_that_a_policy_flew_can_be_kept(tmp_path):
    """Without the policy, which no file of ours holds."""
    episode = simulate(scene(), PolicyStrategy(wandering()), 1)
    save_episode(episode, tmp_path / "episode.npz")
    again = load_episode(tmp_path / "episode.npz")
    assert again.strategy is None
    assert_same_flight(episode, again)


def test_a_policy_that_can_be_sent_is_sent_with_its_strategy():
    strategy = pickle.loads(pickle.dumps(PolicyStrategy(Tired(), capture=0.3)))
    assert strategy.capture == 0.3
    assert_same_flight(simulate(scene(), strategy, 1), simulate(scene(), PolicyStrategy(Tired(), 0.3), 1))


@pytest.mark.parametrize("answer", [np.zeros((4, 2)), np.zeros((4, 0, 2)), np.full((4, 1, 2), 3.0), "north", None])
def test_an_answer_that_is_no_action_is_refused(answer):
    with pytest.raises(InvalidProblemError, match=r"an action .* came"):
        simulate(scene(), PolicyStrategy(lambda _: answer), 1)
