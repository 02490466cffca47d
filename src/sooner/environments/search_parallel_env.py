"""A search as an environment of PettingZoo: every agent is led by a policy of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.environments.observation import Observation, observed, seen_by
from sooner.environments.searches import RENDER_MODES, Searches
from sooner.environments.turns import CAPTURE, Turns
from sooner.environments.waypoints import numbers_of
from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.simulation import Episode, Scene

try:
    from gymnasium import Space
    from gymnasium.spaces import Box, Tuple, flatten, flatten_space
    from gymnasium.utils.seeding import np_random
    from pettingzoo import ParallelEnv

    from sooner.environments import spaces
except ImportError:
    told = "SearchParallelEnv needs Gymnasium and PettingZoo: pip install 'sooner[environments]'"
    raise UnsupportedProblemError(told) from None

__all__ = ["SearchParallelEnv"]


class SearchParallelEnv(ParallelEnv[str, Observation, ArrayLike]):  # type: ignore[misc]  # PettingZoo tells no types
    """The search of `SearchEnv`, each agent led by a policy of its own: the same actions, the same flight.

    Agents        "agent_0", "agent_1", ...: all of them from the start to the end
    Action        (K, 2) from -1 to 1: the agent's next K waypoints
    Observation   as in `SearchEnv`: the team has one belief, which all agents share. Where the scene has links, each
                  agent is shown what it believes itself of what it has seen and heard, and where it thinks that the
                  others are. Its own row of `agents` comes first and the others follow in their order round, so that
                  one network may serve all.
    Reward        the team's, the same for each agent: by how much E grew. It is not shared out among them.
    End           all are `terminated` together when the mission's time is up; none is ever `truncated`.
    Info          as in `SearchEnv`, the same for each.

    `state()` is the common observation as one flat array, for critics that see everything; with links, that of each
    agent, one after the other.

    Parameters
    ----------
    scenes, waypoints, capture, render_mode      as in `SearchEnv`

    Raises
    ------
    InvalidProblemError          actions of other agents than these, and all that `SearchEnv` refuses
    UnsupportedProblemError      if Gymnasium or PettingZoo is not installed

    Examples
    --------
    >>> from sooner.environments import generated_scenes
    >>> env = SearchParallelEnv(generated_scenes([0], seconds=60))
    >>> observations, infos = env.reset(seed=3)
    >>> while env.agents:
    ...     actions = {agent: env.action_space(agent).sample() for agent in env.agents}
    ...     observations, rewards, terminations, truncations, infos = env.step(actions)
    >>> infos["agent_0"]["second"], len(set(rewards.values()))
    (60, 1)
    """

    metadata = {  # noqa: RUF012  (PettingZoo's own convention)
        "name": "unknown_city_v0",
        "render_modes": RENDER_MODES,
        "render_fps": 4,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        scenes: Scene | Sequence[Scene] | None = None,
        *,
        waypoints: int = 1,
        capture: float = CAPTURE,
        render_mode: str | None = None,
    ) -> None:
        self._searches = Searches(scenes, waypoints, capture, render_mode)
        self.render_mode = render_mode
        scene = self._searches.scenes[0]
        self.possible_agents = [f"agent_{agent}" for agent in range(len(scene.agents))]
        self.agents: list[str] = []
        self.observation_spaces = {agent: spaces.observations(scene) for agent in self.possible_agents}
        self.action_spaces = {agent: spaces.waypoints(waypoints) for agent in self.possible_agents}
        n_beliefs = 1 if scene.links is None else len(scene.agents)
        self._known_space = Tuple([spaces.observations(scene)] * n_beliefs)
        self.state_space = flatten_space(self._known_space)
        self._rng = np_random()[0]

    @property
    def turns(self) -> Turns:
        """The search that is flown now."""
        return self._searches.turns

    @property
    def waypoints(self) -> int:
        """How many an action has."""
        return self._searches.waypoints

    @property
    def episode(self) -> Episode:
        """The record of the search, as far as it has come; reading it is no part of playing by the rules."""
        return self._searches.episode

    def observation_space(self, agent: str) -> Space[Observation]:
        """Of one agent; all have the like."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Box:
        """Of one agent; all have the like."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin a search; all agents have looked once."""
        if seed is not None:
            self._rng = np_random(seed)[0]
        self._searches.begin(self._rng, seed, options)
        self.agents = list(self.possible_agents)
        return self._observations(), self._infos()

    def step(
        self, actions: Mapping[str, ArrayLike]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Fly these waypoints until the next replan, or the end."""
        reward = self._searches.fly(self._joined(actions))
        flown, over = self.possible_agents, self.turns.over
        self.agents = [] if over else list(flown)
        rewards, overs, cut = dict.fromkeys(flown, reward), dict.fromkeys(flown, over), dict.fromkeys(flown, False)
        return self._observations(), rewards, overs, cut, self._infos()

    def render(self) -> NDArray[np.uint8] | None:
        """(h, w, 3) uint8 if the mode is "rgb_array"; nothing without a mode."""
        return None if self.render_mode is None else self._searches.picture()

    def state(self) -> NDArray[np.float32]:
        """All that is known, as one flat array."""
        return np.asarray(flatten(self._known_space, tuple(self._known())), np.float32)

    def _known(self) -> list[Observation]:
        """The common observation, or each agent's."""
        return [observed(situation) for situation in self.turns.situations]

    def _observations(self) -> dict[str, Observation]:
        known = self._known()
        return {name: seen_by(agent, known[agent % len(known)]) for agent, name in enumerate(self.possible_agents)}

    def _infos(self) -> dict[str, dict[str, Any]]:
        info = self._searches.info()
        return {agent: dict(info) for agent in self.possible_agents}

    def _joined(self, actions: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
        """(A, K, 2), the team's action."""
        if set(actions) != set(self.possible_agents):
            raise InvalidProblemError(
                f"actions of {', '.join(sorted(map(str, actions))) or 'nobody'} came; expected one of each of "
                f"{', '.join(self.possible_agents)}"
            )
        own = [numbers_of(actions[agent]) for agent in self.possible_agents]
        for agent, action in zip(self.possible_agents, own, strict=True):
            if action.shape != (self.waypoints, 2):
                raise InvalidProblemError(
                    f"an action of shape {action.shape} came from {agent}; expected {(self.waypoints, 2)}"
                )
        return np.stack(own)
