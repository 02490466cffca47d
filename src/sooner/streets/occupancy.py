"""The occupancy graph: where a target that keeps to streets may be, and where it may go from there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid, centres_of

__all__ = ["OccupancyGraph"]

SLACK = 1e-3  # of a cell, by which a place may lie beside its cell: files round


@dataclass(frozen=True, eq=False)
class OccupancyGraph:
    """Nodes in cells, at most one a cell, and edges between cells that touch   [Wolek2020, sec. II.A].

    Parameters
    ----------
    grid : Grid                     square cells; a node may touch nodes of the 8 cells around its own
    cells : (N,) int64              the cell of each node, ascending
    edges : (E, 2) int64            pairs of nodes, the smaller number first, each pair once
    positions_m : (N, 2) float      metres east and north, in the frame of `Grid.centres_m`; anywhere in its cell

    Raises
    ------
    InvalidProblemError             no nodes, two in a cell, a node outside its cell or the grid, an edge between cells
                                    that do not touch, a node joined to itself, numbers that no node has

    Examples
    --------
    >>> street = OccupancyGraph.of(Grid((2, 3), "square8"), cells=[3, 1, 5], edges=[(0, 1), (1, 2)])
    >>> street.cells
    array([1, 3, 5])
    >>> street.edges
    array([[0, 1],
           [0, 2]])
    """

    grid: Grid
    cells: NDArray[np.int64]
    edges: NDArray[np.int64]
    positions_m: NDArray[np.float64]

    def __post_init__(self) -> None:
        _check_grid(self.grid)
        cells = _whole(self.cells, "cells of nodes")
        _check_cells(self.grid, cells)
        places = np.ascontiguousarray(self.positions_m, np.float64)
        _check_places(self.grid, cells, places)
        edges = _whole(self.edges, "edges").reshape(-1, 2)
        _check_edges(self.grid, cells, edges)
        for name, value in (("cells", cells), ("edges", edges), ("positions_m", places)):
            value = value.copy()
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, grid: Grid, cells: ArrayLike, edges: ArrayLike, positions_m: ArrayLike | None = None) -> OccupancyGraph:
        """A graph from nodes in any order and edges in any direction; nodes are renumbered by their cells.

        Places left out are the centres of the cells; edges told twice count once.
        """
        _check_grid(grid)
        given = _whole(cells, "cells of nodes").ravel()
        pairs = _whole(edges, "edges").reshape(-1, 2)
        order = np.argsort(given, kind="stable")
        number = np.empty(len(given), np.int64)
        number[order] = np.arange(len(given))
        if pairs.size and not (pairs.min() >= 0 and pairs.max() < len(given)):
            raise InvalidProblemError(f"an edge to node {_stray(pairs, len(given))} came; there are {len(given)} nodes")
        ends = np.unique(np.sort(number[pairs], axis=1), axis=0)
        if positions_m is None:
            return cls(grid, given[order], ends, centres_of(grid, given[order]))
        places = np.asarray(positions_m, np.float64)
        if places.shape != (len(given), 2):
            raise InvalidProblemError(f"places of shape {places.shape} came for {len(given)} nodes; expected (N, 2)")
        return cls(grid, given[order], ends, places[order])

    @property
    def n_nodes(self) -> int:
        """Number of nodes, N."""
        return len(self.cells)

    @property
    def n_edges(self) -> int:
        """Number of edges, E."""
        return len(self.edges)

    @cached_property
    def degrees(self) -> NDArray[np.int64]:
        """(N,) int64: how many nodes each node touches."""
        return np.bincount(self.edges.ravel(), minlength=self.n_nodes).astype(np.int64)

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """(N + 1,) int64: where each node's row of `neighbours` begins."""
        return np.concatenate([[0], np.cumsum(self.degrees)]).astype(np.int64)

    @cached_property
    def neighbours(self) -> NDArray[np.int64]:
        """(2E,) int64: the nodes that each node touches, ascending in every row."""
        ends = np.concatenate([self.edges, self.edges[:, ::-1]])
        return np.ascontiguousarray(ends[np.lexsort((ends[:, 1], ends[:, 0])), 1])

    @cached_property
    def node_of_cell(self) -> NDArray[np.int64]:
        """(M,) int64: the node in each cell of the grid, -1 where there is none."""
        nodes = np.full(self.grid.n_cells, -1, np.int64)
        nodes[self.cells] = np.arange(self.n_nodes)
        return nodes

    @cached_property
    def components(self) -> NDArray[np.int64]:
        """(N,) int64: the connected part that each node belongs to, numbered by its first node."""
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import connected_components

        shape = (self.n_nodes, self.n_nodes)
        joined = csr_array((np.ones(len(self.neighbours)), self.neighbours, self.starts), shape=shape)
        _, labels = connected_components(joined, directed=False)
        _, first = np.unique(labels, return_index=True)
        renumbered: NDArray[np.int64] = np.argsort(np.argsort(first))[labels].astype(np.int64)
        return renumbered

    def explored_edges(self, detected: NDArray[np.bool_]) -> NDArray[np.int64]:
        """(k, 2) int64: edges both of whose nodes, of the (N,) bool, have been detected."""
        found: NDArray[np.int64] = self.edges[detected[self.edges].all(axis=1)]
        return found


