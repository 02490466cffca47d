"""Compiled taking in of one second's looks: Bayes' law, nodes detected, and the cell-wise test for a target."""

from numba import njit

from sooner.belief._cell_state_kernels import detect_nodes, see


@njit(cache=True, nogil=True)
def take_in(
    second, cells, map_ratios, target_ratios, start, end, void, unoccupied, occupied, explored, nodes, odds, found,
    node_seconds,
):  # fmt: skip
    """Looks `start` to `end` of a log change what is believed of cells; nodes are detected.

    node_seconds : (M,) int64        when each cell's node was detected; written for new ones

    Returns (how many nodes are new, their cells being the head of `found`; the likeliest cell to be occupied of those
    that pass the cell-wise test, -1 where none does; its odds). Cells whose node was detected before are settled: they
    change no more and are not tested again.
    """
    see(void, unoccupied, occupied, explored, nodes, cells, map_ratios, target_ratios, start, end)
    best, best_odds = -1, 0.0
    for look in range(start, end):
        cell = cells[look]
        if not nodes[cell]:
            rest = void[cell] + unoccupied[cell]
            if occupied[cell] >= odds * rest and occupied[cell] > best_odds * rest:
                best, best_odds = cell, occupied[cell] / rest
    new = detect_nodes(void, unoccupied, occupied, nodes, cells, start, end, odds, found)
    for n in range(new):
        node_seconds[found[n]] = second
    return new, best, best_odds
