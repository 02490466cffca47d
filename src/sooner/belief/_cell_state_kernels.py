"""Compiled beliefs about void, unoccupied and occupied cells: plain arrays in, written in place."""

from numba import njit

LEAST = 1e-100  # of a probability: certainty could never be taken back


@njit(cache=True, nogil=True)
def see(void, unoccupied, occupied, explored, nodes, cells, map_levels, target_levels, p_map, p_target):
    """Bayes' law for the cells in view of one searcher, but for those whose node is detected.

    void, unoccupied, occupied : (M,) float, explored : (M,) bool, all written; nodes : (M,) bool;
    cells, map_levels, target_levels : (k,) int64; p_map : (2, n_g), p_target : (2, n_z) float, of noise and of signal.
    """
    for i in range(cells.shape[0]):
        cell = cells[i]
        explored[cell] = True
        if nodes[cell]:
            continue
        g, z = map_levels[i], target_levels[i]
        v = void[cell] * (p_map[0, g] * p_target[0, z])
        u = unoccupied[cell] * (p_map[1, g] * p_target[0, z])
        o = occupied[cell] * (p_map[1, g] * p_target[1, z])
        seen = v + u + o
        void[cell] = max(v / seen, LEAST)
        unoccupied[cell] = max(u / seen, LEAST)
        occupied[cell] = max(o / seen, LEAST)


@njit(cache=True, nogil=True)
def detect_nodes(void, unoccupied, occupied, nodes, cells, odds, found):
    """Detect nodes in those cells where the odds (u + o) / v reach a threshold; returns how many are new.

    cells : (k,) int64, a cell may come twice; nodes : (M,) bool, written; found : (k,) int64, its head written.
    """
    n_found = 0
    for i in range(cells.shape[0]):
        cell = cells[i]
        if not nodes[cell] and unoccupied[cell] + occupied[cell] >= odds * void[cell]:
            nodes[cell] = True
            found[n_found] = cell
            n_found += 1
    return n_found


@njit(cache=True, nogil=True)
def detect_target(void, unoccupied, occupied, cells, odds):
    """Of the cells where the odds o / (v + u) reach a threshold the likeliest to be occupied; -1 where there is none."""
    best = -1
    for i in range(cells.shape[0]):
        cell = cells[i]
        likely = occupied[cell] >= odds * (void[cell] + unoccupied[cell])
        if likely and (best < 0 or occupied[cell] > occupied[best]):
            best = cell
    return best


@njit(cache=True, nogil=True)
def set_nodes(void, unoccupied, occupied, cells, ratios):
    """Nodes' cells are told by the likelihood ratio of a target there, against there being none.

    cells : (k,) int64; ratios : (k,) float, by node.
    """
    for i in range(cells.shape[0]):
        cell = cells[i]
        void[cell] = 0.0
        unoccupied[cell] = 1.0 / (ratios[i] + 1.0)
        occupied[cell] = ratios[i] / (ratios[i] + 1.0)


@njit(cache=True, nogil=True)
def expect_void(void, unoccupied, occupied, explored, expected, absent):
    """Cells never in view are given the void probability expected of them, and equal shares of the target's.

    expected : (M,) float; absent : P(there is no target).
    """
    unseen = 0
    for cell in range(void.shape[0]):
        if not explored[cell]:
            unseen += 1
    if unseen == 0:
        return
    share = (1.0 - absent) / unseen
    for cell in range(void.shape[0]):
        if not explored[cell]:
            void[cell] = expected[cell]
            occupied[cell] = (1.0 - expected[cell]) * share
            unoccupied[cell] = (1.0 - expected[cell]) * (1.0 - share)
