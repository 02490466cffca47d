"""What is true: where streets run and where the targets are, second by second."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.random import Generator, SeedSequence, default_rng
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.streets import Evasive, OccupancyGraph, TargetStates, TargetWalk

__all__ = ["Purpose", "Truth", "World", "generator", "noise_seed"]

MOST_TARGETS = 1000


class Purpose:
    """What random numbers of one seed are for: each purpose has a stream of its own, whatever the others draw."""

    TARGETS, STARTS, STRATEGY, NOISE, LINKS = range(5)


def generator(seed: int, purpose: int) -> Generator:
    """The random numbers of a seed for one purpose.

    >>> generator(7, Purpose.STARTS).random() == generator(7, Purpose.STARTS).random()
    True
    """
    return default_rng(_sequence(seed, purpose))


def noise_seed(seed: int) -> int:
    """The whole number that settles, with second, agent and cell, what sensors read."""
    return int(_sequence(seed, Purpose.NOISE).generate_state(1, np.uint64)[0] >> np.uint64(1))


def _sequence(seed: int, purpose: int) -> SeedSequence:
    if seed < 0:
        raise InvalidProblemError(f"seed {seed} came; expected a whole number of at least 0")
    return SeedSequence(entropy=seed, spawn_key=(purpose,))


@dataclass(frozen=True, eq=False)
class World:
    """Streets, and targets that walk on them from nodes drawn uniformly.

    Parameters
    ----------
    graph : OccupancyGraph
    walk : TargetWalk              how targets walk, one step a second, after the agents have looked
    n_targets : int                0 for a search in vain: what is called then is false
    evasive : Evasive or None      targets shy from agents as this says; its places are replaced by the agents'

    Raises
    ------
    InvalidProblemError            if there are more targets than nodes, or fewer than none
    """

    graph: OccupancyGraph
    walk: TargetWalk = TargetWalk()
    n_targets: int = 1
    evasive: Evasive | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.n_targets <= min(self.graph.n_nodes, MOST_TARGETS):
            raise InvalidProblemError(
                f"{self.n_targets} targets came; expected 0 to {min(self.graph.n_nodes, MOST_TARGETS)}"
            )

    @property
    def grid(self) -> Grid:
        """The cells."""
        return self.graph.grid

    @cached_property
    def states(self) -> TargetStates:
        """Where targets may be and where they come from."""
        return TargetStates(self.graph)

    @cached_property
    def weights(self) -> NDArray[np.float64]:
        """(transitions,) float: how targets walk from each state."""
        return self.walk.weights(self.states)

    @cached_property
    def cell_states(self) -> TargetStates:
        """States of a target for whom every cell holds a node, true ones with their edges and all others alone.

        Node numbers are cell numbers. A tracker that works on these has room for nodes detected where none is.
        """
        graph = self.graph
        places = graph.grid.centres_m.copy()
        places[graph.cells] = graph.positions_m
        return TargetStates(OccupancyGraph(graph.grid, np.arange(graph.grid.n_cells), graph.cells[graph.edges], places))

    @cached_property
    def cell_weights(self) -> NDArray[np.float64]:
        """(transitions,) float: the walk over `cell_states`."""
        return self.walk.weights(self.cell_states)

    @cached_property
    def edge_cells(self) -> NDArray[np.int64]:
        """(E, 2) int64: the cells that each edge joins."""
        cells: NDArray[np.int64] = self.graph.cells[self.graph.edges]
        return cells

    @cached_property
    def edge_angles(self) -> NDArray[np.float64]:
        """(E,) float: the direction of each edge, radians counter-clockwise from east."""
        first, second = self.graph.positions_m[self.graph.edges].transpose(1, 2, 0)
        return np.asarray(np.arctan2(second[1] - first[1], second[0] - first[0]))

    @cached_property
    def nodes(self) -> NDArray[np.bool_]:
        """(M,) bool: cells that hold a node."""
        held: NDArray[np.bool_] = self.graph.node_of_cell >= 0
        return held

    def truth(self, seed: int, seconds: int) -> Truth:
        """The targets of one seed at their starts."""
        return Truth(self, seed, seconds)


class Truth:
    """Targets of one world under one seed.

    path : (T + 1, Q) int64      the state of each target at each second; past the present it is known only where
                                 targets do not care about agents, and is nobody's business but ours
    """

    def __init__(self, world: World, seed: int, seconds: int) -> None:
        rng = generator(seed, Purpose.TARGETS)
        self.world = world
        self.path = np.zeros((seconds + 1, world.n_targets), np.int64)
        self.path[0] = world.walk.started(world.states, rng, world.n_targets)
        self.draws = rng.random((seconds, world.n_targets))
        if world.evasive is None and world.n_targets:
            self._walk()

    def _walk(self) -> None:
        from sooner.streets._walk_kernels import walk

        states = self.world.states
        walk(
            self.path[0].copy(), self.draws, states.current, states.graph.starts, states.outgoing_starts,
            self.world.weights, self.path[1:],
        )  # fmt: skip

    def move(self, second: int, places_m: NDArray[np.float64]) -> None:
        """Targets go on from this second to the next, while agents are at (A, 2) places."""
        if self.world.evasive is None or not self.world.n_targets:
            return
        from sooner.streets._walk_kernels import step_biased

        states, graph = self.world.states, self.world.graph
        factors = replace(self.world.evasive, places_m=places_m).factors(graph.positions_m)
        for target, state in enumerate(self.path[second]):
            self.path[second + 1, target] = step_biased(
                state, self.draws[second, target], states.current, graph.starts, graph.neighbours,
                states.outgoing_starts, self.world.weights, factors,
            )  # fmt: skip

    def places_at(self, second: int) -> NDArray[np.float64]:
        """(Q, 2) float: where each target is, metres."""
        places: NDArray[np.float64] = self.world.graph.positions_m[self.nodes_at(second)]
        return places

    def nodes_at(self, second: int) -> NDArray[np.int64]:
        """(Q,) int64: the node where each target is."""
        nodes: NDArray[np.int64] = self.world.states.current[self.path[second]]
        return nodes
