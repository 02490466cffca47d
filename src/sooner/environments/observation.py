"""What a policy is shown: the situation of a strategy, as arrays of one shape and about one size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.environments.waypoints import shares_of
from sooner.simulation.agents import Team
from sooner.simulation.strategies import Situation

__all__ = ["FARTHEST", "MAPS", "Observation", "observed", "seen_by"]

Observation = dict[str, NDArray[np.float32]]
"""maps (5, H, W), agents (A, 6), time_left (1,), detected (1,): see `observed`."""

MAPS = ("void", "occupied", "explored", "nodes", "glimpse")
FARTHEST = 2.0  # shares of the ground; agents that overshoot its edge by more are shown there


def observed(situation: Situation) -> Observation:
    """What is known, for a policy.

    Parameters
    ----------
    situation : Situation      what a strategy is told

    Returns
    -------
    dict of float32 arrays
        maps : (5, H, W)       P(void), P(occupied), explored (0 or 1), node detected (0 or 1), P(a look sees the cell);
                               row 0 is north
        agents : (A, 6)        place east and north, and the next waypoint's, as shares of the ground, -1 to 1 from edge
                               to edge; between them velocity east and north over the agent's greatest speed
        time_left : (1,)       share of the mission
        detected : (1,)        1 if the detector has called, 0 before
    """
    states, (height, width) = situation.states, situation.grid.shape
    glimpse = np.ones(len(states.void)) if situation.glimpse is None else situation.glimpse
    maps = np.stack([states.void, states.occupied, states.explored, states.nodes, glimpse]).astype(np.float32)
    return {
        "maps": maps.reshape(len(MAPS), height, width),
        "agents": _agents(situation).astype(np.float32),
        "time_left": np.array([1.0 - situation.now_s / situation.end_s], np.float32),
        "detected": np.array([situation.found], np.float32),
    }


def seen_by(agent: int, observation: Observation) -> Observation:
    """The same as one agent sees it: its own row of `agents` comes first, the others after it in their order round."""
    own = {name: array.copy() for name, array in observation.items()}
    own["agents"] = np.roll(own["agents"], -agent, axis=0)
    return own


def _agents(situation: Situation) -> NDArray[np.float64]:
    """(A, 6): place, velocity, next waypoint; an agent without a route has its place for one."""
    places = situation.places_m
    aims = [route[0] if len(route) else place for route, place in zip(situation.routes, places, strict=True)]
    speeds = situation.velocities_mps / Team(situation.agents).v_max[:, None]
    grid = situation.grid
    rows = np.concatenate([shares_of(grid, places), speeds, shares_of(grid, np.array(aims))], axis=1)
    bound = np.repeat([FARTHEST, 1.0, FARTHEST], 2)
    return np.asarray(np.clip(rows, -bound, bound))
