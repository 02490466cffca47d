"""Waypoints as a policy gives them: shares of the ground, from -1 at its west and south edges to 1 at the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation.ground import area
from sooner.simulation.strategies import Routes, Situation

__all__ = ["action_of", "metres_of", "numbers_of", "routes_of", "shares_of"]

BEYOND = 1e-6  # of a share: so far over the edge rounding may carry a waypoint


def shares_of(grid: Grid, places_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Places in metres, (..., 2), as shares of the ground.

    >>> shares_of(Grid((20, 20), "square8", 5.0), np.array([[47.5, 47.5], [-2.5, 97.5]]))
    array([[ 0.,  0.],
           [-1.,  1.]])
    """
    low, high = area(grid)
    shares: NDArray[np.float64] = 2.0 * (places_m - low) / (high - low) - 1.0
    return shares


def metres_of(grid: Grid, shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shares of the ground, (..., 2), as places in metres.

    >>> metres_of(Grid((20, 20), "square8", 5.0), np.array([0.0, 1.0]))
    array([47.5, 97.5])
    """
    low, high = area(grid)
    places_m: NDArray[np.float64] = low + 0.5 * (shares + 1.0) * (high - low)
    return places_m


def routes_of(action: ArrayLike, grid: Grid, n_agents: int) -> Routes:
    """The routes that an action asks for: (A, K, 2) shares, K waypoints for each of A agents.

    Where the last waypoint comes several times over, it counts once.

    Raises
    ------
    InvalidProblemError      another shape, numbers that are none, waypoints off the ground
    """
    shares = numbers_of(action)
    if shares.ndim != 3 or shares.shape[0] != n_agents or shares.shape[1] < 1 or shares.shape[2] != 2:
        raise InvalidProblemError(
            f"an action of shape {shares.shape} came for {n_agents} agents; expected ({n_agents}, waypoints, 2)"
        )
    if not (np.abs(shares) <= 1.0 + BEYOND).all():  # false for what is not a number, too
        raise InvalidProblemError(
            f"an action with {_worst(shares):g} came; expected shares of the ground from -1 to 1 (clip it first)"
        )
    return tuple(_once(route) for route in metres_of(grid, np.clip(shares, -1.0, 1.0)))


def numbers_of(action: ArrayLike) -> NDArray[np.float64]:
    """An action as an array of numbers; lists of different lengths are none."""
    try:
        return np.asarray(action, np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidProblemError(f"an action that is no array came ({error}); expected numbers from -1 to 1") from None


def action_of(routes: Routes, situation: Situation, waypoints: int) -> NDArray[np.float64]:
    """The action, (A, K, 2), that asks for the first K waypoints of each route, or as near to them as the ground goes.

    A shorter route is filled up with its last waypoint, at which an agent hovers; an empty one with the agent's place.
    """
    filled = np.empty((len(routes), waypoints, 2))
    for agent, route in enumerate(routes):
        asked = route[:waypoints] if len(route) else situation.places_m[agent : agent + 1]
        filled[agent, : len(asked)] = asked
        filled[agent, len(asked) :] = asked[-1]
    return np.clip(shares_of(situation.grid, filled), -1.0, 1.0)


def _once(route: NDArray[np.float64]) -> NDArray[np.float64]:
    """A route up to where nothing comes but its last waypoint."""
    others = np.flatnonzero((route != route[-1]).any(axis=1))
    return route[: others[-1] + 2] if len(others) else route[:1]


def _worst(shares: NDArray[np.float64]) -> float:
    flat = shares.ravel()
    return float(flat[np.abs(np.nan_to_num(flat, nan=np.inf)).argmax()])
