"""Loops over millions of cells for `voronoi`: plain arrays in, plain arrays out.

passable : (N,) bool, row by row; width : int columns; lengths are in cells, octile ways as `grid.geodesic` counts them.
"""

import math

import numpy as np
from numba import njit

ROOT2 = math.sqrt(2.0)


@njit(cache=True, nogil=True)
def farthest(passable, apart, density):
    """The free cell where distance^2 times density is largest, the first of them; cells out of reach before all."""
    best, most = -1, -1.0
    for cell in range(len(passable)):
        if passable[cell]:
            far = apart[cell] * apart[cell] * density[cell]
            if far > most:
                best, most = cell, far
    return best


@njit(cache=True, nogil=True)
def approach(passable, width, source, apart, straight, diagonal, level_of, waiting, touched):
    """Lower `apart` (N,), the distance of each cell from the nearest seed, by one seed more.

    As `grid`'s `spread`, but no farther than the new seed is nearer than all before: what lies behind a cell that has
    a nearer one has a nearer one too. straight, diagonal, level_of (N,) int32, all -1 and left so, waiting (3, N) and
    touched (N,) int32 are scratch.
    """
    height = passable.shape[0] // width
    sizes = np.zeros(3, np.int64)
    straight[source], diagonal[source], level_of[source], apart[source] = 0, 0, 0, 0.0
    waiting[0, 0], sizes[0], touched[0] = source, 1, source
    count, level = 1, 0
    while sizes[0] + sizes[1] + sizes[2] > 0:
        for q in range(sizes[level % 3]):
            cell = waiting[level % 3, q]
            if level_of[cell] != level:
                continue
            row, col = cell // width, cell % width
            for down in range(-1, 2):
                for right in range(-1, 2):
                    if not (0 <= row + down < height and 0 <= col + right < width) or (down == 0 and right == 0):
                        continue
                    other = cell + down * width + right
                    if not passable[other]:
                        continue
                    slant = 1 if down != 0 and right != 0 else 0
                    if slant and not (passable[cell + down * width] and passable[cell + right]):
                        continue
                    s, d = straight[cell] + 1 - slant, diagonal[cell] + slant
                    length = s + d * ROOT2
                    if length >= apart[other]:
                        continue
                    if straight[other] < 0:
                        touched[count] = other
                        count += 1
                    straight[other], diagonal[other], apart[other] = s, d, length
                    at = int(length)
                    if level_of[other] != at:
                        level_of[other] = at
                        waiting[at % 3, sizes[at % 3]] = other
                        sizes[at % 3] += 1
        sizes[level % 3] = 0
        level += 1
    for n in range(count):
        straight[touched[n]], diagonal[touched[n]], level_of[touched[n]] = -1, -1, -1


@njit(cache=True, nogil=True)
def middles(owner, width, density, count):
    """Of each seed's cells the one nearest to their weighted mean, the first of them: (count,) int64."""
    sums = np.zeros((3, count))
    for cell in range(len(owner)):
        own = owner[cell]
        if own >= 0:
            sums[0, own] += density[cell]
            sums[1, own] += density[cell] * (cell // width)
            sums[2, own] += density[cell] * (cell % width)
    found, least = np.full(count, -1, np.int64), np.full(count, np.inf)
    for cell in range(len(owner)):
        own = owner[cell]
        if own >= 0:
            row, col = cell // width - sums[1, own] / sums[0, own], cell % width - sums[2, own] / sums[0, own]
            apart = np.rint((row * row + col * col) * 1e9) / 1e9  # rounded, so that ties are ties
            if apart < least[own]:
                found[own], least[own] = cell, apart
    return found
