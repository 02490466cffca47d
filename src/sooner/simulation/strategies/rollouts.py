"""Receding-horizon rollouts: routes of random waypoints are flown in thought, and the best is begun."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation.agents import Agent, Team
from sooner.simulation.ground import area
from sooner.simulation.strategies.joint import bodies, dice, pack
from sooner.simulation.strategies.presence import Presence
from sooner.simulation.strategies.strategy import Routes, Situation

__all__ = ["Rollouts", "RolloutsSession"]


@dataclass(frozen=True)
class Rollouts:
    """At every replan, agent after agent tries random routes beside those of the others, over a horizon.

    The value is that of `Joint`, over the horizon instead of the rest of the mission. What is left of an agent's last
    route is tried first, and kept if nothing is better. One waypoint in five lies anywhere, the others normally about
    the one before, by 25 m each way.

    Parameters
    ----------
    rollouts : int         at a replan, shared out among agents equally
    horizon_s : float
    waypoints : int        of a route
    capture, reach, target     as of `Joint`

    Raises
    ------
    InvalidProblemError    if a number makes no sense

    Examples
    --------
    >>> Rollouts().rollouts
    300
    """

    rollouts: int = 300
    horizon_s: float = 30.0
    waypoints: int = 3
    capture: float = 0.5
    reach: float = 1.0
    target: float = 2.0

    def __post_init__(self) -> None:
        for name in ("horizon_s", "capture", "reach"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InvalidProblemError(f"{name} = {value} came; expected a positive number")
        if not (np.isfinite(self.target) and self.target >= 0.0):
            raise InvalidProblemError(f"target = {self.target} came; expected at least 0")
        if self.rollouts < 0 or self.waypoints < 1:
            raise InvalidProblemError(
                f"{self.rollouts} rollouts of {self.waypoints} waypoints came; expected at least 0 and 1"
            )

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """On the perimeter, as drawn."""
        return drawn

    def session(self, situation: Situation, rng: Generator) -> RolloutsSession:
        """Begin a search."""
        return RolloutsSession(self, situation, rng)


@dataclass(eq=False)
class RolloutsSession:
    """Routes as far as the horizon."""

    strategy: Rollouts
    situation: Situation
    rng: Generator

    def __post_init__(self) -> None:
        grid = self.situation.grid
        self._presence = Presence(grid, self.situation.states)
        self._low, self._high = area(grid)
        self._shape = np.array(grid.shape, np.int64)
        self._bodies = bodies(Team(self.situation.agents), grid, self.strategy.capture, self.strategy.reach)
        self._weights = np.empty(grid.n_cells)
        self._dice = dice(self.rng)

    def watch(self, cells: NDArray[np.int32], target_ratios: NDArray[np.float64]) -> None:
        """Take in one second's looks for a target."""
        self._presence.watch(cells, target_ratios)

    def found(self, cell: int) -> None:
        """A target was found; another is sought."""
        self._presence.found(cell)

    def remembered(self) -> NDArray[np.float64]:
        """What was made of the looks so far."""
        return self._presence.shares.copy()

    def recall(self, kept: NDArray[np.float64]) -> None:
        """Forget all looks since then."""
        self._presence.shares[:] = kept

    def routes(self, situation: Situation) -> Routes:
        """The best routes that were tried."""
        from sooner.simulation.strategies._coverage_kernels import roll_out

        strategy = self.strategy
        self._presence.states = situation.states
        self._presence.weigh(strategy.target if situation.sought else 0.0, self._weights)
        if situation.glimpse is not None:
            self._weights *= situation.glimpse
        seconds = max(int(min(strategy.horizon_s, situation.end_s - situation.now_s)), 1)
        packed, lengths = pack(situation.routes, strategy.waypoints)
        starts = np.hstack([situation.places_m, situation.velocities_mps])
        roll_out(
            starts, self._bodies, packed, lengths, seconds, self._shape, float(situation.grid.cell_m), self._low,
            self._high, self._weights, strategy.rollouts, strategy.waypoints, self._dice,
        )  # fmt: skip
        return tuple(route[:length].copy() for route, length in zip(packed, lengths, strict=True))
