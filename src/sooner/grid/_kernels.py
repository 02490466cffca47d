"""Compiled loops over cells: plain arrays in, plain arrays out."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def distances(neighbours, source):
    """Fewest steps from `source` to every cell; -1 where there is no way.

    neighbours : (N, D) int32, -1 where there is none; source : int; returns (N,) int32.
    """
    n_cells, n_slots = neighbours.shape
    steps = np.full(n_cells, -1, np.int32)
    queue = np.empty(n_cells, np.int32)
    steps[source] = 0
    queue[0] = source
    head, tail = 0, 1
    while head < tail:
        cell = queue[head]
        head += 1
        for slot in range(n_slots):
            other = neighbours[cell, slot]
            if other >= 0 and steps[other] < 0:
                steps[other] = steps[cell] + 1
                queue[tail] = other
                tail += 1
    return steps
