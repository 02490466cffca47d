"""Compiled ways over square cells: plain arrays in, plain arrays out.

passable : (N,) bool, row by row; width : int columns. Places are (row, column) floats: a cell's centre is whole and its
square reaches half a cell to every side.
"""

import math

import numpy as np
from numba import njit

ROOT2 = math.sqrt(2.0)
TOUCH = 1e-9  # cells; nearer than this is touching, and shorter by less than this is as long


@njit(cache=True, nogil=True)
def spread(passable, width, sources, goal):
    """Shortest octile ways from the nearest source to every cell, by buckets one cell wide.

    sources : (S,) int64 passable cells; goal : int, -1 for all cells, else stop when it is settled
    returns straight, diagonal, owner : (N,) int32: steps of either kind, the first of the nearest sources; -1 where
    there is no way. A bucket is no wider than the shortest step, so that its cells are final when it is reached.
    """
    n_cells = passable.shape[0]
    straight = np.full(n_cells, -1, np.int32)
    diagonal = np.zeros(n_cells, np.int32)
    owner = np.full(n_cells, -1, np.int32)
    level_of = np.full(n_cells, -1, np.int32)
    waiting = np.empty((3, n_cells), np.int32)
    sizes = np.zeros(3, np.int64)
    for k in range(sources.shape[0]):
        cell = sources[k]
        if straight[cell] < 0:
            straight[cell] = 0
            owner[cell] = k
            level_of[cell] = 0
            waiting[0, sizes[0]] = cell
            sizes[0] += 1
    height = n_cells // width
    level = 0
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
                    if straight[other] >= 0:
                        if s == straight[other] and d == diagonal[other]:
                            owner[other] = min(owner[other], owner[cell])
                            continue
                        if length >= straight[other] + diagonal[other] * ROOT2:
                            continue
                    straight[other], diagonal[other], owner[other] = s, d, owner[cell]
                    at = int(length)
                    if level_of[other] != at:
                        level_of[other] = at
                        waiting[at % 3, sizes[at % 3]] = other
                        sizes[at % 3] += 1
        sizes[level % 3] = 0
        if goal >= 0 and straight[goal] >= 0 and level_of[goal] <= level:
            break
        level += 1
    return straight, diagonal, owner


@njit(cache=True, nogil=True)
def trace(passable, width, straight, diagonal, goal):
    """The shortest way from its source to `goal`, cells (n,) int64; of equals the one that goes on straight longest."""
    height = passable.shape[0] // width
    path = np.empty(straight[goal] + diagonal[goal] + 1, np.int64)
    cell, before_down, before_right = goal, 0, 0
    for k in range(path.shape[0] - 1, 0, -1):
        path[k] = cell
        row, col = cell // width, cell % width
        step_down, step_right = 0, 0
        for slot in range(10):  # 0: as before; then all directions, straight ones (odd slots) first
            turn = (slot - 1) * 2 + 1 if slot < 5 else (slot - 5) * 2
            down, right = (before_down, before_right) if slot == 0 else (turn // 3 - 1, turn % 3 - 1)
            if (down == 0 and right == 0) or not (0 <= row + down < height and 0 <= col + right < width):
                continue
            other = cell + down * width + right
            slant = 1 if down != 0 and right != 0 else 0
            if straight[other] < 0 or straight[other] + 1 - slant != straight[cell]:
                continue
            if diagonal[other] + slant != diagonal[cell]:
                continue
            if slant and not (passable[cell + down * width] and passable[cell + right]):
                continue
            step_down, step_right = down, right
            break
        before_down, before_right = step_down, step_right
        cell = cell + step_down * width + step_right
    path[0] = cell
    return path


@njit(cache=True, nogil=True)
def turning(points, limit):
    """Which waypoints (n, 2) a way keeps, (n,) bool: its ends, and where it turns by more than so many radians."""
    kept = np.ones(points.shape[0], np.bool_)
    last = 0
    for k in range(1, points.shape[0] - 1):
        east, north = points[k, 0] - points[last, 0], points[k, 1] - points[last, 1]
        to_east, to_north = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        turn = math.atan2(abs(east * to_north - north * to_east), east * to_east + north * to_north)
        kept[k] = turn > limit
        if kept[k]:
            last = k
    return kept


@njit(cache=True, nogil=True)
def clear(passable, width, row_a, col_a, row_b, col_b):
    """Whether a segment within the map touches the closed square of no obstacle.

    Row by row: the columns that the segment touches while it is within TOUCH of the row's squares.
    """
    height = passable.shape[0] // width
    fall = row_b - row_a
    first = max(math.floor(min(row_a, row_b) + 0.5 - TOUCH), 0)
    last = min(math.floor(max(row_a, row_b) + 0.5 + TOUCH), height - 1)
    for row in range(first, last + 1):
        enter, leave = 0.0, 1.0
        if abs(fall) > TOUCH:
            enter = (row - 0.5 - TOUCH - row_a) / fall
            leave = (row + 0.5 + TOUCH - row_a) / fall
            if enter > leave:
                enter, leave = leave, enter
            enter, leave = max(enter, 0.0), min(leave, 1.0)
            if enter > leave:
                continue
        here, there = col_a + enter * (col_b - col_a), col_a + leave * (col_b - col_a)
        west = max(math.floor(min(here, there) + 0.5 - TOUCH), 0)
        east = min(math.floor(max(here, there) + 0.5 + TOUCH), width - 1)
        for col in range(west, east + 1):
            if not passable[row * width + col]:
                return False
    return True


@njit(cache=True, nogil=True)
def shortcut(passable, width, places):
    """Shortest way from the first place to the last that sees from each to the next; indices (m,) int64 of places.

    places : (n, 2) float. Of ways equally long, the one with fewest places.
    """
    n = places.shape[0]
    best = np.full(n, np.inf)
    hops = np.zeros(n, np.int64)
    came = np.zeros(n, np.int64)
    best[0] = 0.0
    for j in range(1, n):
        for i in range(j):
            length = best[i] + math.hypot(places[i, 0] - places[j, 0], places[i, 1] - places[j, 1])
            if not (length < best[j] - TOUCH or (length <= best[j] + 1e-3 * TOUCH and hops[i] + 1 < hops[j])):
                continue
            if clear(passable, width, places[i, 0], places[i, 1], places[j, 0], places[j, 1]):
                best[j], hops[j], came[j] = length, hops[i] + 1, i
    kept = np.empty(hops[n - 1] + 1, np.int64)
    at = n - 1
    for k in range(kept.shape[0] - 1, -1, -1):
        kept[k] = at
        at = came[at]
    return kept


@njit(cache=True, nogil=True)
def slide(passable, width, places):
    """Move inner places (n, 2) by one cell at a time while that shortens the way and keeps it clear, in place."""
    moved = True
    while moved:
        moved = False
        for k in range(1, places.shape[0] - 1):
            row_a, col_a, row_b, col_b = places[k - 1, 0], places[k - 1, 1], places[k + 1, 0], places[k + 1, 1]
            row, col = places[k, 0], places[k, 1]
            least = math.hypot(row - row_a, col - col_a) + math.hypot(row_b - row, col_b - col) - TOUCH
            for down in range(-1, 2):
                for right in range(-1, 2):
                    r, c = row + down, col + right
                    length = math.hypot(r - row_a, c - col_a) + math.hypot(row_b - r, col_b - c)
                    if length >= least:
                        continue
                    if clear(passable, width, row_a, col_a, r, c) and clear(passable, width, r, c, row_b, col_b):
                        least = length - TOUCH
                        places[k, 0], places[k, 1] = r, c
                        moved = True
