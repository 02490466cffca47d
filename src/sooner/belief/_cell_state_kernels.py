"""Compiled beliefs about void, unoccupied and occupied cells: plain arrays in, written in place."""

from numba import njit

LEAST = 1e-100  # of a probability: certainty could never be taken back


@njit(cache=True, nogil=True)
def see(void, unoccupied, occupied, explored, nodes, cells, map_ratios, target_ratios, start, end):
    """Bayes' law for looks `start` to `end` of a log, one after another, but in cells whose node is detected.

    void, unoccupied, occupied : (M,) float, explored : (M,) bool, all written; nodes : (M,) bool; cells : (L,) int32,
    map_ratios : (L,) float, P(level | node) / P(level | void); target_ratios : (L,) float, P(level | target) / without.
    """
    for i in range(start, end):
        cell = cells[i]
        explored[cell] = True
        if nodes[cell]:
            continue
        v = void[cell]
        u = unoccupied[cell] * map_ratios[i]
        o = occupied[cell] * (map_ratios[i] * target_ratios[i])
        scale = 1.0 / (v + u + o)
        void[cell] = max(v * scale, LEAST)
        unoccupied[cell] = max(u * scale, LEAST)
        occupied[cell] = max(o * scale, LEAST)


@njit(cache=True, nogil=True)
def detect_nodes(void, unoccupied, occupied, nodes, cells, start, end, odds, found):
    """Detect nodes in those cells where the odds (u + o) / v reach a threshold; returns how many are new.

    cells : (L,) int32, of which `start` to `end` are tried, and may come twice; nodes : (M,) bool, written;
    found : (end - start or more,) int64, its head written.
    """
    n_found = 0
    for i in range(start, end):
        cell = cells[i]
        if not nodes[cell] and unoccupied[cell] + occupied[cell] >= odds * void[cell]:
            nodes[cell] = True
            found[n_found] = cell
            n_found += 1
    return n_found


@njit(cache=True, nogil=True)
def detect_target(void, unoccupied, occupied, cells, start, end, odds):
    """The likeliest cell to be occupied of those where the odds o / (v + u) reach a threshold; -1 where none does.

    cells : (L,) int32, of which `start` to `end` are tried.
    """
    best = -1
    for i in range(start, end):
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
