"""Searches one after another, as both faces show them: what a seed and options ask for, rewards, and what is told."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from sooner.environments.scenes import generated_scenes
from sooner.environments.turns import CAPTURE, Turns
from sooner.environments.waypoints import numbers_of, routes_of
from sooner.errors import InvalidProblemError
from sooner.simulation import Episode, Scene

__all__ = ["RENDER_MODES", "Searches"]

RENDER_MODES = ["rgb_array"]
MOST_WAYPOINTS = 100
SEEDS = 2**31  # seeds drawn by an environment itself are not below this, so that they are none of those you report


class Searches:
    """The searches of an environment, of which one is flown at a time.

    Parameters
    ----------
    scenes : Scene, several, or None     of one shape and with equally many agents; twelve generated ones if none come
    waypoints : int                      K, of each agent in an action
    capture : float                      share of its radius of view within which an agent takes a waypoint for reached
    render_mode : str or None            checked here, for both faces

    Raises
    ------
    InvalidProblemError                  if there is no such environment

    Examples
    --------
    >>> searches = Searches(generated_scenes([0], seconds=60))
    >>> searches.begin(np.random.default_rng(0), seed=3)
    >>> total = 0.0
    >>> while not searches.turns.over:
    ...     total += searches.fly(np.zeros((4, 1, 2)))
    >>> round(total - searches.episode.e, 12)
    0.0
    """

    def __init__(
        self,
        scenes: Scene | Sequence[Scene] | None = None,
        waypoints: int = 1,
        capture: float = CAPTURE,
        render_mode: str | None = None,
    ) -> None:
        if not _is_whole(waypoints) or not 1 <= waypoints <= MOST_WAYPOINTS:
            expected = f"expected a whole number from 1 to {MOST_WAYPOINTS}"
            raise InvalidProblemError(f"{waypoints!r} waypoints an action came; {expected}")
        if not (np.isfinite(capture) and capture >= 0.0):
            raise InvalidProblemError(f"capture = {capture} came; expected a number of at least 0")
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise InvalidProblemError(f"render_mode {render_mode!r} came; expected 'rgb_array' or None")
        self.scenes = _alike(generated_scenes() if scenes is None else scenes)
        self.waypoints = waypoints
        self.capture = capture
        self._turns: Turns | None = None
        self._scene = 0
        self._e = 0.0

    @property
    def n_agents(self) -> int:
        """A, in every scene."""
        return len(self.scenes[0].agents)

    @property
    def turns(self) -> Turns:
        """The search that is flown now."""
        if self._turns is None:
            raise InvalidProblemError("an environment that was never reset came; expected reset() first")
        return self._turns

    @property
    def episode(self) -> Episode:
        """Its record, as far as it has come."""
        return self.turns.episode()

    def begin(self, rng: Generator, seed: int | None = None, options: Mapping[str, Any] | None = None) -> None:
        """Begin the search of that seed, or else one that is drawn; the scene is drawn if options ask for none."""
        drawn = int(rng.integers(len(self.scenes)))
        self._scene = _asked_for(options, drawn, len(self.scenes))
        search_seed = SEEDS + int(rng.integers(SEEDS)) if seed is None else seed
        self._turns = Turns(self.scenes[self._scene], search_seed, self.capture)
        self._e = 0.0

    def fly(self, action: ArrayLike) -> float:
        """Fly an action, (A, K, 2), until the next replan or the end; by how much E grew."""
        turns = self.turns
        if turns.over:
            raise InvalidProblemError("a step came after the end of the mission; expected reset() first")
        shares = numbers_of(action)
        if shares.shape != (self.n_agents, self.waypoints, 2):
            expected = (self.n_agents, self.waypoints, 2)
            raise InvalidProblemError(f"an action of shape {shares.shape} came; expected {expected}")
        turns.fly(routes_of(shares, turns.scene.grid, self.n_agents))
        before, self._e = self._e, _score(self.episode)
        return self._e - before

    def info(self) -> dict[str, Any]:
        """Numbers only, of this moment."""
        episode = self.episode
        return {
            "scene": self._scene,
            "seed": episode.seed,
            "second": self.turns.flight.second,
            "sum": float(episode.sums[-1]),
            "calls": len(episode.calls),
            "false_calls": episode.false_calls,
            "nodes": float(episode.nodes_curve[-1]),
            "targets": float(episode.targets_curve[-1]),
            "e": self._e,
        }

    def picture(self) -> NDArray[np.uint8]:
        """(h, w, 3) uint8: the map as animations of an `Episode` draw it, now."""
        from PIL import Image

        from sooner.simulation.picture import frame_of

        drawn = frame_of(self.episode, self.turns.flight.second)
        return np.array(Image.open(io.BytesIO(drawn)).convert("RGB"))


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _score(episode: Episode) -> float:
    """E; its half that nodes make, where there are no targets."""
    return episode.e if episode.n_targets else episode.e_nodes


def _alike(scenes: Scene | Sequence[Scene]) -> tuple[Scene, ...]:
    several = (scenes,) if isinstance(scenes, Scene) else tuple(scenes) if isinstance(scenes, Iterable) else (scenes,)
    for scene in several:
        if not isinstance(scene, Scene):
            raise InvalidProblemError(f"{scene!r} came among scenes; expected a Scene, or several")
    if not several:
        raise InvalidProblemError("no scenes came; expected at least one")
    if len({scene.links is None for scene in several}) > 1:
        raise InvalidProblemError("scenes with links and without came; expected all alike")
    different = {(scene.grid.shape, len(scene.agents)) for scene in several}
    if len(different) > 1:
        told = ", ".join(f"{rows} x {cols} cells and {agents} agents" for (rows, cols), agents in sorted(different))
        raise InvalidProblemError(f"scenes of {told} came; expected one shape and one number of agents")
    return several


def _asked_for(options: Mapping[str, Any] | None, drawn: int, n_scenes: int) -> int:
    """The scene that options ask for, or else the one drawn; other options are others' (wrappers have their own)."""
    if options is not None and not isinstance(options, Mapping):
        raise InvalidProblemError(f'options = {options!r} came; expected a mapping such as {{"scene": 0}}, or None')
    scene = (options or {}).get("scene", drawn)
    if not _is_whole(scene) or not 0 <= scene < n_scenes:
        raise InvalidProblemError(f"scene {scene!r} came in options; expected a whole number from 0 to {n_scenes - 1}")
    return int(scene)
