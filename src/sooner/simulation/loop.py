"""The closed loop: look, believe, detect, plan, and fly for a second, until the time is up."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sooner.simulation.command import Command, CommandPost
from sooner.simulation.decentralised_command import DecentralisedCommand
from sooner.simulation.episode import Beliefs, Call, Episode
from sooner.simulation.in_flight import Flight
from sooner.simulation.scene import Scene
from sooner.simulation.strategies.strategy import Routes, Strategy

__all__ = ["Keep", "Record", "command_of", "simulate"]


@dataclass(frozen=True)
class Keep:
    """What an episode keeps besides what its score needs: all looks, and beliefs every so many seconds (0: never)."""

    looks: bool = False
    beliefs_s: int = 0


def simulate(scene: Scene, strategy: Strategy, seed: int, keep: Keep = Keep()) -> Episode:
    """Fly one search.

    Each second: all agents look at all cells in view; Bayes' law; nodes are detected; the target is tracked and
    perhaps called; at a replan the strategy is asked; the target moves while agents fly on    [Wolek2020, section IV].
    What the world holds and what a sensor reads at a place and second depends on the seed alone, not on the strategy.

    Examples
    --------
    >>> from sooner.grid import Grid
    >>> from sooner.simulation import World
    >>> from sooner.simulation.strategies import Lawnmower
    >>> from sooner.streets import OccupancyGraph
    >>> street = [(row, 10) for row in range(20)]
    >>> grid = Grid((20, 20), "square8", 5.0)
    >>> graph = OccupancyGraph.of(grid, [grid.index(cell) for cell in street], [(n, n + 1) for n in range(19)])
    >>> flown = simulate(Scene(World(graph), seconds=120), Lawnmower(), seed=1)
    >>> bool(flown.nodes_curve[-1] > 0.9)
    True
    """
    flight = Flight(scene, seed, scene.starts(strategy, seed), strategy.capture, keep.looks)
    command = command_of(scene, strategy, seed)
    record = Record(keep)
    while not flight.over:
        flight.look()
        record.told(flight, *command.see(flight))
        if flight.second % scene.replan_s == 0:
            routes = command.plan(flight)
            if routes is not None:
                flight.reroute(routes)
            record.planned(flight)
        record.believed(flight, command)
        flight.go_on()
    return record.episode(flight, command, strategy, seed)


def command_of(scene: Scene, strategy: Strategy, seed: int) -> Command:
    """Who believes and plans: one command post, or one aboard each agent where there are links."""
    if scene.links is None:
        return CommandPost(scene, strategy, seed)
    return DecentralisedCommand(scene, strategy, scene.links, seed)


@dataclass(eq=False)
class Record:
    """What an episode keeps of a flight, as it comes; whoever flies one tells it."""

    keep: Keep
    sums: list[float] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)
    followed: list[tuple[int, int, int]] = field(default_factory=list)
    plans: list[Routes] = field(default_factory=list)
    snapshots: list[tuple[int, NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]] = field(
        default_factory=list
    )

    def told(self, flight: Flight, total: float, calls: tuple[tuple[int, int], ...]) -> None:
        """What the detector says after this second's looks."""
        self.sums.append(total)
        self.calls.extend(Call(flight.second, cell, flight.target_near(cell, then)) for cell, then in calls)

    def planned(self, flight: Flight) -> None:
        """Routes after a replan."""
        self.plans.append(flight.routes)

    def believed(self, flight: Flight, command: Command) -> None:
        """Where targets that were found are believed to be, and a copy of what else is, if it is time for one."""
        if followed := command.belief.followed:
            self.followed.extend((flight.second, number, cell) for number, cell in followed.items())
        if self.keep.beliefs_s and flight.second % self.keep.beliefs_s == 0:
            command.belief.settle()
            states = command.belief.states
            self.snapshots.append((flight.second, states.void.copy(), states.occupied.copy(), states.explored.copy()))

    def episode(self, flight: Flight, command: Command, strategy: Strategy | None, seed: int) -> Episode:
        """The flight, as far as it has come."""
        return Episode(
            scene=flight.scene,
            strategy=strategy,
            seed=seed,
            targets=flight.scene.world.states.current[flight.truth.path],
            places_m=flight.track_m,
            node_seconds=command.node_seconds,
            agents_node_seconds=command.agents_node_seconds,
            sums=np.array(self.sums),
            calls=tuple(self.calls),
            plans=tuple(self.plans),
            looks=flight.looks() if self.keep.looks else None,
            beliefs=self._beliefs() if self.snapshots else None,
            followed=np.array(self.followed, np.int64).reshape(-1, 3),
        )

    def _beliefs(self) -> Beliefs:
        seconds, void, occupied, explored = zip(*self.snapshots, strict=True)
        return Beliefs(np.array(seconds, np.int64), np.array(void), np.array(occupied), np.array(explored))
