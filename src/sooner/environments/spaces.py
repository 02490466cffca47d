"""The spaces of observations and actions, in Gymnasium's words."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import Space, spaces

from sooner.environments.observation import FARTHEST, MAPS, Observation
from sooner.simulation import Scene

__all__ = ["observations", "waypoints"]


def observations(scene: Scene) -> Space[Observation]:
    """The space of what `observed` returns."""
    bound = np.tile(np.repeat([FARTHEST, 1.0, FARTHEST], 2).astype(np.float32), (len(scene.agents), 1))
    space: Space[Any] = spaces.Dict(
        {
            "maps": spaces.Box(0.0, 1.0, (len(MAPS), *scene.grid.shape), np.float32),
            "agents": spaces.Box(-bound, bound, dtype=np.float32),
            "time_left": spaces.Box(0.0, 1.0, (1,), np.float32),
            "detected": spaces.Box(0.0, 1.0, (1,), np.float32),
        }
    )
    return space


def waypoints(*numbers: int) -> spaces.Box:
    """(..., 2) shares of the ground from -1 to 1: numbers are of waypoints, or of agents and then of waypoints."""
    return spaces.Box(-1.0, 1.0, (*numbers, 2), np.float32)
