"""A search as an environment of Gymnasium: one policy leads the whole team."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.environments.observation import FARTHEST, MAPS, Observation, observed
from sooner.environments.scenes import generated_scenes
from sooner.environments.turns import CAPTURE, Turns
from sooner.environments.waypoints import routes_of
from sooner.errors import InvalidProblemError, UnsupportedProblemError
from sooner.simulation import Episode, Scene

try:
    import gymnasium
    from gymnasium import spaces
except ImportError:
    raise UnsupportedProblemError("SearchEnv needs Gymnasium: pip install 'sooner[environments]'") from None

__all__ = ["SearchEnv", "action_space_of", "observation_space_of"]

MOST_WAYPOINTS = 100
SEEDS = 2**31  # seeds drawn by the environment itself are not below this, so that they are none of those you report


class SearchEnv(gymnasium.Env[Observation, ArrayLike]):
    """Lead a team of drones that maps streets nobody knows and hunts whoever walks on them   [Wolek2020].

    Action        (A, K, 2) from -1 to 1: the next K waypoints of each agent, east and north, as shares of the ground
                  from edge to edge. They are flown for the scene's `replan_s`; at the last an agent hovers.
    Observation   dict of float32: `maps` (4, H, W), `agents` (A, 6), `time_left` (1,), `detected` (1,), all that the
                  team believes and nothing else; see `observed`.
    Reward        by how much E grew, [Wolek2020, eq. (20)]: the return is the `Episode`'s E. What is in view at the
                  start is in the first reward. Where no target is, E is its half that nodes make.
    End           `terminated` when the mission's time is up, `truncated` never.
    Info          `scene`, `seed`, `second`; what the detector holds against its threshold (`sum`); and what the team
                  does not know and no policy may use: `calls` and `false_calls` so far, shares of `nodes` and of
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
    InvalidProblemError                  scenes that differ in shape; actions and options that are none of these
    UnsupportedProblemError              if Gymnasium is not installed

    Examples
    --------
    >>> env = SearchEnv(generated_scenes([0, 1], seconds=60))
    >>> observation, info = env.reset(seed=3)
    >>> observation["maps"].shape, info["seed"]
    ((4, 40, 40), 3)
    >>> total, over = 0.0, False
    >>> while not over:
    ...     observation, reward, over, _, info = env.step(env.action_space.sample())
    ...     total += reward
    >>> round(total - env.episode.e, 12), info["second"]
    (0.0, 60)
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 4}  # noqa: RUF012  (Gymnasium's own convention)

    def __init__(
        self,
        scenes: Scene | Sequence[Scene] | None = None,
        *,
        waypoints: int = 1,
        capture: float = CAPTURE,
        render_mode: str | None = None,
    ) -> None:
        if not 1 <= waypoints <= MOST_WAYPOINTS:
            raise InvalidProblemError(f"{waypoints} waypoints an action came; expected 1 to {MOST_WAYPOINTS}")
        if not (np.isfinite(capture) and capture >= 0.0):
            raise InvalidProblemError(f"capture = {capture} came; expected a number of at least 0")
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise InvalidProblemError(f"render_mode {render_mode!r} came; expected 'rgb_array' or None")
        self.scenes = _alike(generated_scenes() if scenes is None else scenes)
        self.waypoints = waypoints
        self.capture = capture
        self.render_mode = render_mode
        self.observation_space = observation_space_of(self.scenes[0])
        self.action_space = action_space_of(len(self.scenes[0].agents), waypoints)
        self._turns: Turns | None = None
        self._scene = 0
        self._e = 0.0

    @property
    def turns(self) -> Turns:
        """The search that is flown now."""
        if self._turns is None:
            raise InvalidProblemError("an environment that was never reset came; expected reset() first")
        return self._turns

    @property
    def episode(self) -> Episode:
        """The record of the search, as far as it has come; reading it is no part of playing by the rules."""
        return self.turns.episode()

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin a search; all agents have looked once."""
        super().reset(seed=seed)
        drawn = int(self.np_random.integers(len(self.scenes)))
        self._scene = _asked_for(options, drawn, len(self.scenes))
        search_seed = SEEDS + int(self.np_random.integers(SEEDS)) if seed is None else seed
        self._turns = Turns(self.scenes[self._scene], search_seed, self.capture)
        episode, self._e = self.episode, 0.0
        return observed(self._turns.situation), self._info(episode)

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Fly these waypoints until the next replan, or the end."""
        turns = self.turns
        if turns.over:
            raise InvalidProblemError("a step came after the end of the mission; expected reset() first")
        routes = routes_of(action, turns.scene.grid, len(turns.scene.agents))
        if len(routes[0]) != self.waypoints:
            raise InvalidProblemError(f"an action of {len(routes[0])} waypoints came; expected {self.waypoints}")
        turns.fly(routes)
        episode = self.episode
        before, self._e = self._e, _score(episode)
        return observed(turns.situation), self._e - before, turns.over, False, self._info(episode)

    def render(self) -> NDArray[np.uint8] | None:
        """(h, w, 3) uint8 if the mode is "rgb_array": the map as `Episode` animations draw it, now."""
        if self.render_mode is None:
            return None
        from PIL import Image

        from sooner.simulation.picture import frame_of

        drawn = frame_of(self.episode, self.turns.flight.second)
        return np.array(Image.open(io.BytesIO(drawn)).convert("RGB"))

    def _info(self, episode: Episode) -> dict[str, Any]:
        """Numbers only, of this moment."""
        second = self.turns.flight.second
        return {
            "scene": self._scene,
            "seed": episode.seed,
            "second": second,
            "sum": float(episode.sums[-1]),
            "calls": len(episode.calls),
            "false_calls": episode.false_calls,
            "nodes": float(episode.nodes_curve[-1]),
            "targets": float(episode.targets_curve[-1]),
            "e": self._e,
        }


