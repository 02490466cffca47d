"""One search that stops at every replan, and goes on when it is told where to fly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.simulation import Agent, Episode, Keep, Scene
from sooner.simulation.command import CommandPost
from sooner.simulation.in_flight import Flight
from sooner.simulation.loop import Record
from sooner.simulation.strategies import Routes, Situation, Strategy

__all__ = ["CAPTURE", "Turns"]

CAPTURE = 2.0 / 3.0  # as `Information` has it; with one waypoint a turn it changes nothing

Watch = Callable[[NDArray[np.int32], NDArray[np.float64]], None]


class Turns:
    """The search that `simulate` flies, turn by turn: whoever holds it reads `situation` and answers by `fly`.

    Parameters
    ----------
    scene : Scene           a turn lasts for its `replan_s`
    seed : int
    capture : float         share of its radius of view within which an agent takes a waypoint for reached, in flight

    Attributes
    ----------
    situation : Situation   now; its arrays are the simulator's own, and change
    """

    def __init__(self, scene: Scene, seed: int, capture: float) -> None:
        self.scene = scene
        self.seed = seed
        self._seat = _Seat(capture, self)
        self.flight = Flight(scene, seed, scene.starts(self._seat, seed), capture)
        self._command = CommandPost(scene, self._seat, seed)
        self._record = Record(Keep())
        self.situation: Situation
        self._see()
        self._command.plan(self.flight)

    @property
    def over(self) -> bool:
        """Whether the mission has ended."""
        return self.flight.over

    def fly(self, routes: Routes) -> None:
        """Fly these until the next replan, or the end."""
        flight = self.flight
        flight.reroute(routes)
        self._record.planned(flight)
        flight.go_on()
        while not flight.over:
            self._see()
            if flight.second % self.scene.replan_s == 0:
                break
            flight.go_on()
        self._command.plan(flight)

    def episode(self, strategy: Strategy | None = None) -> Episode:
        """The search as far as it has come; the strategy is whom it names as having flown."""
        return self._record.episode(self.flight, self._command, strategy, self.seed)

    def shown_to(self, watch: Watch) -> None:
        """Show this second's looks to a session that keeps a belief of its own, and those of every second to come."""
        self._seat.watcher = watch
        watch(self.flight.log.newest_cells, self.flight.log.newest_target_ratios)

    def _see(self) -> None:
        self.flight.look()
        self._record.told(self.flight, *self._command.see(self.flight))


class _Seat:
    """Strategy and session at once, for the command post: it takes down the situation, and changes no routes."""

    def __init__(self, capture: float, turns: Turns) -> None:
        self.capture = capture
        self.watcher: Watch | None = None
        self._turns = turns

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """On the perimeter, as drawn."""
        return drawn

    def session(self, situation: Situation, rng: Generator) -> _Seat:
        """It is its own."""
        return self

    def routes(self, situation: Situation) -> Routes:
        """Unchanged: whoever holds the search says them later."""
        self._turns.situation = situation
        return situation.routes

    def watch(self, cells: NDArray[np.int32], target_ratios: NDArray[np.float64]) -> None:
        """Pass on each second's looks."""
        if self.watcher is not None:
            self.watcher(cells, target_ratios)
