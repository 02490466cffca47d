"""Loops over millions of cells for `atoms`."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def add_numbers(starts, cells, numbers, sums):
    """Add each action's number to the cells that it looks at, once for each look; modulo 2^64."""
    for action in range(len(starts) - 1):
        for entry in range(starts[action], starts[action + 1]):
            sums[cells[entry]] += numbers[action]


@njit(cache=True)
def add_rows(groups, rows, table):
    """Add each row to that of its group."""
    for row in range(rows.shape[0]):
        for column in range(rows.shape[1]):
            table[groups[row], column] += rows[row, column]
