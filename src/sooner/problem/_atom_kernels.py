"""Loops over millions of cells for `atoms`: plain arrays in, plain arrays out."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def add_numbers(starts, cells, numbers, sums):
    """Add each action's number to the cells that it looks at, once for each look; modulo 2^64."""
    for action in range(len(starts) - 1):
        for entry in range(starts[action], starts[action + 1]):
            sums[cells[entry]] += numbers[action]


@njit(cache=True, nogil=True)
def _slot(keys, key):
    """Where a number stands in a table, or where it should; the table is half empty at least, and zero is empty."""
    last = np.uint64(len(keys) - 1)
    slot = key & last
    while keys[slot] != key and keys[slot] != np.uint64(0):
        slot = (slot + np.uint64(1)) & last
    return slot


@njit(cache=True, nogil=True)
def grouped(sums, of_cell):
    """Group cells of equal sums, numbered as they first come; those of sum zero are in none, -1.

    sums : (N,) uint64, numbers as good as random; of_cell : (N,) int32, filled
    returns the sums of the groups (K,) uint64, and their sizes (K,) int64. Neighbours mostly are of one group, and
    others are found by hashing, so that no cell is sorted.
    """
    keys, group = np.zeros(1 << 10, np.uint64), np.zeros(1 << 10, np.int32)
    found, sizes = np.zeros(1 << 9, np.uint64), np.zeros(1 << 9, np.int64)
    count, before, here = 0, np.uint64(0), -1
    for cell in range(len(sums)):
        key = sums[cell]
        if key != before:
            before, here = key, -1
            if key != np.uint64(0):
                slot = _slot(keys, key)
                if keys[slot] != key:
                    if count == len(found):
                        keys, group = np.zeros(2 * len(keys), np.uint64), np.zeros(2 * len(group), np.int32)
                        found = np.concatenate((found, np.zeros(count, np.uint64)))
                        sizes = np.concatenate((sizes, np.zeros(count, np.int64)))
                        for each in range(count):
                            slot = _slot(keys, found[each])
                            keys[slot], group[slot] = found[each], each
                        slot = _slot(keys, key)
                    keys[slot], group[slot], found[count] = key, count, key
                    count += 1
                here = group[slot]
        of_cell[cell] = here
        if here >= 0:
            sizes[here] += 1
    return found[:count].copy(), sizes[:count].copy()


@njit(cache=True, nogil=True)
def renumber(of_cell, number):
    """Give each cell's group its new number."""
    for cell in range(len(of_cell)):
        if of_cell[cell] >= 0:
            of_cell[cell] = number[of_cell[cell]]


@njit(cache=True, nogil=True)
def cover(cells, seconds, back_s, of_cell, place):
    """What one action covers, each atom once for each look that the action takes there.

    cells (M,) ascending, seconds (M,), back_s (M,) : its entries; place (K,) int64 : scratch, all -1, and left so
    returns atoms (C,) and the looks before (C,) int64, how many cells are looked at (C,) int64, and the sums of their
    seconds (C,) and back_s (C,) float.
    """
    room = 64
    whole, real = np.zeros((4, room), np.int64), np.zeros((2, room))  # atom, before, cells, next slot of the atom
    count, before, last = 0, 0, -1
    for entry in range(len(cells)):
        cell = cells[entry]
        before = before + 1 if cell == last else 0
        last, atom = cell, of_cell[cell]
        slot = place[atom]
        while slot >= 0 and whole[1, slot] != before:
            slot = whole[3, slot]
        if slot < 0:
            if count == room:
                whole = np.concatenate((whole, np.zeros((4, room), np.int64)), axis=1)
                real = np.concatenate((real, np.zeros((2, room))), axis=1)
                room *= 2
            slot = count
            whole[0, slot], whole[1, slot], whole[3, slot] = atom, before, place[atom]
            place[atom] = slot
            count += 1
        whole[2, slot] += 1
        real[0, slot] += seconds[entry]
        real[1, slot] += back_s[entry]
    for slot in range(count):
        place[whole[0, slot]] = -1
    return whole[0, :count], whole[1, :count], whole[2, :count], real[0, :count], real[1, :count]


@njit(cache=True, nogil=True)
def add_rows(groups, rows, table):
    """Add each row to that of its group."""
    for row in range(rows.shape[0]):
        for column in range(rows.shape[1]):
            table[groups[row], column] += rows[row, column]
