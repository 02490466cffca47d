"""One search that stops at every replan, and goes on when it is told where to fly."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation import Agent, Episode, Keep, Scene
from sooner.simulation.in_flight import Flight
from sooner.simulation.loop import Record, command_of
from sooner.simulation.strategies import Routes, Session, Situation

__all__ = ["CAPTURE", "Turns"]

CAPTURE = 2.0 / 3.0  # as `Information` has it; with one waypoint a turn it changes nothing


class Turns:
    """The search that `simulate` flies, turn by turn: whoever holds it reads `situation` and answers by `fly`.

    Parameters
    ----------
    scene : Scene           a turn lasts for its `replan_s`
    seed : int
    capture : float         share of its radius of view within which an agent takes a waypoint for reached, in flight

    Raises
    ------
    InvalidProblemError     by `situation` and `shown_to`, where there are links: each agent has a situation of its own
    """

    def __init__(self, scene: Scene, seed: int, capture: float) -> None:
        self.scene = scene
        self.seed = seed
        self._seats = _Seats(capture)
        self.flight = Flight(scene, seed, scene.starts(self._seats, seed), capture)
        self._command = command_of(scene, self._seats, seed)
        self._record = Record(Keep())
        self._see()
        self._command.plan(self.flight)

    @property
    def over(self) -> bool:
        """Whether the mission has ended."""
        return self.flight.over

    @property
    def situations(self) -> tuple[Situation, ...]:
        """What is known now, by all or by each agent; the arrays are the simulator's own, and change."""
        return tuple(seat.situation for seat in self._seats.taken)

    @property
    def situation(self) -> Situation:
        """What all know now."""
        return self._only.situation

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

    def episode(self) -> Episode:
        """The search as far as it has come, by a strategy that no file can name."""
        return self._record.episode(self.flight, self._command, None, self.seed)

    def shown_to(self, session: Session) -> None:
        """Show a session all that a command post shows its own, from this second on."""
        self._only.seat(session)

    @property
    def _only(self) -> _Seat:
        if len(self._seats.taken) > 1:
            raise InvalidProblemError("agents that believe each for itself came; expected a scene without links")
        return self._seats.taken[0]

    def _see(self) -> None:
        self.flight.look()
        self._record.told(self.flight, *self._command.see(self.flight))


class _Seats:
    """The strategy by which situations come out: a seat for every command post, in the order of agents."""

    def __init__(self, capture: float) -> None:
        self.capture = capture
        self.taken: list[_Seat] = []

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        """On the perimeter, as drawn."""
        return drawn

    def session(self, situation: Situation, rng: Generator) -> _Seat:
        """One more seat."""
        self.taken.append(_Seat(situation))
        return self.taken[-1]


class _Seat:
    """A session that takes down the situation and changes no routes: whoever holds the search says them later."""

    def __init__(self, situation: Situation) -> None:
        self.situation = situation
        self._guest: Session | None = None
        self._looks: tuple[NDArray[np.int32], NDArray[np.float64]] | None = None
        self._finds: list[int] = []

    def routes(self, situation: Situation) -> Routes:
        """Unchanged."""
        self.situation = situation
        return situation.routes

    def watch(self, cells: NDArray[np.int32], target_ratios: NDArray[np.float64]) -> None:
        """Take down a second's looks and pass them on."""
        self._looks, self._finds = (cells, target_ratios), []
        watch = getattr(self._guest, "watch", None)
        if watch is not None:
            watch(cells, target_ratios)

    def found(self, cell: int) -> None:
        """Take down that a target was found, after the looks of that second, and pass it on."""
        self._finds.append(cell)
        found = getattr(self._guest, "found", None)
        if found is not None:
            found(cell)

    def seat(self, guest: Session) -> None:
        """Pass all on to a session from now on, this second's first."""
        self._guest = guest
        if self._looks is not None:
            finds = self._finds
            self.watch(*self._looks)
            for cell in finds:
                self.found(cell)
