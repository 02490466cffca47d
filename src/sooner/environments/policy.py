"""Policies and strategies, each as the other: a trained policy flies in `simulate`, a strategy flies an environment."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from sooner.environments.observation import Observation, observed
from sooner.environments.turns import CAPTURE, Turns
from sooner.environments.waypoints import action_of, routes_of
from sooner.grid import Grid
from sooner.simulation import Agent
from sooner.simulation.strategies import Routes, Session, Situation, Strategy
from sooner.simulation.world import Purpose, generator

__all__ = ["Policy", "PolicyStrategy", "StrategyPolicy"]


class Policy(Protocol):
    """What is trained: an observation in, an action out, (A, K, 2) shares of the ground.

    One that draws random numbers or remembers may have a method `begun(rng) -> Policy` as well: it is called at the
    start of every search that `PolicyStrategy` flies, and what it returns flies that search alone.
    """

    def __call__(self, observation: Observation) -> ArrayLike:
        """The next K waypoints of each agent."""


class PolicyStrategy:
    """A policy as a strategy, for `simulate` and trials; it flies as it does in `SearchEnv`.

    It is no dataclass: what describes strategies in files would copy the policy with all its weights.

    Parameters
    ----------
    policy : Policy
    capture : float      share of its radius of view within which an agent takes a waypoint for reached, in flight

    Examples
    --------
    >>> from sooner.environments import generated_scenes
    >>> from sooner.simulation import simulate
    >>> def corners(observation):
    ...     return [[[-0.9, -0.9]], [[0.9, -0.9]], [[0.9, 0.9]], [[-0.9, 0.9]]]
    >>> scene = generated_scenes([0], seconds=60)[0]
    >>> flown = simulate(scene, PolicyStrategy(corners), seed=1)
    >>> bool(flown.nodes_curve[-1] > 0)
    True
    """

    def __init__(self, policy: Policy, capture: float = CAPTURE) -> None:
        self.policy = policy
        self.capture = capture

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """On the perimeter, as drawn."""
        return drawn

    def session(self, situation: Situation, rng: Generator) -> _PolicySession:
        """Begin a search."""
        begun = getattr(self.policy, "begun", None)
        return _PolicySession(self.policy if begun is None else begun(rng))


class _PolicySession:
    """A policy at work in one search."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def routes(self, situation: Situation) -> Routes:
        """What the policy answers to what is observed."""
        return routes_of(self._policy(observed(situation)), situation.grid, len(situation.agents))


class Turned(Protocol):
    """An environment whose search stops at every replan."""

    @property
    def turns(self) -> Turns:
        """The search that is flown now."""

    @property
    def waypoints(self) -> int:
        """How many an action has for each agent."""


class StrategyPolicy:
    """A strategy at the controls of an environment: to imitate it, or to compare with it in the same searches.

    It is told the environment's situation instead of the observation, and draws what it draws in `simulate`. With the
    strategy's own `capture`, starts and no fewer `waypoints` than its routes have, the flight is the same; of longer
    routes the first waypoints are flown.

    Parameters
    ----------
    strategy : Strategy
    env : SearchEnv            the bare environment: `env.unwrapped` of one that is wrapped

    Examples
    --------
    >>> from sooner.environments import SearchEnv, generated_scenes
    >>> from sooner.simulation.strategies import RandomWaypoints
    >>> env = SearchEnv(generated_scenes([0], seconds=60))
    >>> fly = StrategyPolicy(RandomWaypoints(), env)
    >>> observation, info = env.reset(seed=1)
    >>> fly(observation).shape
    (4, 1, 2)
    """

    def __init__(self, strategy: Strategy, env: Turned) -> None:
        self._strategy = strategy
        self._env = env
        self._turns: Turns | None = None
        self._session: Session

    def __call__(self, observation: Observation) -> NDArray[np.float64]:
        """The next waypoints of each agent; a new session at the start of a search."""
        turns = self._env.turns
        if turns is not self._turns:
            self._turns = turns
            self._session = self._strategy.session(turns.situation, generator(turns.seed, Purpose.STRATEGY))
            turns.shown_to(self._session)
        return action_of(self._session.routes(turns.situation), turns.situation, self._env.waypoints)
