"""Compiled loops over regions of cells: plain arrays in, plain arrays out."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def peaks(neighbours, surface):
    """Label every connected plateau of equal height that has no higher neighbour: (N,) int32, 0 elsewhere.

    neighbours : (N, D) int32, -1 where there is none; surface : (N,) float; ground at zero or below is no peak.
    """
    n_cells, n_slots = neighbours.shape
    labels = np.zeros(n_cells, np.int32)
    seen = np.zeros(n_cells, np.bool_)
    plateau = np.empty(n_cells, np.int32)
    found = 0
    for first in range(n_cells):
        if seen[first] or surface[first] <= 0:
            continue
        seen[first] = True
        plateau[0] = first
        head, tail, highest = 0, 1, True
        while head < tail:
            cell = plateau[head]
            head += 1
            for slot in range(n_slots):
                other = neighbours[cell, slot]
                if other < 0:
                    continue
                if surface[other] > surface[cell]:
                    highest = False
                elif surface[other] == surface[cell] and not seen[other]:
                    seen[other] = True
                    plateau[tail] = other
                    tail += 1
        if highest:
            found += 1
            for n in range(tail):
                labels[plateau[n]] = found
    return labels