def _whole(values: ArrayLike, name: str) -> NDArray[np.int64]:
    given = np.asarray(values)
    if given.size == 0:
        return given.astype(np.int64)
    if given.dtype.kind not in "iu":
        raise InvalidProblemError(f"{name} of type {given.dtype} came; expected whole numbers")
    return np.ascontiguousarray(given, np.int64)


def _check_grid(grid: Grid) -> None:
    if grid.connectivity == "hex":
        raise InvalidProblemError("a grid of hexagons came; an occupancy graph lies on square cells")


def _check_cells(grid: Grid, cells: NDArray[np.int64]) -> None:
    if cells.ndim != 1 or len(cells) == 0:
        raise InvalidProblemError("an occupancy graph without nodes came; expected at least one")
    beyond = cells[(cells < 0) | (cells >= grid.n_cells)]
    if len(beyond):
        raise InvalidProblemError(f"a node in cell {beyond[0]} came; the grid has cells 0 to {grid.n_cells - 1}")
    twice = np.flatnonzero(np.diff(np.sort(cells)) == 0)
    if len(twice):
        cell = grid.cell(int(np.sort(cells)[twice[0]]))
        raise InvalidProblemError(f"two nodes in cell {list(cell)} came; a cell holds one node at most")
    if np.any(np.diff(cells) < 0):
        raise InvalidProblemError("nodes out of the order of their cells came; OccupancyGraph.of sorts them")


def _check_places(grid: Grid, cells: NDArray[np.int64], places: NDArray[np.float64]) -> None:
    if places.shape != (len(cells), 2):
        raise InvalidProblemError(f"places of shape {places.shape} came for {len(cells)} nodes; expected (N, 2)")
    beside = np.abs(places - centres_of(grid, cells)).max(axis=1)
    outside = np.flatnonzero(~(beside <= (0.5 + SLACK) * grid.cell_m))  # so that NaN is outside, too
    if len(outside):
        east, north = places[outside[0]]
        cell = list(grid.cell(int(cells[outside[0]])))
        raise InvalidProblemError(f"a node at {east:g} m east, {north:g} m north came, which is not in its cell {cell}")


def _check_edges(grid: Grid, cells: NDArray[np.int64], edges: NDArray[np.int64]) -> None:
    if not edges.size:
        return
    if edges.min() < 0 or edges.max() >= len(cells):
        raise InvalidProblemError(f"an edge to node {_stray(edges, len(cells))} came; there are {len(cells)} nodes")
    rows, cols = np.divmod(cells[edges], grid.shape[1])
    apart = np.maximum(np.abs(np.diff(rows)), np.abs(np.diff(cols)))[:, 0]
    loops = np.flatnonzero(edges[:, 0] == edges[:, 1])
    if len(loops):
        raise InvalidProblemError(f"an edge from node {edges[loops[0], 0]} to itself came; a target rests without one")
    far = np.flatnonzero(apart > 1)
    if len(far):
        a, b = (list(grid.cell(int(cells[node]))) for node in edges[far[0]])
        raise InvalidProblemError(f"an edge between cells {a} and {b} came; edges join cells that touch")
    if np.any(edges[:, 0] > edges[:, 1]) or len(np.unique(edges, axis=0)) < len(edges):
        raise InvalidProblemError("edges told twice, or the larger node first, came; OccupancyGraph.of sorts them")


def _stray(pairs: NDArray[np.int64], n_nodes: int) -> int:
    return int(pairs[(pairs < 0) | (pairs >= n_nodes)][0])
