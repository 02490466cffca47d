"""A search as an environment of Gymnasium: one policy leads the whole team."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.environments.observation import Observation, observed
from sooner.environments.searches import RENDER_MODES, Searches
from sooner.environments.turns import CAPTURE, Turns
from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.simulation import Episode, Scene

try:
    import gymnasium

    from sooner.environments import spaces
except ImportError:
    raise UnsupportedProblemError("SearchEnv needs Gymnasium: pip install 'sooner[environments]'") from None

__all__ = ["SearchEnv"]


class SearchEnv(gymnasium.Env[Observation, ArrayLike]):
    """Lead a team of drones that maps streets nobody knows and hunts whoever walks on them   [Wolek2020].

    Action        (A, K, 2) from -1 to 1: the next K waypoints of each agent, east and north, as shares of the ground
                  from edge to edge. They are flown for the scene's `replan_s`; at the last an agent hovers.
    Observation   dict of float32: `maps` (5, H, W), `agents` (A, 6), `time_left` (1,), `detected` (1,), all that the
                  team believes and nothing else; see `observed`.
    Reward        by how much E grew, [Wolek2020, eq. (20)]: the return is the `Episode`'s E. What is in view at the
                  start is in the first reward. Where no target is, E is its half that nodes make.
    End           `terminated` when the mission's time is up, `truncated` never.
    Info          `scene`, `seed`, `second`; what the detector holds against its threshold (`sum`), `calls` so far; and
                  what the team does not know and no policy may use: `false_calls` so far, shares of `nodes` and of
                  `targets` detected, `e` so far.

    `reset(seed=n)` settles everything: it flies the search that `simulate(scene, strategy, n)` flies. Without a seed
    the next is drawn, as is the scene among several; `options={"scene": k}` asks for one.

    Parameters
    ----------
    scenes : Scene, several, or None     of one shape and with equally many agents; twelve generated ones if none come
    waypoints : int                      K
    capture : float                      share of its radius of view within which an agent takes a waypoint for reached
                                         and turns to its next
    render_mode : str or None            "rgb_array": the map as it was detected, and where the target really is

    Raises
    ------
    InvalidProblemError                  scenes that differ in shape, or with links; actions and options that are none
    UnsupportedProblemError              if Gymnasium is not installed

    Examples
    --------
    >>> from sooner.environments import generated_scenes
    >>> env = SearchEnv(generated_scenes([0, 1], seconds=60))
    >>> observation, info = env.reset(seed=3)
    >>> observation["maps"].shape, info["seed"]
    ((5, 40, 40), 3)
    >>> total, over = 0.0, False
    >>> while not over:
    ...     observation, reward, over, _, info = env.step(env.action_space.sample())
    ...     total += reward
    >>> round(total - env.episode.e, 12), info["second"]
    (0.0, 60)
    """

    metadata = {"render_modes": RENDER_MODES, "render_fps": 4}  # noqa: RUF012  (Gymnasium's own convention)

    def __init__(
        self,
        scenes: Scene | Sequence[Scene] | None = None,
        *,
        waypoints: int = 1,
        capture: float = CAPTURE,
        render_mode: str | None = None,
    ) -> None:
        self._searches = Searches(scenes, waypoints, capture, render_mode)
        if self.scenes[0].links is not None:
            raise InvalidProblemError(
                "scenes with links came; expected none: one policy leads a team that has one belief "
                "(SearchParallelEnv leads agents that believe each for itself)"
            )
        self.render_mode = render_mode
        self.observation_space = spaces.observations(self.scenes[0])
        self.action_space = spaces.waypoints(self._searches.n_agents, waypoints)

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """What is searched, by number."""
        return self._searches.scenes

    @property
    def waypoints(self) -> int:
        """K."""
        return self._searches.waypoints

    @property
    def turns(self) -> Turns:
        """The search that is flown now."""
        return self._searches.turns

    @property
    def episode(self) -> Episode:
        """The record of the search, as far as it has come; reading it is no part of playing by the rules."""
        return self._searches.episode

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin a search; all agents have looked once."""
        super().reset(seed=seed)
        self._searches.begin(self.np_random, seed, options)
        return observed(self.turns.situation), self._searches.info()

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Fly these waypoints until the next replan, or the end."""
        reward = self._searches.fly(action)
        return observed(self.turns.situation), reward, self.turns.over, False, self._searches.info()

    def render(self) -> NDArray[np.uint8] | None:
        """(h, w, 3) uint8 if the mode is "rgb_array"; nothing without a mode."""
        return None if self.render_mode is None else self._searches.picture()
