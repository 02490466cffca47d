"""A tessellation of the ground: square cells with 4 or 8 neighbours, or hexagons with 6."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError

__all__ = ["Connectivity", "Grid"]

Connectivity = Literal["square4", "square8", "hex"]

# (row, column) steps by direction; row 0 is north. North, east, south, west come first everywhere they exist.
_SQUARE4 = ((-1, 0), (0, 1), (1, 0), (0, -1))
_SQUARE8 = (*_SQUARE4, (-1, 1), (1, 1), (1, -1), (-1, -1))
# Hexagons with a point to the north, odd rows shifted half a cell to the east.
_HEX_EVEN = ((0, 1), (0, -1), (-1, 0), (-1, -1), (1, 0), (1, -1))
_HEX_ODD = ((0, 1), (0, -1), (-1, 1), (-1, 0), (1, 1), (1, 0))

MAX_CELLS = 2**27  # cell numbers are int32 and a neighbour table of this size is already 2 GB


@dataclass(frozen=True, eq=False)
class Grid:
    """Cells, who is next to whom, and how far apart they are.

    Cell `(row, col)` has the number `row * W + col`; row 0 is north. Obstacles are cells that cannot be
    entered. A diagonal step on a `square8` grid must not cut the corner of an obstacle.

    Parameters
    ----------
    shape : (int, int)             H rows and W columns
    connectivity : str             "square4", "square8" or "hex" (odd rows shifted half a cell east)
    cell_m : float                 metres between the centres of neighbouring cells
    obstacles : (H, W) bool        cells that cannot be entered; None where there are none

    Raises
    ------
    InvalidProblemError            if the shape, the cell size or the obstacles make no sense

    Examples
    --------
    >>> grid = Grid((3, 4))
    >>> grid.index((1, 2)), grid.cell(6)
    (6, (1, 2))
    >>> grid.distances_from(0).reshape(3, 4)
    array([[0, 1, 2, 3],
           [1, 2, 3, 4],
           [2, 3, 4, 5]], dtype=int32)
    """

    shape: tuple[int, int]
    connectivity: Connectivity = "square4"
    cell_m: float = 1.0
    obstacles: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        rows, cols = self.shape
        if rows < 1 or cols < 1 or rows * cols > MAX_CELLS:
            raise InvalidProblemError(
                f"a grid of {rows} x {cols} cells came; expected at least 1 x 1 and at most {MAX_CELLS} cells"
            )
        if self.connectivity not in ("square4", "square8", "hex"):
            raise InvalidProblemError(
                f"connectivity {self.connectivity!r} came; expected 'square4', 'square8' or 'hex'"
            )
        if not (np.isfinite(self.cell_m) and self.cell_m > 0):
            raise InvalidProblemError(f"a cell size of {self.cell_m} m came; expected a positive number")
        if self.obstacles is not None:
            if self.obstacles.shape != self.shape:
                raise InvalidProblemError(f"obstacles of shape {self.obstacles.shape} came; the grid has {self.shape}")
            object.__setattr__(self, "obstacles", np.ascontiguousarray(self.obstacles, bool))

    @property
    def n_cells(self) -> int:
        """Number of cells, obstacles included."""
        return self.shape[0] * self.shape[1]

    def index(self, cell: tuple[int, int]) -> int:
        """Number of the cell at (row, col)."""
        row, col = cell
        if not (0 <= row < self.shape[0] and 0 <= col < self.shape[1]):
            raise InvalidProblemError(
                f"cell [{row}, {col}] came; the map has rows 0 to {self.shape[0] - 1} "
                f"and columns 0 to {self.shape[1] - 1}"
            )
        return int(row) * self.shape[1] + int(col)

    def cell(self, index: int) -> tuple[int, int]:
        """(row, col) of a cell number."""
        return int(index) // self.shape[1], int(index) % self.shape[1]

    @cached_property
    def passable(self) -> NDArray[np.bool_]:
        """(N,) bool: cells that can be entered."""
        if self.obstacles is None:
            return np.ones(self.n_cells, bool)
        return ~self.obstacles.ravel()

    @cached_property
    def neighbours(self) -> NDArray[np.int32]:
        """(N, D) int32: the cell reached by each direction, -1 off the map or where an obstacle stands."""
        return _neighbours(self)

    @cached_property
    def step_coordinates(self) -> NDArray[np.int32]:
        """(N, 2) int32: row and column; on hexagons axial ones. Steps between cells without obstacles follow from them.

        Odd rows of hexagons lie half a cell to the east.
        """
        rows, cols = np.divmod(np.arange(self.n_cells, dtype=np.int32), np.int32(self.shape[1]))
        if self.connectivity == "hex":
            cols = cols - rows // 2
        return np.ascontiguousarray(np.column_stack([rows, cols]), np.int32)

    def distances_from(self, index: int) -> NDArray[np.int32]:
        """(N,) int32: fewest steps from a cell to every cell, around obstacles; -1 where there is no way."""
        from sooner.grid._kernels import distances

        found: NDArray[np.int32] = distances(self.neighbours, index)
        return found

    @cached_property
    def centres_m(self) -> NDArray[np.float64]:
        """(N, 2) float: metres east and north of the south-west cell's centre."""
        rows, cols = np.divmod(np.arange(self.n_cells), self.shape[1])
        if self.connectivity == "hex":
            east, north = cols + 0.5 * (rows % 2), (self.shape[0] - 1 - rows) * np.sqrt(0.75)
        else:
            east, north = cols.astype(float), (self.shape[0] - 1 - rows).astype(float)
        return np.column_stack([east, north]) * self.cell_m


def _neighbours(grid: Grid) -> NDArray[np.int32]:
    height, width = grid.shape
    passable = grid.passable.reshape(grid.shape)
    if grid.connectivity == "hex":
        even = (np.arange(height) % 2 == 0)[:, None]
        slots = [
            np.where(even, _shifted(passable, *a), _shifted(passable, *b))
            for a, b in zip(_HEX_EVEN, _HEX_ODD, strict=True)
        ]
    else:
        steps = _SQUARE4 if grid.connectivity == "square4" else _SQUARE8
        slots = [_shifted(passable, *step) for step in steps]
        for slot, (down, right) in enumerate(steps):
            if down and right and grid.obstacles is not None:
                beside = (_shifted(passable, down, 0) >= 0) & (_shifted(passable, 0, right) >= 0)
                slots[slot] = np.where(beside, slots[slot], -1)
    table = np.stack(slots, axis=-1).reshape(height * width, len(slots))
    table[~grid.passable] = -1
    return np.ascontiguousarray(table, np.int32)


def _shifted(passable: NDArray[np.bool_], down: int, right: int) -> NDArray[np.int32]:
    """(H, W): number of the cell `down` rows and `right` columns away, -1 where it cannot be entered."""
    height, width = passable.shape
    numbers = np.where(passable, np.arange(height * width, dtype=np.int32).reshape(height, width), -1)
    out = np.full((height, width), -1, np.int32)
    rows, cols = slice(max(down, 0), height + min(down, 0)), slice(max(right, 0), width + min(right, 0))
    to_rows, to_cols = (
        slice(max(-down, 0), height - max(down, 0)),
        slice(max(-right, 0), width - max(right, 0)),
    )
    out[to_rows, to_cols] = numbers[rows, cols]
    return out
