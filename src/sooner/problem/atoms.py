"""Atoms: cells that the same actions look at, so that the cost of planning does not grow with the resolution.

Where each action looks at a cell a given number of times, what a plan collects depends only on how often each action
is flown. Cells that the same actions look at as often as one another are then looked at equally often, whatever the
plan, and can be counted together: gain(atom, k) = sum over its cells of gain(cell, k). That is exact, for any gains.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.problem.gains import Gains

__all__ = ["Atoms", "Footprints", "atom_gains", "atoms_of"]

Rows = Callable[[NDArray[np.int64]], NDArray[np.float64]]
"""What the first, second, ... look at each of these cells pays: (n,) int -> (n, L) float."""

CHUNK = 1 << 16  # cells whose gains are in memory at once


@dataclass(frozen=True, eq=False)
class Footprints:
    """Which cells each action looks at, and how long after it began.

    Parameters
    ----------
    starts : (A + 1,) int       action a has the entries starts[a] to starts[a + 1]
    cells : (M,) int32          ascending in each action, each as often as the action looks at it
    seconds : (M,) float32      until the cell is seen, for each of its looks in order
    back_s : (M,) float32       the same where the action is flown the other way
    """

    starts: NDArray[np.int64]
    cells: NDArray[np.int32]
    seconds: NDArray[np.float32]
    back_s: NDArray[np.float32]

    @property
    def n_actions(self) -> int:
        """Number of actions A."""
        return len(self.starts) - 1

    def of(self, action: int) -> NDArray[np.int32]:
        """Cells that an action looks at, each as often as it does."""
        return self.cells[self.starts[action] : self.starts[action + 1]]


@dataclass(frozen=True, eq=False)
class Atoms:
    """Cells in groups that are always looked at together.

    Parameters
    ----------
    of_cell : (N,) int32        atom of each cell, -1 where no action looks
    sizes : (K,) int            cells in each atom
    starts : (A + 1,) int       action a covers the entries starts[a] to starts[a + 1]
    covered : (C,) int          atoms, in the order in which they are seen, each as often as it is
    before : (C,) int           looks at that atom that the same action has taken before
    seconds : (C,) float        after the action began, until the mean cell of the atom is seen
    back_s : (C,) float         the same where the action is flown the other way
    """

    of_cell: NDArray[np.int32]
    sizes: NDArray[np.int64]
    starts: NDArray[np.int64]
    covered: NDArray[np.int64]
    before: NDArray[np.int64]
    seconds: NDArray[np.float64]
    back_s: NDArray[np.float64]

    @property
    def n_atoms(self) -> int:
        """Number of atoms K."""
        return len(self.sizes)

    def of(self, action: int) -> NDArray[np.int64]:
        """Atoms that an action covers, each as often as it looks there."""
        return self.covered[self.starts[action] : self.starts[action + 1]]


def atoms_of(footprints: Footprints, n_cells: int) -> Atoms:
    """Group cells by the actions that look at them, and how often each does.

    Every action draws a random number of 53 bits, and those of all looks at a cell are added up: two cells are of one
    atom where the sums agree. That they agree by chance would be seen: an action must then look at only some cells of
    an atom, or more often at some, which is checked.

    Examples
    --------
    >>> entries = np.zeros(5, np.float32)
    >>> footprints = Footprints(np.array([0, 3, 5]), np.array([0, 1, 2, 2, 3], np.int32), entries, entries)
    >>> found = atoms_of(footprints, 5)
    >>> sorted(found.sizes.tolist()), found.of_cell[4], [len(found.of(a)) for a in (0, 1)]
    ([1, 1, 2], np.int32(-1), [2, 2])
    """
    from sooner.problem._atom_kernels import add_numbers, grouped, renumber

    for seed in range(8):
        numbers = np.random.default_rng(seed).integers(1, 2**53, footprints.n_actions, dtype=np.uint64)
        sums = np.zeros(n_cells, np.uint64)
        add_numbers(footprints.starts, footprints.cells, numbers, sums)
        of_cell = np.empty(n_cells, np.int32)
        found, sizes = grouped(sums, of_cell)
        del sums
        order = np.argsort(found)
        renumber(of_cell, np.argsort(order))
        atoms = _covered(footprints, of_cell, sizes[order])
        if atoms is not None:
            return atoms
    raise AssertionError("eight draws of random numbers all collided")


def _covered(footprints: Footprints, of_cell: NDArray[np.int32], sizes: NDArray[np.int64]) -> Atoms | None:
    """What each action covers; None where it covers an atom in part, which only a collision can bring about."""
    from sooner.problem._atom_kernels import cover

    starts, parts, place = [0], [], np.full(len(sizes), -1, np.int64)
    for action in range(footprints.n_actions):
        entries = slice(footprints.starts[action], footprints.starts[action + 1])
        own = footprints.cells[entries], footprints.seconds[entries], footprints.back_s[entries]
        atoms, before, counts, ahead, behind = cover(*own, of_cell, place)
        if (counts != sizes[atoms]).any():
            return None
        ahead, behind = ahead / counts, behind / counts
        order = np.lexsort((before, atoms, ahead))
        parts.append([each[order] for each in (atoms, before, ahead, behind)])
        starts.append(starts[-1] + len(atoms))
    return Atoms(of_cell, sizes, np.array(starts), *map(_joined, zip(*parts, strict=True)))


def _joined(parts: Iterable[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(list(parts))


def atom_gains(atoms: Atoms, rows: Rows) -> Gains:
    """What the k-th look at each atom pays: the sum over its cells, for the first L looks; later ones pay nothing.

    Parameters
    ----------
    rows : callable        gains of cells, asked for some ten thousand of them at a time; L is the same in each answer

    Raises
    ------
    InvalidProblemError    where a gain is negative or rises with the number of looks
    """
    from sooner.problem._atom_kernels import add_rows

    seen = np.flatnonzero(atoms.of_cell >= 0)
    table = np.zeros((atoms.n_atoms, rows(seen[:1]).shape[1]))
    for first in range(0, len(seen), CHUNK):
        cells = seen[first : first + CHUNK]
        add_rows(atoms.of_cell[cells], np.ascontiguousarray(rows(cells), np.float64), table)
    return Gains(np.minimum.accumulate(table, axis=1), np.zeros(atoms.n_atoms))
