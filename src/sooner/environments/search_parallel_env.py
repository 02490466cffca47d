"""A search as an environment of PettingZoo: every agent is led by a policy of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.environments.observation import Observation, seen_by
from sooner.environments.search_env import SearchEnv, observation_space_of
from sooner.environments.turns import CAPTURE, Turns
from sooner.environments.waypoints import numbers_of
from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.simulation import Episode, Scene

try:
    from gymnasium import spaces
    from pettingzoo import ParallelEnv
except ImportError:
    raise UnsupportedProblemError("SearchParallelEnv needs PettingZoo: pip install 'sooner[environments]'") from None

__all__ = ["SearchParallelEnv"]


class SearchParallelEnv(ParallelEnv[str, Observation, ArrayLike]):  # type: ignore[misc]  # PettingZoo tells no types
    """The search of `SearchEnv`, each agent led by a policy of its own: the same actions, the same flight.

    Agents        "agent_0", "agent_1", ...: all of them from the start to the end
    Action        (K, 2) from -1 to 1: the agent's next K waypoints
    Observation   as in `SearchEnv`: the team has one belief, which all agents share. An agent's own row of `agents`
                  comes first and the others follow in their order round, so that one network may serve all.
    Reward        the team's, the same for each agent: by how much E grew. It is not shared out among them.
    End           all are `terminated` together when the mission's time is up; none is ever `truncated`.
    Info          as in `SearchEnv`, the same for each.

    `state()` is the common observation as one flat array, for critics that see everything.

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
        "render_modes": ["rgb_array"],
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
        self._team = SearchEnv(scenes, waypoints=waypoints, capture=capture, render_mode=render_mode)
        self.render_mode = render_mode
        scene = self._team.scenes[0]
        self.possible_agents = [f"agent_{agent}" for agent in range(len(scene.agents))]
        self.agents: list[str] = []
        self.observation_spaces = {agent: observation_space_of(scene) for agent in self.possible_agents}
        self.action_spaces = {agent: _own_action_space(waypoints) for agent in self.possible_agents}
        self.state_space = spaces.flatten_space(self._team.observation_space)
        self._seen: Observation = {}

    @property
    def turns(self) -> Turns:
        """The search that is flown now."""
        return self._team.turns

    @property
    def waypoints(self) -> int:
        """How many an action has."""
        return self._team.waypoints

    @property
    def episode(self) -> Episode:
        """The record of the search, as far as it has come; reading it is no part of playing by the rules."""
        return self._team.episode

    def observation_space(self, agent: str) -> spaces.Space[Observation]:
        """Of one agent; all have the like."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Box:
        """Of one agent; all have the like."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin a search; all agents have looked once."""
        self._seen, info = self._team.reset(seed=seed, options=options)
        self.agents = list(self.possible_agents)
        return self._observations(), {agent: dict(info) for agent in self.agents}

    def step(
        self, actions: Mapping[str, ArrayLike]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Fly these waypoints until the next replan, or the end."""
        self._seen, reward, over, _, info = self._team.step(self._joined(actions))
        flown = self.possible_agents
        self.agents = [] if over else list(flown)
        return (
            self._observations(),
            dict.fromkeys(flown, reward),
            dict.fromkeys(flown, over),
            dict.fromkeys(flown, False),
            {agent: dict(info) for agent in flown},
        )

    def render(self) -> NDArray[np.uint8] | None:
        """(h, w, 3) uint8 if the mode is "rgb_array"."""
        return self._team.render()

    def state(self) -> NDArray[np.float32]:
        """The common observation as one flat array."""
        _ = self.turns
        return np.asarray(spaces.flatten(self._team.observation_space, self._seen), np.float32)

    def _observations(self) -> dict[str, Observation]:
        return {name: seen_by(agent, self._seen) for agent, name in enumerate(self.possible_agents)}

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


def _own_action_space(waypoints: int) -> spaces.Box:
    """The space of one agent's actions: (K, 2) from -1 to 1."""
    return spaces.Box(-1.0, 1.0, (waypoints, 2), np.float32)
