"""Who believes and plans while a search is flown: one command post that hears every look and leads every agent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.simulation.estimation import TeamBelief
from sooner.simulation.in_flight import Flight
from sooner.simulation.scene import Scene
from sooner.simulation.sensing import LookLog
from sooner.simulation.strategies.strategy import Routes, Session, Situation, Strategy
from sooner.simulation.world import Purpose, generator

__all__ = ["Command", "CommandPost", "Kept", "Told"]

Watch = Callable[[NDArray[np.int32], NDArray[np.float64]], None]

Told = tuple[float, tuple[tuple[int, int], ...]]
"""What a detector holds against its threshold, and (cell, second) of all that it calls: a target was there then."""


class Command(Protocol):
    """Whoever believes and plans in a search: shown each second's looks, asked for routes at each replan."""

    @property
    def belief(self) -> TeamBelief:
        """What an episode records as believed."""

    @property
    def node_seconds(self) -> NDArray[np.int64]:
        """(M,) int64: when each cell's node was detected, -1 not yet."""

    @property
    def agents_node_seconds(self) -> NDArray[np.int64] | None:
        """(A, M) int64: likewise by each agent for itself; None where one commands all."""

    def see(self, flight: Flight) -> Told:
        """Take in this second's looks: what the detector holds against its threshold, and what it calls."""

    def plan(self, flight: Flight) -> Routes | None:
        """Routes from now on, by agent; None to go on unchanged."""


@dataclass(frozen=True, eq=False)
class Kept:
    """What a command post believed at a time, to come back to: its belief, and what its session made of the looks."""

    belief: TeamBelief
    session: Any


class CommandPost:
    """Hears every look as it is made, has one belief, and leads every agent.

    Parameters
    ----------
    scene : Scene
    strategy : Strategy
    seed : int            of what the strategy draws
    """

    agents_node_seconds = None

    def __init__(self, scene: Scene, strategy: Strategy, seed: int) -> None:
        self.scene = scene
        self.strategy = strategy
        self.belief = scene.estimator.begun(scene.world, scene.sensing.most_looks)
        self._rng = generator(seed, Purpose.STRATEGY)
        self._newest = LookLog(0)
        self._calls: tuple[int, ...] = ()
        self._session: Session | None = None
        self._watch: Watch | None = None
        self._found: Callable[[int], None] | None = None
        self._unwatched: Any = None

    @property
    def node_seconds(self) -> NDArray[np.int64]:
        """(M,) int64: when each cell's node was detected, -1 not yet."""
        return self.belief.node_seconds

    def see(self, flight: Flight) -> Told:
        """Take in this second's looks; a session with a belief of its own is shown them too."""
        total, cells = self.hear(flight.second, flight.log)
        return total, tuple((cell, flight.second) for cell in cells)

    def plan(self, flight: Flight) -> Routes | None:
        """What the strategy answers to what is believed now."""
        return self.decide(flight.second, flight.places_m, flight.velocities_mps, flight.routes)

    def hear(self, second: int, log: LookLog) -> tuple[float, tuple[int, ...]]:
        """Take in the looks of a second, of all agents or of some."""
        self._newest = log
        told = self.belief.see(second, log)
        self._calls = told[1]
        self._show()
        return told

    def decide(
        self, second: int, places_m: NDArray[np.float64], velocities_mps: NDArray[np.float64], routes: Routes
    ) -> Routes | None:
        """Routes for agents that are, or are thought to be, at (A, 2) places; None to go on unchanged."""
        self.belief.predict()
        situation = self._situation(second, places_m, velocities_mps, routes)
        if self._session is None:
            self._session = self.strategy.session(situation, self._rng)
            self._watch = getattr(self._session, "watch", None)
            self._found = getattr(self._session, "found", None)
            self._unwatched = self._remembered()
            self._show()
        answer = self._session.routes(situation)
        if answer is None:
            raise InvalidProblemError(
                f"{type(self._session).__name__}.routes answered None; expected a route for each agent, or "
                "situation.routes itself to go on unchanged"
            )
        return None if answer is situation.routes else answer

    def kept(self, spare: Kept | None = None) -> Kept:
        """A copy of what is believed now, on the arrays of another copy if one is to spare."""
        if spare is None:
            return Kept(self.belief.copy(), self._remembered())
        spare.belief.restore(self.belief)
        return Kept(spare.belief, self._remembered())

    def restore(self, kept: Kept) -> None:
        """Believe again what was believed then; the strategy's random numbers go on."""
        self.belief.restore(kept.belief)
        recall = getattr(self._session, "recall", None)
        if recall is not None:
            recall(self._unwatched if kept.session is None else kept.session)

    def _remembered(self) -> Any:
        remembered = getattr(self._session, "remembered", None)
        return None if remembered is None else remembered()

    def _show(self) -> None:
        """Show the newest looks, and what was found, to a session that keeps a belief of its own."""
        if self._watch is not None:
            self._watch(self._newest.newest_cells, self.belief.newest_ratios)
        if self._found is not None and self.belief.sought:
            for cell in self._calls:
                self._found(cell)

    def _situation(
        self, second: int, places_m: NDArray[np.float64], velocities_mps: NDArray[np.float64], routes: Routes
    ) -> Situation:
        scene = self.scene
        return Situation(
            grid=scene.grid,
            agents=scene.agents,
            now_s=float(second),
            end_s=float(scene.seconds),
            replan_s=float(scene.replan_s),
            places_m=places_m,
            velocities_mps=velocities_mps,
            routes=routes,
            states=self.belief.states,
            sought=self.belief.sought,
            found=self.belief.has_called,
            graph=scene.world.graph,
            glimpse=scene.glimpse,
        )
