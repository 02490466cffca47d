"""Compiled hindsight of several tracks: which looks confirmed targets explain, and what is left of them for others."""

from numba import njit

from sooner.belief._track_kernels import MOST


@njit(cache=True, nogil=True)
def explain(probability, found, starts, reverse, cells_of_nodes, explained):
    """Add a track's probability of being in each cell to `explained` (M,), which stays at most one.

    cells_of_nodes : (N,) int64; the rest as of `_track_kernels`
    """
    for k in range(1, found[0] + 1):
        node = found[k]
        here = probability[node]
        for entry in range(starts[node], starts[node + 1]):
            here += probability[reverse[entry]]
        cell = cells_of_nodes[node]
        explained[cell] = min(explained[cell] + here, 1.0)


@njit(cache=True, nogil=True)
def unexplained(cells, ratios, explained, together, left):
    """What one second's looks say of another target: e + (1 - e) Z for each cell, Z the product of its looks.

    cells : (L,) int32; ratios : (L,) float; explained : (M,) float, e; together : (M,) float, overwritten
    left : (L,) float           written: a cell's first look bears all that its looks say, those after it nothing
    """
    for look in range(cells.shape[0]):
        together[cells[look]] = 1.0
    for look in range(cells.shape[0]):
        cell = cells[look]
        together[cell] = min(max(together[cell] * min(max(ratios[look], 1.0 / MOST), MOST), 1.0 / MOST), MOST)
    for look in range(cells.shape[0]):
        cell = cells[look]
        left[look] = 1.0 if together[cell] < 0.0 else explained[cell] + (1.0 - explained[cell]) * together[cell]
        together[cell] = -1.0