def observation_space_of(scene: Scene) -> gymnasium.Space[Observation]:
    """The space of what `observed` returns."""
    bound = np.tile(np.repeat([FARTHEST, 1.0, FARTHEST], 2).astype(np.float32), (len(scene.agents), 1))
    space: gymnasium.Space[Any] = spaces.Dict(
        {
            "maps": spaces.Box(0.0, 1.0, (len(MAPS), *scene.grid.shape), np.float32),
            "agents": spaces.Box(-bound, bound, dtype=np.float32),
            "time_left": spaces.Box(0.0, 1.0, (1,), np.float32),
            "detected": spaces.Box(0.0, 1.0, (1,), np.float32),
        }
    )
    return space


def action_space_of(n_agents: int, waypoints: int) -> spaces.Box:
    """The space of actions: (A, K, 2) from -1 to 1."""
    return spaces.Box(-1.0, 1.0, (n_agents, waypoints, 2), np.float32)


def _score(episode: Episode) -> float:
    """E; its half that nodes make, where there are no targets."""
    return episode.e if episode.n_targets else episode.e_nodes


def _alike(scenes: Scene | Sequence[Scene]) -> tuple[Scene, ...]:
    several = (scenes,) if isinstance(scenes, Scene) else tuple(scenes)
    if not several:
        raise InvalidProblemError("no scenes came; expected at least one")
    different = {(scene.grid.shape, len(scene.agents)) for scene in several}
    if len(different) > 1:
        told = ", ".join(f"{rows} x {cols} cells and {agents} agents" for (rows, cols), agents in sorted(different))
        raise InvalidProblemError(f"scenes of {told} came; expected one shape and one number of agents")
    return several


def _asked_for(options: Mapping[str, Any] | None, drawn: int, n_scenes: int) -> int:
    """The scene that options ask for, or else the one drawn; other options are others' (wrappers have their own)."""
    scene = (options or {}).get("scene", drawn)
    if not isinstance(scene, int | np.integer) or isinstance(scene, bool) or not 0 <= scene < n_scenes:
        raise InvalidProblemError(f"scene {scene!r} came in options; expected a whole number from 0 to {n_scenes - 1}")
    return int(scene)
