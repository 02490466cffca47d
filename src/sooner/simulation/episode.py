"""The record of one flown search, and what it was worth."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import nan

import numpy as np
from numpy.typing import NDArray

from sooner.simulation.scene import Scene
from sooner.simulation.strategies.strategy import Strategy

__all__ = ["Beliefs", "Call", "Episode", "Looks"]


@dataclass(frozen=True)
class Call:
    """The detector says "here": its sum crossed the threshold from below.

    second : int
    cell : int         the likeliest cell then; or before, where agents hear of looks that others made a while ago
    target : int       the target that was within the radius of view of its centre, -1 for none: a false call
    """

    second: int
    cell: int
    target: int


@dataclass(frozen=True, eq=False)
class Looks:
    """What was read: second s holds looks `firsts[s]` to `firsts[s + 1]`.

    firsts : (T + 1,) int64
    cells, agents, map_levels, target_levels : (L,) whole numbers
    """

    firsts: NDArray[np.int64]
    cells: NDArray[np.int32]
    agents: NDArray[np.int16]
    map_levels: NDArray[np.int16]
    target_levels: NDArray[np.int16]


@dataclass(frozen=True, eq=False)
class Beliefs:
    """What was believed of cells at some seconds, after the looks of that second.

    seconds : (B,) int64
    void, occupied : (B, M) float      probabilities; what is missing from one is unoccupied
    explored : (B, M) bool
    """

    seconds: NDArray[np.int64]
    void: NDArray[np.float64]
    occupied: NDArray[np.float64]
    explored: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Episode:
    """One flown search: what was true, where agents went, what they read, believed, planned and detected.

    E = (1/2) int_0^1 targets(t) dt + (1/2) int_0^1 nodes(t) dt                       [Wolek2020, eq. (20)]

    with the shares of targets and of nodes detected by the time t, 1 being the end of the mission.

    Parameters
    ----------
    scene : Scene                           with the graph (N nodes, M cells), agents (A) and seconds (T)
    strategy : Strategy or None             what flew; None where a file names one that is not ours
    seed : int
    targets : (T + 1, Q) int64              the node where each target was at each second
    places_m : (T + 1, A, 2) float          where each agent was
    node_seconds : (M,) int64               when a node was detected in each cell, rightly or not; -1 never
    sums : (T,) float                       what the detector held against its threshold after the looks of each second
    calls : tuple of Call
    plans : tuple of tuples of (k, 2)       routes at each replan, by agent
    looks, beliefs                          kept if asked for
    agents_node_seconds : (A, M) or None    where agents believe by themselves: as `node_seconds`, which is the first
    followed : (F, 3) int64                 where targets that were found are followed: second, number of the track (one
                                            that commands all numbers its calls from 1), cell where it is likeliest
    """

    scene: Scene
    strategy: Strategy | None
    seed: int
    targets: NDArray[np.int64]
    places_m: NDArray[np.float64]
    node_seconds: NDArray[np.int64]
    sums: NDArray[np.float64]
    calls: tuple[Call, ...]
    plans: tuple[tuple[NDArray[np.float64], ...], ...] = field(default=(), repr=False)
    looks: Looks | None = field(default=None, repr=False)
    beliefs: Beliefs | None = field(default=None, repr=False)
    agents_node_seconds: NDArray[np.int64] | None = field(default=None, repr=False)
    followed: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 3), np.int64), repr=False)

    @property
    def seconds(self) -> int:
        """How long the mission lasts, T."""
        return self.scene.seconds

    @property
    def nodes(self) -> NDArray[np.int64]:
        """(N,) int64: cells that hold a node."""
        return self.scene.world.graph.cells

    @property
    def n_targets(self) -> int:
        """Number of targets, Q."""
        return int(self.targets.shape[1])

    @cached_property
    def found_nodes(self) -> NDArray[np.int64]:
        """(N,) int64: the second in which each true node was detected, -1 never."""
        return self.node_seconds[self.nodes]

    @property
    def false_nodes(self) -> int:
        """Cells that hold no node, and where one was detected."""
        detected: NDArray[np.bool_] = self.node_seconds >= 0
        detected[self.nodes] = False
        return int(detected.sum())

    @cached_property
    def found_targets(self) -> NDArray[np.int64]:
        """(Q,) int64: the second of the first call that was right about each target, -1 for none."""
        seconds = np.full(self.n_targets, -1, np.int64)
        for call in reversed(self.calls):
            if call.target >= 0:
                seconds[call.target] = call.second
        return seconds

    @property
    def false_calls(self) -> int:
        """Calls with no target near."""
        return sum(call.target < 0 for call in self.calls)

    @property
    def repeated_calls(self) -> int:
        """Calls near a target that an earlier one had found: neither finds nor false."""
        return len(self.calls) - self.false_calls - int((self.found_targets >= 0).sum())

    @property
    def e_nodes(self) -> float:
        """The half of E that nodes make, in [0, 0.5]."""
        return _half(self.found_nodes, self.seconds)

    @property
    def e_targets(self) -> float:
        """The half of E that targets make, in [0, 0.5]; not a number where there are none."""
        return _half(self.found_targets, self.seconds)

    @property
    def e(self) -> float:
        """E, in [0, 1]; not a number where there are no targets."""
        return self.e_nodes + self.e_targets

    @property
    def e_nodes_by_all(self) -> float:
        """Like `e_nodes`, where a node counts when the last agent has detected it, too."""
        if self.agents_node_seconds is None:
            return self.e_nodes
        by_agent = self.agents_node_seconds[:, self.nodes]
        return _half(np.where((by_agent >= 0).all(axis=0), by_agent.max(axis=0), -1), self.seconds)

    @property
    def nodes_curve(self) -> NDArray[np.float64]:
        """(T + 1,) float: the share of true nodes detected by each second."""
        return _curve(self.found_nodes, self.seconds)

    @property
    def targets_curve(self) -> NDArray[np.float64]:
        """(T + 1,) float: the share of targets detected by each second."""
        return _curve(self.found_targets, self.seconds)


def _half(found: NDArray[np.int64], seconds: int) -> float:
    if not len(found):
        return nan
    left = np.where(found >= 0, seconds - found, 0)
    return float(0.5 * left.mean() / seconds)


def _curve(found: NDArray[np.int64], seconds: int) -> NDArray[np.float64]:
    counts = np.bincount(found[found >= 0], minlength=seconds + 1).astype(float)
    share: NDArray[np.float64] = np.cumsum(counts) / max(len(found), 1)
    return share
