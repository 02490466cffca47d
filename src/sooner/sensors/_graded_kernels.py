"""Compiled graded looks: plain numbers in, plain numbers out."""

from numba import njit


@njit(cache=True, nogil=True)
def nearest_level(reading, lowest, step, n_levels):
    """Which of the levels lowest, lowest + step, ... is nearest to a reading; the outermost take what lies beyond."""
    place = (reading - lowest) / step + 0.5
    if not place > 0.0:
        return 0
    if place >= n_levels:
        return n_levels - 1
    return int(place)


@njit(cache=True, nogil=True)
def read_levels(signals, noise, sensitivity, lowest, step, n_levels, out):
    """The level that each look reports.

    signals : (n,) bool, whether there is something to see; noise : (n,) float, standard normal; out : (n,) int64.
    """
    for i in range(signals.shape[0]):
        reading = noise[i] + sensitivity if signals[i] else noise[i]
        out[i] = nearest_level(reading, lowest, step, n_levels)
