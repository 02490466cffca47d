"""Compiled random numbers, for kernels that draw millions of them and must not allocate.

words : (2 or more,) int64     the first two are the random state, 32 bits each and the first not zero; what else an
                               array of state holds comes after them

A kernel that calls these holds them compiled into it, and its cache is not told of a change here: touch it too.
"""

from numba import njit

WORD = 0xFFFFFFFF

# Without Numba's reference counts kernels run twice as fast; so no kernel of this kind may allocate.
kernel = njit(cache=True, nogil=True, _nrt=False)


@kernel
def draw(words):
    """32 random bits: xorshift plus a Weyl sequence, in 64-bit arithmetic that never overflows.

    (G. Marsaglia 2003, Journal of Statistical Software 8(14), 1-6)
    """
    x = words[0]
    x ^= (x << 13) & WORD
    x ^= x >> 17
    x ^= (x << 5) & WORD
    words[0] = x
    w = (words[1] + 362437) & WORD
    words[1] = w
    return (x + w) & WORD


@kernel
def below(words, n):
    """Whole number in [0, n)."""
    return (draw(words) * n) >> 32


@kernel
def uniform(words):
    """Number in [0, 1)."""
    return draw(words) * 2.3283064365386963e-10
