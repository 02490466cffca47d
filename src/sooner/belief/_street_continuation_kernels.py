"""Compiled marks of unseen cells: detected nodes that line up with them, and how much is seen and built around them.

Arrays over cells stand in a frame as wide as the longest sight line, so that no loop asks where the map ends.
"""

import math

import numpy as np
from numba import njit

REACH = 8  # cells that a street is followed beyond what was seen
BEHIND = 5  # cells of it that are looked at behind a node
NEAR = 2  # cells within which something unseen must lie
SECTORS = 16
COUNTED = 25  # marks that count nodes: five classes of distance times five of how many line up
MARKS = 37
MOST = 4.0  # that a count counts


@njit(cache=True, nogil=True)
def framed(void, explored, nodes, height, width, built, seen):
    """P(node) of explored cells, 0 of others, and what is explored, in frames; beyond the map all is seen and void.

    Returns nodes for each explored cell, as if a quarter of 64 more cells held one.
    """
    across = width + 2 * REACH
    built[:], seen[:] = 0.0, True
    n_seen, n_built = 64.0, 16.0
    for row in range(height):
        for col in range(width):
            cell, i = row * width + col, (row + REACH) * across + REACH + col
            seen[i] = explored[cell]
            if explored[cell]:
                built[i] = 1.0 if nodes[cell] else 1.0 - void[cell]
                n_seen += 1.0
                n_built += built[i]
    return n_built / n_seen


@njit(cache=True, nogil=True)
def line_up(built, seen, height, width, sights, between, behind, decays, marks, strengths):
    """Every node near unseen ground tells all unseen cells in its sight how many nodes stand behind it in line.

    sights : (K, 6) int64             to a cell: rows down, both as one number in the frame, cells between, class of
                                      distance, sector, columns right
    between, behind : (K, 7), (K, BEHIND) int64    what lies between and behind, as numbers in the frame
    decays : (K,)                     what a line is worth at that distance
    marks : (M, MARKS), strengths : (M, SECTORS)   written
    """
    across = width + 2 * REACH
    for row in range(height):
        for col in range(width):
            node = (row + REACH) * across + REACH + col
            if built[node] < 0.5 or not _is_near_unseen(seen, node, across):
                continue
            for k in range(sights.shape[0]):
                unseen = node + sights[k, 1]
                if seen[unseen] or _is_hidden(built, seen, node, between[k], sights[k, 2]):
                    continue
                total = 0.0
                for n in range(BEHIND):
                    total += built[node + behind[k, n]]
                cell = (row + sights[k, 0]) * width + col + sights[k, 5]
                marks[cell, sights[k, 3] * 5 + min(int(total), 4)] += 1.0
                sector = sights[k, 4]
                strengths[cell, sector] = max(strengths[cell, sector], total * decays[k])


@njit(cache=True, nogil=True, inline="always")
def _is_near_unseen(seen, node, across):
    for down in range(-NEAR, NEAR + 1):
        for right in range(-NEAR, NEAR + 1):
            if not seen[node + down * across + right]:
                return True
    return False


@njit(cache=True, nogil=True, inline="always")
def _is_hidden(built, seen, node, between, n):
    """Whether a cell that was seen to hold no node ends the street before it comes there."""
    hidden = False
    for k in range(n):
        hidden = hidden or (seen[node + between[k]] and built[node + between[k]] < 0.5)
    return hidden


@njit(cache=True, nogil=True)
def sums(values, height, width, out):
    """(height + 1, width + 1) sums of a framed array over all cells above and to the left."""
    across = width + 2 * REACH
    out[0], out[:, 0] = 0.0, 0.0
    for row in range(height):
        for col in range(width):
            value = values[(row + REACH) * across + REACH + col]
            out[row + 1, col + 1] = out[row, col + 1] + out[row + 1, col] - out[row, col] + value


@njit(cache=True, nogil=True)
def mark(void, explored, nodes, height, width, sights, between, behind, decays, built, seen, room, strengths, marks):
    """Write (M, MARKS) marks of cells not explored, zeros elsewhere; the other arrays but the first three are room."""
    share = framed(void, explored, nodes, height, width, built, seen)
    marks[:], strengths[:] = 0.0, 0.0
    line_up(built, seen, height, width, sights, between, behind, decays, marks, strengths)
    sums(built, height, width, room[0])
    sums(seen, height, width, room[1])
    known = room[1, height, width] / (height * width)
    for row in range(height):
        for col in range(width):
            cell = row * width + col
            if explored[cell]:
                continue
            told = marks[cell]
            for k in range(COUNTED):
                told[k] = min(told[k], MOST)
            told[COUNTED], told[COUNTED + 1], told[COUNTED + 2] = _strongest(strengths[cell])
            for n in range(3):
                side = (1, 3, 6)[n]
                top, bottom = max(row - side, 0), min(row + side + 1, height)
                left, right = max(col - side, 0), min(col + side + 1, width)
                here = room[:, bottom, right] - room[:, top, right] - room[:, bottom, left] + room[:, top, left]
                told[COUNTED + 3 + n] = here[1] / (2 * side + 1) ** 2
                told[COUNTED + 6 + n] = (here[0] - share * here[1]) / (2 * side + 1)
            told[COUNTED + 9], told[COUNTED + 10] = share, known
            told[COUNTED + 11] = 0.2 * min(min(row, height - 1 - row), min(col, width - 1 - col), 5)


@njit(cache=True, nogil=True, inline="always")
def _strongest(strengths):
    """Of lines by sector the strongest, the next, and the weaker of the strongest two that face each other."""
    best, second, facing = 0.0, 0.0, 0.0
    for k in range(SECTORS):
        value = strengths[k]
        if value > best:
            best, second = value, best
        elif value > second:
            second = value
        for turn in range(-1, 2):
            facing = max(facing, min(value, strengths[(k + SECTORS // 2 + turn) % SECTORS]))
    return best, second, facing


@njit(cache=True, nogil=True)
def expect(marks, explored, hidden, offsets, output, bias, floor, void):
    """void = 1 / (1 + exp(bias + sum_h output_h max(sum_k marks_k hidden_kh + offset_h, 0))) of cells not explored.

    hidden : (MARKS, n), offsets, output : (n,); void : (M,), written between floor and 1 - floor
    """
    n = offsets.shape[0]
    sums_of = np.empty(n)
    for cell in range(void.shape[0]):
        if explored[cell]:
            continue
        for h in range(n):
            sums_of[h] = offsets[h]
        for k in range(marks.shape[1]):
            value = marks[cell, k]
            if value != 0.0:
                for h in range(n):
                    sums_of[h] += value * hidden[k, h]
        total = bias
        for h in range(n):
            total += output[h] * max(sums_of[h], 0.0)
        void[cell] = min(max(1.0 / (1.0 + math.exp(total)), floor), 1.0 - floor)
