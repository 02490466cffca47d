"""What is searched, by whom and for how long: all of a search but its strategy and its seed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation.agents import Agent, Team
from sooner.simulation.estimation import Estimator
from sooner.simulation.ground import area, perimeter_places
from sooner.simulation.links import Links
from sooner.simulation.sensing import Sensing
from sooner.simulation.strategies.strategy import Strategy
from sooner.simulation.world import Purpose, World, generator

__all__ = ["Scene"]

MOST_SECONDS = 100_000
MOST_LINKED = 100  # agents: each keeps what it knows of what each other one knows of each
MOST_BELIEVED = 1_500_000  # cells times agents: 2 GB, with the beliefs that agents keep to go back to
MOST_LOOKS = 30_000_000  # of a mission with links: 1 GB


@dataclass(frozen=True, eq=False)
class Scene:
    """What is searched, by whom, with which eyes and for how long: all of a search but its strategy and its seed.

    Parameters
    ----------
    world : World
    agents : tuple of Agent
    estimator : Estimator
    seconds : int                      how long the mission lasts; all look once a second
    replan_s : int                     seconds from one plan to the next
    target_offset : (float, float)     see `Sensing`; `HALF_CELL` is the named one
    starts_m : (A, 2) float or None    where agents start, instead of where the strategy has them start
    links : Links or None              given, each agent believes and plans for itself, from what it hears over them
    glimpse : (M,) float or None       P(a look sees the cell), see `Sensing`; the team knows it. None: every look does

    Raises
    ------
    InvalidProblemError                no whole seconds, a replan later than the end, agents that start outside the
                                       ground, links of one agent or of very many, a glimpse that is not one
                                       probability for each cell
    """

    world: World
    agents: tuple[Agent, ...] = (Agent(),) * 4
    estimator: Estimator = Estimator()
    seconds: int = 240
    replan_s: int = 5
    target_offset: tuple[float, float] = (0.0, 0.0)
    starts_m: NDArray[np.float64] | None = None
    links: Links | None = None
    glimpse: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        for name in ("seconds", "replan_s"):
            value = getattr(self, name)
            if not isinstance(value, int | np.integer) or isinstance(value, bool):
                raise InvalidProblemError(f"{name} = {value!r} came; expected whole seconds")
        if not 1 <= self.seconds <= MOST_SECONDS:
            raise InvalidProblemError(f"a mission of {self.seconds} s came; expected 1 to {MOST_SECONDS} s")
        if not 1 <= self.replan_s <= self.seconds:
            raise InvalidProblemError(
                f"a replan every {self.replan_s} s came; expected 1 s to the mission's {self.seconds} s"
            )
        object.__setattr__(self, "glimpse", self.sensing.glimpse)
        _ = self.team, area(self.grid)
        if self.starts_m is not None:
            object.__setattr__(self, "starts_m", _checked_starts(self.grid, self.starts_m, len(self.agents)))
        if self.links is not None:
            _check_linked(len(self.agents), self.grid.n_cells, self.seconds * self.sensing.most_looks)

    @property
    def grid(self) -> Grid:
        """The cells."""
        return self.world.grid

    @cached_property
    def team(self) -> Team:
        """The agents as arrays."""
        return Team(self.agents)

    @cached_property
    def sensing(self) -> Sensing:
        """What agents read."""
        return Sensing(self.grid, self.agents, self.target_offset, self.glimpse)

    @cached_property
    def target_cells(self) -> NDArray[np.int64]:
        """(N,) int64: the cell where the target sensor has a signal, for a target at each node."""
        return self.sensing.cells_of(self.world.graph.positions_m)

    def starts(self, strategy: Strategy, seed: int) -> NDArray[np.float64]:
        """(A, 2) float: where agents start."""
        if self.starts_m is not None:
            return self.starts_m.copy()
        drawn = perimeter_places(self.grid, len(self.agents), generator(seed, Purpose.STARTS))
        return _checked_starts(self.grid, strategy.starts(self.grid, self.agents, drawn), len(self.agents))


def _check_linked(n_agents: int, n_cells: int, most_looks: int) -> None:
    """Refuse what would not fit in memory: each agent's beliefs, and looks that some do not have, kept to the end."""
    if not 2 <= n_agents <= MOST_LINKED:
        raise InvalidProblemError(f"links between {n_agents} agents came; expected 2 to {MOST_LINKED} agents")
    if n_agents * n_cells > MOST_BELIEVED:
        raise InvalidProblemError(
            f"links between {n_agents} agents over {n_cells:,} cells came; expected at most {MOST_BELIEVED:,} cells "
            "times agents, or no links"
        )
    if most_looks > MOST_LOOKS:
        raise InvalidProblemError(
            f"links came in a mission of up to {most_looks:.2g} looks; expected at most {MOST_LOOKS:.2g}: a shorter "
            "mission, fewer agents, or no links"
        )


def _checked_starts(grid: Grid, starts: NDArray[np.float64], n_agents: int) -> NDArray[np.float64]:
    places = np.array(starts, float)
    if places.shape != (n_agents, 2):
        raise InvalidProblemError(f"starts of shape {places.shape} came for {n_agents} agents; expected (A, 2)")
    low, high = area(grid)
    outside = ~((places >= low - 1e-6) & (places <= high + 1e-6)).all(axis=1)
    if outside.any():
        east, north = places[np.flatnonzero(outside)[0]]
        raise InvalidProblemError(
            f"an agent that starts {east:g} m east, {north:g} m north came; the ground is {low[0]:g} to {high[0]:g} m "
            f"east and {low[1]:g} to {high[1]:g} m north of the south-west cell's centre"
        )
    return places
