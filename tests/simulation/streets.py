"""Small streets to search."""

import numpy as np

from sooner.grid import Grid
from sooner.streets import OccupancyGraph


def blocks(side: int = 20, apart: int = 5, cell_m: float = 5.0) -> OccupancyGraph:
    """Streets every `apart` cells each way, with nodes off the centres of their cells."""
    grid = Grid((side, side), "square8", cell_m)
    cells = [(row, col) for row in range(side) for col in range(side) if row % apart == 2 or col % apart == 2]
    number = {cell: n for n, cell in enumerate(cells)}
    edges = [
        (number[row, col], number[row + down, col + right])
        for row, col in cells
        for down, right in ((0, 1), (1, 0))
        if (row + down, col + right) in number
    ]
    indices = np.array([grid.index(cell) for cell in cells])
    beside = np.random.default_rng(0).uniform(-0.4, 0.4, (len(cells), 2)) * cell_m
    return OccupancyGraph.of(grid, indices, edges, grid.centres_m[indices] + beside)
