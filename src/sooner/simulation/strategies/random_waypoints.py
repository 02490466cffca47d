"""The random strategy: every agent flies to a place drawn anywhere, and then to another   [Wolek2020, section IV]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.simulation.agents import Agent
from sooner.simulation.ground import area
from sooner.simulation.strategies.strategy import Routes, Situation

__all__ = ["RandomWaypoints"]


@dataclass(frozen=True)
class RandomWaypoints:
    """One waypoint for each agent, uniform over the area; a new one at the replan that finds it within its radius.

    The paper says no more than "random"; when waypoints are drawn anew is ours.

    >>> RandomWaypoints().capture
    0.0
    """

    capture: float = 0.0

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """On the perimeter, as drawn."""
        return drawn

    def session(self, situation: Situation, rng: Generator) -> RandomSession:
        """Begin a search."""
        return RandomSession(rng)


@dataclass(frozen=True, eq=False)
class RandomSession:
    """Draws waypoints as they are wanted."""

    rng: Generator

    def routes(self, situation: Situation) -> Routes:
        """The waypoint that each agent flies to."""
        low, high = area(situation.grid)
        routes = []
        for agent, (searcher, route) in enumerate(zip(situation.agents, situation.routes, strict=True)):
            if len(route) == 0 or _within(route[-1], situation.places_m[agent], searcher.radius_m):
                route = (low + self.rng.random(2) * (high - low)).reshape(1, 2)
            routes.append(route)
        return tuple(routes)


def _within(waypoint: NDArray[np.float64], place: NDArray[np.float64], radius_m: float) -> bool:
    return bool(np.hypot(waypoint[0] - place[0], waypoint[1] - place[1]) <= radius_m)
