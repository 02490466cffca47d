"""Compiled random numbers that are looked up, not drawn in turn: the same question always gets the same answer.

What a sensor would read at a cell in a second is settled by (seed, second, agent, cell) alone. So two strategies of
one seed meet the same world wherever they look at the same time, whatever else they looked at before.
"""

import numpy as np
from numba import njit

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_27, _30, _31, _32 = np.uint64(27), np.uint64(30), np.uint64(31), np.uint64(32)
_LOW = np.uint64(0xFFFFFFFF)
_STEP = 1.0 / 4294967296.0


@njit(cache=True, nogil=True, inline="always")
def mixed(word, number):
    """64 bits in which every bit of `word` and of `number` has had its say.

    The output function of SplitMix64 (Steele, Lea, Flood 2014, OOPSLA; constants after D. Stafford).
    """
    z = (word ^ np.uint64(number)) + _GOLDEN
    z = (z ^ (z >> _30)) * _FIRST
    z = (z ^ (z >> _27)) * _SECOND
    return z ^ (z >> _31)


@njit(cache=True, nogil=True, inline="always")
def high_half(word):
    """Number in (0, 1) of the upper 32 bits."""
    return (np.float64(word >> _32) + 0.5) * _STEP


@njit(cache=True, nogil=True, inline="always")
def low_half(word):
    """Number in (0, 1) of the lower 32 bits."""
    return (np.float64(word & _LOW) + 0.5) * _STEP
