"""Where a target came from and where it is: pairs of nodes, so that it has a heading."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sooner.streets.occupancy import OccupancyGraph

__all__ = ["Growth", "TargetStates", "growth"]


@dataclass(frozen=True, eq=False)
class TargetStates:
    """The states s = (p, c) of a target on a graph, previous and current node, and their transitions.

    S = {(p, c): p and c touch, or p = c}, and (p, c) leads to (c, c) and to every (c, n)   [Wolek2020, sec. II.B]

    State i < N is rest at node i. State N + k is the arrival at `neighbours[k]` of the graph from the node whose row k
    belongs to. So the states that leave node c are one run, N + starts[c] to N + starts[c + 1]; a state's outgoing
    transitions are rest first and then that run, and the states that arrive at c are `reverse` of it.

    Parameters
    ----------
    graph : OccupancyGraph          N nodes, E edges; S = N + 2E states

    Examples
    --------
    >>> from sooner.grid import Grid
    >>> states = TargetStates(OccupancyGraph.of(Grid((1, 3)), cells=[0, 1, 2], edges=[(0, 1), (1, 2)]))
    >>> states.previous, states.current
    (array([0, 1, 2, 0, 1, 1, 2]), array([0, 1, 2, 1, 0, 2, 1]))
    >>> states.outgoing(3).tolist()     # (0, 1): rests, turns round, goes straight on
    [1, 4, 5]
    """

    graph: OccupancyGraph

    @property
    def n_nodes(self) -> int:
        """Number of nodes, N: the first N states are at rest."""
        return self.graph.n_nodes

    @property
    def n_states(self) -> int:
        """Number of states, S = N + 2E."""
        return self.graph.n_nodes + 2 * self.graph.n_edges

    @property
    def n_transitions(self) -> int:
        """Number of transitions: the sum over nodes of deg^2 + 2 deg + 1."""
        return int(self.outgoing_starts[-1])

    @cached_property
    def previous(self) -> NDArray[np.int64]:
        """(S,) int64: the node before, p."""
        nodes = np.arange(self.n_nodes)
        return np.concatenate([nodes, np.repeat(nodes, self.graph.degrees)])

    @cached_property
    def current(self) -> NDArray[np.int64]:
        """(S,) int64: the node now, c."""
        return np.concatenate([np.arange(self.n_nodes), self.graph.neighbours])

    @cached_property
    def is_rest(self) -> NDArray[np.bool_]:
        """(S,) bool: p = c."""
        return np.arange(self.n_states) < self.n_nodes

    @cached_property
    def heading(self) -> NDArray[np.float64]:
        """(S,) float: direction from p to c, radians counter-clockwise from east; NaN at rest, where there is none."""
        east, north = (self.graph.positions_m[self.current] - self.graph.positions_m[self.previous]).T
        return np.where(self.is_rest, np.nan, np.arctan2(north, east))

    @cached_property
    def reverse(self) -> NDArray[np.int64]:
        """(2E,) int64: for the state (p, c) with number N + k, at k, the number of the state (c, p)."""
        previous, current = self.previous[self.n_nodes :], self.current[self.n_nodes :]
        return self.n_nodes + np.lexsort((previous, current))

    @cached_property
    def outgoing_starts(self) -> NDArray[np.int64]:
        """(S + 1,) int64: where each state's row of transitions begins; first rest, then on to each neighbour."""
        return np.concatenate([[0], np.cumsum(1 + self.graph.degrees[self.current])]).astype(np.int64)

    @cached_property
    def outgoing_states(self) -> NDArray[np.int64]:
        """(transitions,) int64: where each transition leads."""
        starts, rows = self.outgoing_starts, np.repeat(np.arange(self.n_states), np.diff(self.outgoing_starts))
        offset = np.arange(starts[-1]) - starts[rows]
        current = self.current[rows]
        return np.where(offset == 0, current, self.n_nodes + self.graph.starts[current] + offset - 1)

    def outgoing(self, state: int) -> NDArray[np.int64]:
        """Where a state may lead next: rest, then on to each node that its own touches."""
        return self.outgoing_states[self.outgoing_starts[state] : self.outgoing_starts[state + 1]]

    def explored(self, detected: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(S,) bool: states both of whose nodes, of the (N,) bool, have been detected."""
        found: NDArray[np.bool_] = detected[self.previous] & detected[self.current]
        return found


@dataclass(frozen=True)
class Growth:
    """By how much a newly detected node makes the target state graph larger."""

    states: int
    transitions: int


def growth(graph: OccupancyGraph, detected: NDArray[np.bool_], node: int) -> Growth:
    """What the detection of a node adds to the explored target state graph   [Wolek2020, Proposition 1].

    2 deg(v) + 1 states and deg(v)^2 + 3 deg(v) + 1 + 2 sum_{i in N(v)} deg(i) transitions,

    degrees being those of the explored graph with v in it. A whole graph, built so node by node, has
    sum deg^2 + 2 sum deg + N transitions.

    Parameters
    ----------
    graph : OccupancyGraph
    detected : (N,) bool     nodes detected before
    node : int               v, not among them

    Examples
    --------
    >>> import numpy as np
    >>> from sooner.grid import Grid
    >>> graph = OccupancyGraph.of(Grid((1, 3)), cells=[0, 1, 2], edges=[(0, 1), (1, 2)])
    >>> growth(graph, np.array([True, False, True]), 1)
    Growth(states=5, transitions=15)
    """
    after = detected.copy()
    after[node] = True
    degrees = np.bincount(graph.explored_edges(after).ravel(), minlength=graph.n_nodes)
    row = graph.neighbours[graph.starts[node] : graph.starts[node + 1]]
    degree = int(degrees[node])
    beside = int(degrees[row[detected[row]]].sum())
    return Growth(2 * degree + 1, degree**2 + 3 * degree + 1 + 2 * beside)
