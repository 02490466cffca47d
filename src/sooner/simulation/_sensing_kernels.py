"""Compiled looks: every cell in view of every agent gets a reading of its map sensor and one of its target sensor."""

import math

import numpy as np
from numba import njit

from sooner.simulation._noise_kernels import high_half, low_half, mixed

CANOPY = 1  # what a look's word is mixed with for the draw whether it is in vain


@njit(cache=True, nogil=True, inline="always")
def level_of(cumulative, draw):
    """How many of the ascending `cumulative` are not above a draw: the level that is read."""
    low, high = 0, cumulative.shape[0]
    while low < high:
        middle = (low + high) >> 1
        if cumulative[middle] <= draw:
            low = middle + 1
        else:
            high = middle
    return low


@njit(cache=True, nogil=True, inline="always")
def told(map_ratio, target_ratio, share):
    """What readings say of a cell that only a share of looks sees: (of a node, of a target where there is a node).

    The two sensors look through the same gap or at the same leaf, so that readings (l, f) have the joint likelihood
    share * p(l | C) p(f | C) + (1 - share) * p(l | V) p(f | V) in state C. Divided by that of a void cell it is

        V: 1,    U: 1 - share + share G,    O: 1 - share + share G Z

    and the ratios returned are U : V and O : U, whose product is O : V, as Bayes' law of cells takes them.
    """
    if share >= 1.0:
        return map_ratio, target_ratio
    node = 1.0 - share + share * map_ratio
    return node, (1.0 - share + share * (map_ratio * target_ratio)) / node


@njit(cache=True, nogil=True)
def sense(
    places, radius_m, shape, cell_m, nodes, targets, glimpse, seed, second, cumulative, ratios,
    start, cells, agents, map_levels, target_levels, map_ratios, target_ratios,
):  # fmt: skip
    """Look at all cells whose centres are within an agent's radius, agent by agent, and write what is read to a log.

    places : (A, 2)                where agents are, metres east and north of the south-west cell's centre
    radius_m : (A,)
    shape : (2,) int64             rows and columns; row 0 is north
    nodes : (M,) bool              cells where the map sensor has a signal
    targets : (Q,) int64           cells where the target sensor has one; -1 for none
    glimpse : (M,) or (0,)         P(a look sees the cell); empty where every look does
    cumulative : (A, 4, n)         P(level <= l) of each agent's map noise, map signal, target noise, target signal
    ratios : (A, 2, n)             P(level | signal) / P(level | noise) of each agent's map and target sensor
    start : int                    where in the log to begin; the six arrays after it are the log

    Returns where the log now ends.
    """
    height, width = shape[0], shape[1]
    end, covered = start, glimpse.shape[0] > 0
    for agent in range(places.shape[0]):
        key = mixed(mixed(mixed(np.uint64(0), seed), second), agent)
        east, north = places[agent, 0] / cell_m, places[agent, 1] / cell_m
        reach = radius_m[agent] / cell_m
        square = reach * reach * (1.0 + 1e-12)
        first = max(math.ceil(north - reach), 0)
        last = min(math.floor(north + reach), height - 1)
        for up in range(first, last + 1):
            left = square - (up - north) * (up - north)
            half = math.sqrt(left) if left > 0.0 else 0.0
            row = (height - 1 - up) * width
            for right in range(max(math.ceil(east - half), 0), min(math.floor(east + half), width - 1) + 1):
                cell = row + right
                word = mixed(key, cell)
                seen = nodes[cell]
                there = False
                for target in range(targets.shape[0]):
                    there = there or targets[target] == cell
                share = glimpse[cell] if covered else 1.0
                if share < 1.0 and high_half(mixed(word, CANOPY)) >= share:
                    seen = there = False
                map_level = level_of(cumulative[agent, 1 if seen else 0], high_half(word))
                target_level = level_of(cumulative[agent, 3 if there else 2], low_half(word))
                cells[end] = cell
                agents[end] = agent
                map_levels[end] = map_level
                target_levels[end] = target_level
                map_ratios[end], target_ratios[end] = told(
                    ratios[agent, 0, map_level], ratios[agent, 1, target_level], share
                )
                end += 1
    return end
