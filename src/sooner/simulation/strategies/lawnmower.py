"""The lawnmower: the ground is cut into equal rectangles, and every agent sweeps its own, lane by lane."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt
from typing import Literal, cast

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation.agents import Agent
from sooner.simulation.ground import area
from sooner.simulation.strategies.strategy import Routes, Situation

__all__ = ["TUNED_LAWNMOWER", "Lawnmower", "lanes", "rectangles"]


@dataclass(frozen=True)
class Lawnmower:
    """Lanes as far apart as the radius of view allows; it does not learn   [Wolek2020, section IV].

    The paper says of it only that agents start in the corners so that an efficient path exists. What comes near its
    figures: a quadrant for each of four agents, lanes for a radius of 0.95 rho and so 5 of 20 m, flown from the centres
    of its first cells to those of its last, 2.5 m from the edge, waypoints taken for reached at rho / 10.

    Parameters
    ----------
    reach : float                  half the widest lane, in radii of view; 1 for lanes that just touch
    capture : float                share of the radius within which a waypoint is reached
    inset : float                  how far before the rectangle's edge a lane ends, in lane widths
    afterwards : str               "hover" at the end of the last lane, or "back" the way it came, to and fro

    Raises
    ------
    InvalidProblemError            if reach or capture are not positive, inset is not in [0, 0.5], or it does something
                                   else afterwards
    """

    reach: float = 0.95
    capture: float = 0.1
    inset: float = 0.125
    afterwards: Literal["hover", "back"] = "hover"

    def __post_init__(self) -> None:
        for name in ("reach", "capture"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise InvalidProblemError(
                    f"a lawnmower with {name} = {getattr(self, name)} came; expected a positive number"
                )
        if self.afterwards not in ("hover", "back"):
            raise InvalidProblemError(f"a lawnmower that does {self.afterwards!r} came; expected 'hover' or 'back'")
        if not 0.0 <= self.inset <= 0.5:
            raise InvalidProblemError(f"a lawnmower with inset = {self.inset} came; expected 0 to 0.5 lane widths")

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """(A, 2) float: the corner of each agent's rectangle that is nearest to a corner of the ground."""
        return np.array([_entry(grid, low, high) for low, high in rectangles(grid, len(agents))])

    def session(self, situation: Situation, rng: Generator) -> LawnmowerSession:
        """Begin a search."""
        routes = []
        for agent, (low, high) in zip(situation.agents, rectangles(situation.grid, len(situation.agents)), strict=True):
            entry = _entry(situation.grid, low, high)
            route = lanes(low, high, entry, 2.0 * self.reach * agent.radius_m, self.inset)
            if self.afterwards == "back":
                seconds = situation.end_s - situation.now_s
                route = _to_and_fro(route, agent.v_max * seconds)
            routes.append(route)
        return LawnmowerSession(tuple(routes))


TUNED_LAWNMOWER = Lawnmower(reach=1.0, capture=0.5, inset=0.5)
"""Lanes of the whole field of view, 4 of 25 m with the paper's agents, and corners cut at half the radius."""


@dataclass(frozen=True, eq=False)
class LawnmowerSession:
    """Gives its lanes once and goes on."""

    lanes: Routes

    def routes(self, situation: Situation) -> Routes:
        """The lanes at the start; what is left of them from then on."""
        return situation.routes if any(len(route) for route in situation.routes) else self.lanes


def rectangles(grid: Grid, n_agents: int) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Equal rectangles of the ground, one for each agent, as near to its own proportions as their number allows.

    >>> [(low.tolist(), high.tolist()) for low, high in rectangles(Grid((4, 4), "square8", 5.0), 2)]
    [([-2.5, -2.5], [7.5, 17.5]), ([7.5, -2.5], [17.5, 17.5])]
    """
    low, high = area(grid)
    across = next(n for n in range(ceil(sqrt(n_agents)), n_agents + 1) if n_agents % n == 0)
    up = n_agents // across
    size = (high - low) / (across, up)
    corners = [low + size * (east, north) for north in range(up) for east in range(across)]
    return [(corner, corner + size) for corner in corners]


def lanes(
    low: NDArray[np.float64], high: NDArray[np.float64], entry: NDArray[np.float64], widest_m: float, inset: float
) -> NDArray[np.float64]:
    """(2 n, 2) float: ends of north-south lanes over a rectangle, in the order of flight from the corner `entry`.

    Parameters
    ----------
    low, high : (2,) float      corners of the rectangle
    widest_m : float            no lane is wider
    inset : float               how far before the edge a lane ends, in lane widths

    >>> lanes(np.zeros(2), np.array([50.0, 100.0]), np.zeros(2), 25.0, 0.5).tolist()
    [[12.5, 12.5], [12.5, 87.5], [37.5, 87.5], [37.5, 12.5]]
    """
    n_lanes = max(ceil((high[0] - low[0]) / widest_m - 1e-9), 1)
    width = (high[0] - low[0]) / n_lanes
    easts = low[0] + width * (np.arange(n_lanes) + 0.5)
    short = min(inset * width, 0.5 * (high[1] - low[1]))
    ends = np.array([low[1] + short, high[1] - short])
    if entry[0] > low[0]:
        easts = easts[::-1]
    if entry[1] > low[1]:
        ends = ends[::-1]
    route = [(east, north) for n, east in enumerate(easts) for north in (ends if n % 2 == 0 else ends[::-1])]
    return np.array(route, float)


def _entry(grid: Grid, low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """The corner of a rectangle that is nearest to one of the ground's; the south-western of equals."""
    ground_low, ground_high = area(grid)
    west = low - ground_low <= ground_high - high + 1e-9
    return cast("NDArray[np.float64]", np.where(west, low, high))


def _to_and_fro(route: NDArray[np.float64], most_m: float) -> NDArray[np.float64]:
    """The route, back, and again, until it is longer than can be flown."""
    length = float(np.linalg.norm(np.diff(route, axis=0), axis=1).sum())
    legs, way = [route], route
    for _ in range(ceil(most_m / max(length, 1.0))):
        way = way[::-1]
        legs.append(way[1:])
    return np.concatenate(legs)
