"""Streets go on: where nodes are likely that nobody has seen, as learnt from many generated towns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from math import atan2, exp, hypot, pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid

__all__ = ["StreetContinuation", "StreetModel"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
CLASSES = (1.6, 2.6, 4.1, 6.1)  # cells; what is further off is of the fifth class of distance
SCALE = 5.0  # cells in which a line loses two thirds of its worth
FLOOR = 0.01


@dataclass(frozen=True, eq=False)
class StreetModel:
    """Log-odds of a node from the marks of a cell: one layer of hidden units, fitted to generated streets.

    log p / (1 - p) = bias + sum_h output_h max(sum_k marks_k hidden_kh + offsets_h, 0)

    Parameters
    ----------
    hidden : (37, n) float
    offsets, output : (n,) float
    bias : float

    Notes
    -----
    `street_continuation.csv` is what `benchmarks/simulation/learn_streets.py` writes: a column for each unit, with its
    weights of the marks, its offset and its output; and the bias, in a last line of its own.
    """

    hidden: Floats
    offsets: Floats
    output: Floats
    bias: float

    @classmethod
    def read(cls, path: Path) -> StreetModel:
        """From a file of comma-separated numbers."""
        *rows, last = path.read_text(encoding="ascii").split()
        table = np.array([row.split(",") for row in rows], np.float64)
        return cls(np.ascontiguousarray(table[:-2]), table[-2].copy(), table[-1].copy(), float(last))

    def write(self, path: Path) -> None:
        """To such a file, with five digits."""
        rows = np.vstack([self.hidden, self.offsets, self.output])
        lines = [",".join(f"{number:.5g}" for number in row) for row in rows]
        path.write_text("\n".join([*lines, f"{self.bias:.5g}", ""]), encoding="ascii")


@cache
def _shipped() -> StreetModel:
    return StreetModel.read(Path(__file__).with_name("street_continuation.csv"))


@dataclass(frozen=True, eq=False)
class StreetContinuation:
    """Expects nodes where streets that were seen go on, on one grid.

    Every detected node near unseen ground looks at the unseen cells around it and tells each how many nodes stand
    behind it in line: a street that heads for the cell has many, one that passes by few; a cell seen to be void ends
    it. Besides, a cell knows how much around it was seen, and how many nodes more than usual are there. What all this
    is worth was learnt (see `StreetModel`). What was believed of unseen cells before does not count.

    Parameters
    ----------
    grid : Grid                     square cells
    model : StreetModel or None     None: as learnt from generated gridirons, suburbs and parks in cells of 5 m

    Raises
    ------
    InvalidProblemError             if the cells are hexagons

    Examples
    --------
    >>> grid, street = Grid((9, 30)), np.zeros((9, 30), bool)
    >>> explored = np.repeat([[True] * 15 + [False] * 15], 9, axis=0)
    >>> street[4] = True
    >>> void = np.where(street, 0.0, 1.0).ravel()
    >>> expected = StreetContinuation(grid).expected_void(void, explored.ravel(), (street & explored).ravel())
    >>> expected = expected.reshape(9, 30)
    >>> bool(expected[4, 15:17].max() < 0.5 < expected[2, 15:17].min())
    True
    """

    grid: Grid
    model: StreetModel | None = None

    def __post_init__(self) -> None:
        if self.grid.connectivity == "hex":
            raise InvalidProblemError("hexagonal cells came; expected square ones")

    def expected_void(self, void: Floats, explored: Bools, nodes: Bools, out: Floats | None = None) -> Floats:
        """(M,) void probabilities, of explored cells as they are and of others as streets go on.

        Parameters
        ----------
        void : (M,) float; explored, nodes : (M,) bool      seen, and with a detected node
        out : (M,) float                                    where to write; None: a new array
        """
        from sooner.belief._street_continuation_kernels import expect

        told = np.empty_like(void) if out is None else out
        told[:] = void
        if not explored.all():
            model = _shipped() if self.model is None else self.model
            marks = self.marks(void, explored, nodes)
            expect(marks, explored, model.hidden, model.offsets, model.output, model.bias, FLOOR, told)
        return told

    def marks(self, void: Floats, explored: Bools, nodes: Bools) -> Floats:
        """(M, 37) float: what the model goes by. Zeros for explored cells; room that the next call writes again.

        Columns
        -------
        0-24    nodes that look at the cell, by class of distance and, within, by how many of five line up behind
        25-27   the strongest line, the next from another side, and the weaker of the best two that face each other
        28-30   share explored in squares of 3, 7 and 13 cells; 31-33 nodes there, more than usual
        34-36   nodes for each explored cell; share explored of the map; how near its edge
        """
        from sooner.belief._street_continuation_kernels import mark

        height, width = self.grid.shape
        mark(void, explored, nodes, height, width, *self._sights, *self._room)
        return self._room[-1]

    @cached_property
    def _sights(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Floats]:
        return _sight_lines(self.grid.shape[1])

    @cached_property
    def _room(self) -> tuple[Floats, Bools, Floats, Floats, Floats]:
        from sooner.belief._street_continuation_kernels import MARKS, REACH, SECTORS

        height, width = self.grid.shape
        frame = (height + 2 * REACH) * (width + 2 * REACH)
        sums, cells = np.empty((2, height + 1, width + 1)), height * width
        return np.empty(frame), np.empty(frame, bool), sums, np.empty((cells, SECTORS)), np.empty((cells, MARKS))


def _sight_lines(width: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Floats]:
    """From a node to every cell within reach: where it is, what lies between and behind, what a line is worth there."""
    from sooner.belief._street_continuation_kernels import BEHIND, REACH, SECTORS

    across = width + 2 * REACH
    sights, between, behind, decays = [], [], [], []
    for down in range(-REACH, REACH + 1):
        for right in range(-REACH, REACH + 1):
            far = hypot(down, right)
            if not 0.0 < far <= REACH:
                continue
            steps = round(far)
            inner = [_number(down * n / steps, right * n / steps, across) for n in range(1, steps)]
            sector = int((atan2(down, right) + pi) / (2.0 * pi) * SECTORS) % SECTORS
            distance = int(np.searchsorted(CLASSES, far))
            sights.append((down, down * across + right, len(inner), distance, sector, right))
            between.append(inner + [0] * (REACH - 1 - len(inner)))
            behind.append([_number(-down * n / far, -right * n / far, across) for n in range(1, BEHIND + 1)])
            decays.append(exp(-far / SCALE))
    return np.array(sights), np.array(between), np.array(behind), np.array(decays)


def _number(down: float, right: float, across: int) -> int:
    """Of the cell nearest to there, in a frame so many cells across."""
    return round(down) * across + round(right)
