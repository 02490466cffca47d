"""Compiled likelihood ratio detection and tracking over the states of a target on streets.

What they share, wherever they take it:

probability : (S + 1,) float        of each state of the whole graph, 0 where it is not explored; last, of no target
explored : (S,) bool                states both of whose nodes are detected
found : (N + 1,) int64              how many nodes are detected, and then they, in the order of their detection
confined : (transitions,) float     the walk's probabilities, confined to explored states
starts, neighbours, reverse         of the occupancy graph, (N + 1,) and (2E,) int64, and of its target states, (2E,)
outgoing_starts, weights            of the target states, (S + 1,) int64, and of the walk, (transitions,) float

Time goes with the detected nodes, however many there are in all. In loops over the states that are at a node,
`arriving` runs from `first - 1`, which stands for rest, over its row.
"""

from numba import njit

LEAST = 1e-300  # no explored state's probability falls below it, so that every logarithm is finite
MOST = 1e100  # nor does one look count for more, or for less than its inverse


@njit(cache=True, nogil=True, error_model="numpy")
def normalise(probability, explored, starts, found):
    """Probabilities of explored states and of no target made to total one, none of them below LEAST."""
    n, last = starts.shape[0] - 1, explored.shape[0]
    total = probability[last]
    for k in range(1, found[0] + 1):
        node = found[k]
        total += probability[node]
        for state in range(n + starts[node], n + starts[node + 1]):
            total += probability[state]
    scale = 1.0 / total
    for k in range(1, found[0] + 1):
        node = found[k]
        probability[node] = max(probability[node] * scale, LEAST)
        for state in range(n + starts[node], n + starts[node + 1]):
            if explored[state]:
                probability[state] = max(probability[state] * scale, LEAST)
    probability[last] = max(probability[last] * scale, LEAST)


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
def explore(
    probability, explored, found, confined, starts, neighbours, reverse, outgoing_starts, weights, nodes, start_ratio
):
    """The states that newly detected nodes open; each begins at a likelihood ratio of `start_ratio`.

    nodes : (k,) int64      those detected before are passed over
    """
    n = starts.shape[0] - 1
    begin = start_ratio * probability[explored.shape[0]]
    before = found[0]
    for node in nodes:
        if explored[node]:
            continue
        found[0] += 1
        found[found[0]] = node
        explored[node] = True
        probability[node] = begin
        for entry in range(starts[node], starts[node + 1]):
            if explored[neighbours[entry]]:
                explored[n + entry] = explored[reverse[entry]] = True
                probability[n + entry] = probability[reverse[entry]] = begin
        confine(node, explored, confined, starts, reverse, outgoing_starts, weights)
        for entry in range(starts[node], starts[node + 1]):
            if explored[n + entry]:
                confine(neighbours[entry], explored, confined, starts, reverse, outgoing_starts, weights)
    if found[0] > before:
        normalise(probability, explored, starts, found)


@njit(cache=True, nogil=True, error_model="numpy")
def move(probability, explored, found, confined, starts, reverse, outgoing_starts, vanish, appear, scratch):
    """The motion update, eq. (10) and (11), over explored states.

    vanish, appear : float      q(phi | s), and the sum over s of q(s | phi)
    scratch : (S,) float        overwritten
    """
    n, last = starts.shape[0] - 1, explored.shape[0]
    if found[0] == 0:
        return
    present, n_explored = 0.0, 0
    for k in range(1, found[0] + 1):
        node = found[k]
        first, beyond = starts[node], starts[node + 1]
        for state in range(n + first, n + beyond):
            scratch[state] = 0.0
        resting = 0.0
        for arriving in range(first - 1, beyond):
            state = node if arriving < first else reverse[arriving]
            if not explored[state]:
                continue
            here, row = probability[state], outgoing_starts[state]
            present += here
            n_explored += 1
            resting += here * confined[row]
            for entry in range(first, beyond):
                scratch[n + entry] += here * confined[row + 1 + entry - first]
        scratch[node] = resting
    kept, new = 1.0 - vanish, appear * probability[last] / n_explored
    for k in range(1, found[0] + 1):
        node = found[k]
        probability[node] = max(kept * scratch[node] + new, LEAST)
        for state in range(n + starts[node], n + starts[node + 1]):
            if explored[state]:
                probability[state] = max(kept * scratch[state] + new, LEAST)
    probability[last] = (1.0 - appear) * probability[last] + vanish * present


@njit(cache=True, nogil=True, error_model="numpy")
def see(probability, explored, found, starts, reverse, node_of_cell, cells, ratios, start, stop):
    """The measurement update, eq. (14), look by look.

    node_of_cell : (M,) int64; cells : (L,) int32; ratios : (L,) float, L(z | s) / L(z | phi) of each look
    start, stop : int           the looks of this second
    """
    for look in range(start, stop):
        node = node_of_cell[cells[look]]
        if node < 0 or not explored[node]:
            continue
        factor = min(max(ratios[look], 1.0 / MOST), MOST)
        probability[node] = largest = max(probability[node] * factor, LEAST)
        for entry in range(starts[node], starts[node + 1]):
            state = reverse[entry]
            if explored[state]:
                probability[state] = max(probability[state] * factor, LEAST)
                largest = max(largest, probability[state])
        if largest > MOST:
            normalise(probability, explored, starts, found)
    normalise(probability, explored, starts, found)


@njit(cache=True, nogil=True, error_model="numpy")
def node_ratios(probability, explored, found, starts, reverse, ratios):
    """Likelihood ratio of each detected node, written to `ratios` (N,): the sum over the states that are there.

    Returns the integrated likelihood ratio and the likeliest node, -1 where none is detected.
    """
    absent = probability[explored.shape[0]]
    total, likeliest, most = 0.0, -1, -1.0
    for k in range(1, found[0] + 1):
        node = found[k]
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
    found,
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
    explore(
        probability,
        explored,
        found,
        confined,
        starts,
        neighbours,
        reverse,
        outgoing_starts,
        weights,
        nodes,
        start_ratio,
    )
    move(probability, explored, found, confined, starts, reverse, outgoing_starts, vanish, appear, scratch)
    see(probability, explored, found, starts, reverse, node_of_cell, cells, target_ratios, start, stop)
    return node_ratios(probability, explored, found, starts, reverse, ratios)
