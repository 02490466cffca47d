"""The strategy of [Wolek2020]: fly where a look teaches most, by tasks that the team shares out step by step."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from math import ceil
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.belief.state_information import InformationTable
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.sensors.graded import GradedSensor
from sooner.simulation.agents import Agent, Team
from sooner.simulation.ground import area
from sooner.simulation.strategies.strategy import Routes, Situation

__all__ = ["SWEPT_INFORMATION", "Information", "InformationSession"]

UTILITIES = ("maximum", "accumulated", "swept")  # by the numbers that the kernel knows them by
ROLLOUT_STEP_S = 0.2  # of Euler's rule in rollouts; flights of 11 s come out 0.1 s too long, and 3 cm beside


@dataclass(frozen=True)
class Information:
    """Waypoints at the centres of mass of Voronoi cells under information, assigned to agents step by step.

    At every replan: information of each cell (eq. 18); Lloyd's algorithm with information as density makes n_t tasks;
    n_w - 1 times, agents share the tasks by the Hungarian method, for a utility (eq. 19) of each of an agent's n_b
    nearest, and information in view along the chosen flights is removed   [Wolek2020, sections III.D and III.E].

    R(i, j) = I_max(w_i, w_j) / T(w_i, w_j)

    Each agent flies, looks and values by its own body and sensors. A look of agent k at a cell takes the share
    g I_k / I_best of what is left to be learnt there, with I_best what a look of the team's best sensors teaches, and g
    the probability that a look sees the cell at all. So where all are equal and see everything, a look takes all, as in
    the paper; worse sensors, and looks that may be in vain, leave the rest to later looks and to other agents.

    Parameters
    ----------
    tasks : int            n_t
    waypoints : int        n_w, with the agent's own place as the first
    neighbours : int       n_b
    utility : str          "maximum", the paper's I_max: the most information of a single cell that comes in view on the
                           way; "accumulated": the sum over looks on the way of the most that each teaches of a cell,
                           another reading of the paper's words; or "swept": what looks along the way teach of all
                           cells in view. Each over the time T
    capture : float        share of the radius within which a waypoint is reached in flight
    arrive : float         the same in rollouts, which tell T
    floor : float          added to the density in bits, so that known ground has its tasks as well
    gain : float           share of the way to its centre of mass that a task's site moves in a round of Lloyd
    rounds : int           of Lloyd, at most
    near_m : float         Lloyd stops when sites are this near to their centres of mass, on average

    Raises
    ------
    InvalidProblemError    if a number makes no sense

    Notes
    -----
    A look that may be in vain is worth g I, what it would be worth to one who is told whether it was. By eq. (18) of
    readings that are noise for a share 1 - g it is less: canopy hides that there is no node better than that there is
    one. Plans by that measure put off ground under canopy, and find fewer nodes in time than plans that know of none.

    The paper says neither how Lloyd's algorithm runs nor when a waypoint counts as reached; these values come near its
    figures. The task of the Voronoi cell in which an agent stands is no candidate of its first step.

    Examples
    --------
    >>> Information().utility, SWEPT_INFORMATION.utility
    ('maximum', 'swept')
    """

    tasks: int = 100
    waypoints: int = 4
    neighbours: int = 15
    utility: Literal["maximum", "accumulated", "swept"] = "maximum"
    capture: float = 2.0 / 3.0
    arrive: float = 0.1
    floor: float = 0.001
    gain: float = 0.2
    rounds: int = 100
    near_m: float = 0.1

    def __post_init__(self) -> None:
        if self.tasks < 1 or self.waypoints < 2 or self.neighbours < 1 or self.rounds < 1:
            raise InvalidProblemError(
                f"{self.tasks} tasks, {self.waypoints} waypoints, {self.neighbours} neighbours, {self.rounds} rounds "
                "came; expected at least 1, 2, 1 and 1"
            )
        if self.utility not in UTILITIES:
            raise InvalidProblemError(f"utility {self.utility!r} came; expected one of {', '.join(UTILITIES)}")
        for name in ("capture", "arrive", "floor", "gain", "near_m"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InvalidProblemError(f"{name} = {value} came; expected a positive number")
        if self.gain > 1.0:
            raise InvalidProblemError(f"a gain of {self.gain} came; expected at most 1")

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """On the perimeter, as drawn."""
        return drawn

    def session(self, situation: Situation, rng: Generator) -> InformationSession:
        """Begin a search: sites lie anywhere.

        Raises
        ------
        InvalidProblemError    if there are fewer tasks than waypoints of all agents together, or cells are hexagons
        """
        wanted = (self.waypoints - 1) * len(situation.agents)
        if self.tasks < wanted + len(situation.agents):
            raise InvalidProblemError(
                f"{self.tasks} tasks came for {len(situation.agents)} agents with {self.waypoints - 1} new waypoints "
                f"each; expected at least {wanted + len(situation.agents)}"
            )
        if situation.grid.connectivity == "hex":
            raise InvalidProblemError("hexagonal cells came; expected square ones")
        low, high = area(situation.grid)
        sites = low + rng.random((self.tasks, 2)) * (high - low)
        return InformationSession(self, situation.agents, sites)


SWEPT_INFORMATION = Information(utility="swept")
"""The same with the information of all cells that come in view on the way, instead of that of the best."""


@dataclass(eq=False)
class InformationSession:
    """Shares out tasks; it remembers where their sites were.

    sites : (n_t, 2) float       the generators of the Voronoi cells, metres
    middles : (n_t, 2) float     their cells' centres of mass at the last replan: the tasks
    rounds : int                 of Lloyd at the last replan
    """

    strategy: Information
    agents: tuple[Agent, ...]
    sites: NDArray[np.float64]
    middles: NDArray[np.float64] = field(init=False)
    rounds: int = 0

    def __post_init__(self) -> None:
        self.middles = self.sites.copy()
        team = Team(self.agents)
        self._step_s = rollout_step_s(team)
        self._team = team.v_max, team.a_max, team.radius_m, self.strategy.arrive * team.radius_m
        pairs = [(agent.map_sensor, agent.target_sensor) for agent in self.agents]
        different = list(dict.fromkeys(pairs))
        self._tables = [_table(*pair) for pair in different]
        self._kinds = np.array([different.index(pair) for pair in pairs], np.int64)

    def routes(self, situation: Situation) -> Routes:
        """New waypoints for each agent, three with the paper's settings."""
        from sooner.simulation.strategies._task_kernels import assign

        surfaces = self.information(situation)
        density = np.bincount(self._kinds) / len(self._kinds) @ surfaces
        if situation.glimpse is not None:
            density *= situation.glimpse
        self.place_tasks(density, situation.grid)
        left = surfaces.max(axis=0)
        shares = np.divide(surfaces, left, out=np.ones_like(surfaces), where=left > 0.0)
        if situation.glimpse is not None:
            shares *= situation.glimpse
        strategy, (height, width) = self.strategy, situation.grid.shape
        routes = np.empty((len(self.agents), strategy.waypoints - 1, 2))
        assign(
            situation.places_m, situation.velocities_mps, *self._team, self.middles,
            self._own_tasks(situation.places_m), left, shares, self._kinds, height, width,
            float(situation.grid.cell_m), strategy.neighbours, UTILITIES.index(strategy.utility), self._step_s, routes,
        )  # fmt: skip
        return tuple(routes)

    def information(self, situation: Situation) -> NDArray[np.float64]:
        """(K, M) bits that a look that sees teaches of each cell, for each pair of sensors that the agents have."""
        states = situation.states
        surfaces = np.empty((len(self._tables), states.void.size))
        for surface, table in zip(surfaces, self._tables, strict=True):
            table.information(states.void, states.unoccupied, states.occupied, surface)
        return surfaces

    def place_tasks(self, information: NDArray[np.float64], grid: Grid) -> NDArray[np.int32]:
        """Move sites and tasks to where the information is; returns the (M,) int32 Voronoi cell of each grid cell."""
        from sooner.simulation.strategies._task_kernels import lloyd

        strategy, (height, width) = self.strategy, grid.shape
        owner = np.empty(grid.n_cells, np.int32)
        self.rounds = lloyd(
            information + strategy.floor, height, width, float(grid.cell_m), strategy.gain, strategy.rounds,
            strategy.near_m, self.sites, owner, self.middles,
        )  # fmt: skip
        return owner

    def _own_tasks(self, places_m: NDArray[np.float64]) -> NDArray[np.int64]:
        """(A,) int64: the task of the Voronoi cell in which each agent is."""
        apart = ((places_m[:, None] - self.sites) ** 2).sum(axis=2)
        return np.asarray(apart.argmin(axis=1), np.int64)


def rollout_step_s(team: Team) -> float:
    """A whole part of a second, shorter for agents that are at full speed so soon that longer steps would overshoot.

    >>> rollout_step_s(Team((Agent(),))), rollout_step_s(Team((Agent(v_max=1.0, a_max=10.0),)))
    (0.2, 0.05)
    """
    return 1.0 / ceil(1.0 / min(ROLLOUT_STEP_S, float((0.5 * team.v_max / team.a_max).min())) - 1e-9)


@lru_cache(maxsize=64)
def _table(map_sensor: GradedSensor, target_sensor: GradedSensor) -> InformationTable:
    return InformationTable(map_sensor.p_levels, target_sensor.p_levels)
