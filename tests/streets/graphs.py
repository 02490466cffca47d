"""Small occupancy graphs for tests: random ones, with triangles, isolated nodes and several parts."""

import numpy as np

from sooner.grid import Grid
from sooner.streets import OccupancyGraph


def random_graph(rng, rows=4, cols=5, node_share=0.6, edge_share=0.6, cell_m=5.0) -> OccupancyGraph:
    """Nodes in some of the cells, in places of their own, and edges between some of those that touch."""
    grid = Grid((rows, cols), "square8", cell_m)
    cells = np.flatnonzero(rng.random(grid.n_cells) < node_share)
    if not len(cells):
        cells = np.array([0])
    at_row, at_col = np.divmod(cells, cols)
    touching = np.maximum(abs(at_row[:, None] - at_row), abs(at_col[:, None] - at_col)) == 1
    edges = np.argwhere(np.triu(touching) & (rng.random(touching.shape) < edge_share))
    places = grid.centres_m[cells] + (rng.random((len(cells), 2)) - 0.5) * cell_m
    return OccupancyGraph.of(grid, cells, edges, places)
