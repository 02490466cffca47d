"""Compiled information about cell states: looked up in a table, between whose entries it is bilinear in log-odds."""

import math

from numba import njit


@njit(cache=True, nogil=True)
def look_up(void, unoccupied, occupied, node_span, target_span, table, least, out):
    """Bits that one look at each cell is expected to teach; 0 where there are less than `least` to learn.

    void, unoccupied, occupied, out : (M,) float; node_span, target_span : (2,) float, the log-odds of a node
    and of a target on it at both ends of the table : (n_nodes, n_targets) float.
    """
    n_nodes, n_targets = table.shape
    per_node = (n_nodes - 1) / (node_span[1] - node_span[0])
    per_target = (n_targets - 1) / (target_span[1] - target_span[0])
    for cell in range(void.shape[0]):
        v, u, o = void[cell], unoccupied[cell], occupied[cell]
        node = u + o
        out[cell] = 0.0
        if node <= 0.0:
            continue
        log_v = math.log(v) if v > 0.0 else -800.0
        log_u = math.log(u) if u > 0.0 else -800.0
        log_o = math.log(o) if o > 0.0 else -800.0
        if -(v * log_v + u * log_u + o * log_o) < least * math.log(2.0):
            continue
        a = (math.log(node) - log_v - node_span[0]) * per_node
        b = (log_o - log_u - target_span[0]) * per_target
        a = min(max(a, 0.0), n_nodes - 1.000001)
        b = min(max(b, 0.0), n_targets - 1.000001)
        i, j = int(a), int(b)
        a -= i
        b -= j
        low = table[i, j] + b * (table[i, j + 1] - table[i, j])
        high = table[i + 1, j] + b * (table[i + 1, j + 1] - table[i + 1, j])
        out[cell] = low + a * (high - low)
