"""Compiled steps of targets along streets: plain arrays in, plain arrays out."""

from numba import njit


@njit(cache=True, nogil=True)
def step(state, draw, current, starts, outgoing_starts, weights):
    """The state after one second.

    state : int; draw : float in [0, 1)
    current : (S,) int64                node of each state
    starts : (N + 1,) int64             rows of the occupancy graph
    outgoing_starts : (S + 1,) int64    rows of transitions: rest, then on to each neighbour
    weights : (transitions,) float      their probabilities; each row totals one
    """
    node = current[state]
    first, last = outgoing_starts[state], outgoing_starts[state + 1]
    below = weights[first]
    if draw < below:
        return node
    chosen = 0
    for entry in range(first + 1, last):
        if weights[entry] > 0.0:
            chosen = entry - first  # what rounding leaves over goes to the last that may be
            below += weights[entry]
            if draw < below:
                break
    return node if chosen == 0 else starts.shape[0] - 1 + starts[node] + chosen - 1


@njit(cache=True, nogil=True)
def step_biased(state, draw, current, starts, neighbours, outgoing_starts, weights, factors):
    """The state after one second of a target that weighs each node anew: `step` with weights times factors.

    neighbours : (2E,) int64      of the occupancy graph
    factors : (N,) float          of going to each node, at least 0; where all are 0 the target rests
    """
    node = current[state]
    first = outgoing_starts[state]
    rest, total = weights[first], 0.0
    for entry in range(starts[node], starts[node + 1]):
        total += weights[first + 1 + entry - starts[node]] * factors[neighbours[entry]]
    if draw < rest or total <= 0.0:
        return node
    below, chosen = 0.0, -1
    for entry in range(starts[node], starts[node + 1]):
        weight = weights[first + 1 + entry - starts[node]] * factors[neighbours[entry]]
        if weight > 0.0:
            chosen = entry
            below += weight
            if draw - rest < below / total * (1.0 - rest):
                break
    return starts.shape[0] - 1 + chosen


@njit(cache=True, nogil=True)
def walk(states, draws, current, starts, outgoing_starts, weights, path):
    """Several targets for several seconds.

    states : (targets,) int64           where they begin; where they are at the end, on return
    draws : (seconds, targets) float in [0, 1)
    path : (seconds, targets) int64     the state of each after each second; written
    """
    for second in range(draws.shape[0]):
        for target in range(draws.shape[1]):
            states[target] = step(states[target], draws[second, target], current, starts, outgoing_starts, weights)
            path[second, target] = states[target]
