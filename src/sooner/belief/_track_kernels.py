"""Compiled likelihood ratio detection and tracking over the states of a target on streets.

What they share, wherever they take it:

probability : (S + 1,) float        of each state of the whole graph, 0 where it is not explored; last, of no target
explored : (S,) bool                states both of whose nodes are detected; the first N, at rest, say which nodes are
confined : (transitions,) float     the walk's probabilities, confined to explored states
starts, neighbours, reverse         of the occupancy graph, (N + 1,) and (2E,) int64, and of its target states, (2E,)
outgoing_starts, weights            of the target states, (S + 1,) int64, and of the walk, (transitions,) float

In loops over the states that are at a node, `arriving` runs from `first - 1`, which stands for rest, over its row.
"""

import numpy as np
from numba import njit

LEAST = 1e-300  # no explored state's probability falls below it, so that every logarithm is finite
MOST = 1e130  # nor does what is seen of a cell in one second count for more, or for less than its inverse


@njit(cache=True, nogil=True, error_model="numpy")
def normalise(probability, explored):
    """Probabilities of explored states and of no target made to total one, none of them below LEAST."""
    n_states = explored.shape[0]
    total = 0.0
    for state in range(n_states + 1):
        total += probability[state]
    scale = 1.0 / total
    for state in range(n_states):
        if explored[state]:
            probability[state] = max(probability[state] * scale, LEAST)
    probability[n_states] = max(probability[n_states] * scale, LEAST)


@njit(cache=True, nogil=True, error_model="numpy")
def confine(node, explored, confined, starts, reverse, outgoing_starts, weights):
    """The walk on from a node confined to explored neighbours; where there is none, the target stays."""
    n, first, beyond = starts.shape[0] - 1, starts[node], starts[node + 1]
    for arriving in range(first - 1, beyond):
        state = node if arriving < first else reverse[arriving]
        if not explored[state]:
            continue
        row = outgoing_starts[state]
        total = 0.0
        for entry in range(first, beyond):
            if explored[n + entry]:
                total += weights[row + 1 + entry - first]
        confined[row] = weights[row] if total > 0.0 else 1.0
        scale = (1.0 - weights[row]) / total if total > 0.0 else 0.0
        for entry in range(first, beyond):
            if explored[n + entry]:
                confined[row + 1 + entry - first] = weights[row + 1 + entry - first] * scale


@njit(cache=True, nogil=True, error_model="numpy")
def explore(probability, explored, confined, starts, neighbours, reverse, outgoing_starts, weights, nodes, start_ratio):
    """The states that newly detected nodes open; each begins at a likelihood ratio of `start_ratio`.

    nodes : (k,) int64      those detected before are passed over
    """
    n = starts.shape[0] - 1
    begin = start_ratio * probability[explored.shape[0]]
    changed = False
    for node in nodes:
        if explored[node]:
            continue
        changed = explored[node] = True
        probability[node] = begin
        for entry in range(starts[node], starts[node + 1]):
            if explored[neighbours[entry]]:
                explored[n + entry] = explored[reverse[entry]] = True
                probability[n + entry] = probability[reverse[entry]] = begin
        confine(node, explored, confined, starts, reverse, outgoing_starts, weights)
        for entry in range(starts[node], starts[node + 1]):
            if explored[n + entry]:
                confine(neighbours[entry], explored, confined, starts, reverse, outgoing_starts, weights)
    if changed:
        normalise(probability, explored)


@njit(cache=True, nogil=True, error_model="numpy")
def move(probability, explored, confined, starts, reverse, outgoing_starts, vanish, appear, scratch):
    """The motion update, eq. (10) and (11), over explored states.

    vanish, appear : float      q(phi | s), and the sum over s of q(s | phi)
    scratch : (S,) float        overwritten
    """
    n, n_states = starts.shape[0] - 1, explored.shape[0]
    present, n_explored = 0.0, 0
    for state in range(n_states):
        scratch[state] = 0.0
        present += probability[state]
        n_explored += explored[state]
    if n_explored == 0:
        return
    for node in range(n):
        if not explored[node]:
            continue
        first, beyond = starts[node], starts[node + 1]
        resting = 0.0
        for arriving in range(first - 1, beyond):
            state = node if arriving < first else reverse[arriving]
            if not explored[state]:
                continue
            here, row = probability[state], outgoing_starts[state]
            resting += here * confined[row]
            for entry in range(first, beyond):
                scratch[n + entry] += here * confined[row + 1 + entry - first]
        scratch[node] = resting
    kept, new = 1.0 - vanish, appear * probability[n_states] / n_explored
    for state in range(n_states):
        if explored[state]:
            probability[state] = max(kept * scratch[state] + new, LEAST)
    probability[n_states] = (1.0 - appear) * probability[n_states] + vanish * present


@njit(cache=True, nogil=True, error_model="numpy")
def see(probability, explored, starts, reverse, node_of_cell, cells, ratios, start, stop):
    """The measurement update, eq. (14), for looks at cells: several looks at one count one after the other.

    node_of_cell : (M,) int64; cells : (L,) int32; ratios : (L,) float, L(z | s) / L(z | phi) of each look
    start, stop : int           the looks of this second
    """
    factors = np.ones(starts.shape[0] - 1)
    for look in range(start, stop):
        node = node_of_cell[cells[look]]
        if node >= 0 and explored[node]:
            factors[node] = min(max(factors[node] * ratios[look], 1.0 / MOST), MOST)
    for look in range(start, stop):
        node = node_of_cell[cells[look]]
        if node < 0 or factors[node] == 1.0:
            continue
        factor, factors[node] = factors[node], 1.0  # so that it counts once
        probability[node] *= factor
        for entry in range(starts[node], starts[node + 1]):
            probability[reverse[entry]] *= factor
    normalise(probability, explored)


@njit(cache=True, nogil=True, error_model="numpy")
def node_ratios(probability, explored, starts, reverse, ratios):
    """Likelihood ratio of each node, written to `ratios` (N,): the sum over the states that are there.

    Returns the integrated likelihood ratio and the likeliest node, -1 where none is explored.
    """
    absent = probability[explored.shape[0]]
    total, likeliest, most = 0.0, -1, -1.0
    for node in range(starts.shape[0] - 1):
        here = 0.0
        if explored[node]:
            here = probability[node]
            for entry in range(starts[node], starts[node + 1]):
                here += probability[reverse[entry]]
            if here > most:
                likeliest, most = node, here
        total += here
        ratios[node] = here / absent
    return total / absent, likeliest


@njit(cache=True, nogil=True, error_model="numpy")
def second(
    probability,
    explored,
    confined,
    starts,
    neighbours,
    reverse,
    outgoing_starts,
    weights,
    node_of_cell,
    nodes,
    cells,
    target_ratios,
    start,
    stop,
    start_ratio,
    vanish,
    appear,
    scratch,
    ratios,
):
    """One second of a track: `explore`, `move`, `see`, `node_ratios`; returns what the last of them does."""
    explore(probability, explored, confined, starts, neighbours, reverse, outgoing_starts, weights, nodes, start_ratio)
    move(probability, explored, confined, starts, reverse, outgoing_starts, vanish, appear, scratch)
    see(probability, explored, starts, reverse, node_of_cell, cells, target_ratios, start, stop)
    return node_ratios(probability, explored, starts, reverse, ratios)
