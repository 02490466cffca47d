"""Who believes and plans while a search is flown: one command post that hears every look and leads every agent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sooner.simulation.estimation import TeamBelief
from sooner.simulation.in_flight import Flight
from sooner.simulation.scene import Scene
from sooner.simulation.strategies.strategy import Routes, Session, Situation, Strategy
from sooner.simulation.world import Purpose, generator

__all__ = ["Command", "CommandPost"]

Watch = Callable[[NDArray[np.int32], NDArray[np.float64]], None]


class Command(Protocol):
    """Whoever believes and plans in a search: shown each second's looks, asked for routes at each replan."""

    @property
    def belief(self) -> TeamBelief:
        """What an episode records as believed."""

    def see(self, flight: Flight) -> tuple[float, tuple[int, ...]]:
        """Take in this second's looks: what the detector holds against its threshold, and cells where it calls."""

    def plan(self, flight: Flight) -> Routes | None:
        """Routes from now on, by agent; None to go on unchanged."""


class CommandPost:
    """Hears every look as it is made, has one belief, and leads every agent.

    Parameters
    ----------
    scene : Scene
    strategy : Strategy
    seed : int            of what the strategy draws
    """

    def __init__(self, scene: Scene, strategy: Strategy, seed: int) -> None:
        self.scene = scene
        self.strategy = strategy
        self.belief = scene.estimator.begun(scene.world, scene.sensing.most_looks)
        self._rng = generator(seed, Purpose.STRATEGY)
        self._session: Session | None = None
        self._watch: Watch | None = None

    def see(self, flight: Flight) -> tuple[float, tuple[int, ...]]:
        """Take in this second's looks; a session with a belief of its own is shown them too."""
        told = self.belief.see(flight.second, flight.log)
        self._show(flight)
        return told

    def plan(self, flight: Flight) -> Routes | None:
        """What the strategy answers to what is believed now."""
        self.belief.predict()
        situation = self._situation(flight)
        if self._session is None:
            self._session = self.strategy.session(situation, self._rng)
            self._watch = getattr(self._session, "watch", None)
            self._show(flight)
        routes = self._session.routes(situation)
        return None if routes is situation.routes else routes

    def _show(self, flight: Flight) -> None:
        """Show this second's looks to a session that keeps a belief of its own."""
        if self._watch is not None:
            self._watch(flight.log.newest_cells, flight.log.newest_target_ratios)

    def _situation(self, flight: Flight) -> Situation:
        scene = self.scene
        return Situation(
            grid=scene.grid,
            agents=scene.agents,
            now_s=float(flight.second),
            end_s=float(scene.seconds),
            replan_s=float(scene.replan_s),
            places_m=flight.places_m,
            velocities_mps=flight.velocities_mps,
            routes=flight.routes,
            states=self.belief.states,
            detected_target=self.belief.has_called,
            graph=scene.world.graph,
        )
