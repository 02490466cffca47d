"""What a strategy is told at every replan, and what it answers: routes of waypoints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.simulation.agents import Agent

if TYPE_CHECKING:
    from sooner.belief.cell_states import CellStates
    from sooner.streets import OccupancyGraph

__all__ = ["Routes", "Session", "Situation", "Strategy"]

Routes = tuple[NDArray[np.float64], ...]
"""For each agent the waypoints that it has not reached yet, (k, 2) metres east and north; it hovers at the last."""


@dataclass(frozen=True, eq=False)
class Situation:
    """What a team knows when it plans again. Arrays are the simulator's own: read them, never write.

    grid : Grid
    agents : tuple of Agent
    now_s, end_s, replan_s : float     seconds since the start, when the mission ends, and how often it plans
    places_m, velocities_mps : (A, 2)  metres and metres a second, east and north
    routes : Routes                    what is left of the last plan
    states : CellStates                void, unoccupied, occupied, explored and detected nodes, by cell
    sought : bool                      whether a target is sought still, or another
    found : bool                       whether the detector has called
    graph : OccupancyGraph             the true streets: only edges between detected nodes may be asked for,
                                       `graph.explored_edges(states.nodes[graph.cells])`
    glimpse : (M,) float or None       P(a look sees the cell); None where every look does
    """

    grid: Grid
    agents: tuple[Agent, ...]
    now_s: float
    end_s: float
    replan_s: float
    places_m: NDArray[np.float64]
    velocities_mps: NDArray[np.float64]
    routes: Routes
    states: CellStates
    sought: bool
    found: bool
    graph: OccupancyGraph
    glimpse: NDArray[np.float64] | None = None


class Session(Protocol):
    """A strategy at work in one search; it may remember.

    It may have a method `watch(cells, target_ratios)` as well, which is shown the looks of every second, those of a
    replan before the replan: (k,) int32 cells, and P(level | target) / P(level | none) of what was read there. It then
    has `remembered()` too, which gives what it has made of them so far, and `recall(kept)`, which goes back to that:
    over slow links looks come late, and what followed them is watched again. Where targets that were found have tracks
    of their own, what these explain is taken out of the ratios. And it may have `found(cell)`, which is told after the
    looks that a target was found in a cell, and that another is sought.
    """

    def routes(self, situation: Situation) -> Routes:
        """New routes; `situation.routes` itself to go on unchanged."""


class Strategy(Protocol):
    """A way to fly: frozen settings, and a session for every search.

    capture : float     share of its radius of view within which an agent takes a waypoint for reached, in flight
    """

    @property
    def capture(self) -> float:
        """Share of the radius of view."""

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """(A, 2) float: where agents start; `drawn` are random places on the perimeter, the same for all strategies."""

    def session(self, situation: Situation, rng: Generator) -> Session:
        """Begin a search."""
