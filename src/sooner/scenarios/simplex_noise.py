"""Gradient noise on a simplex lattice, and the elevations that natural ground is cut from.

Around every lattice point v stands a bump that slopes along a gradient g(v) drawn from the seed; the noise is
the sum of the bumps within reach. The lattice is of equilateral triangles with sides of sqrt(2), which is also
how far a bump reaches, so that no more than four overlap anywhere.

Lattice, eight gradients, norm and the generator behind the seed are those of OpenSimplex (K. Spencer, 2014, in
the public domain), which the paper used; the same seed gives the same noise as its Python package `opensimplex`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["elevation", "simplex_noise"]

THREADS = 2  # that add noise, the same whatever their number
LARGE = 1 << 20  # cells from which on they are worth it
ROWS = 64  # of the map, that one thread adds at a time
FARTHEST = 2.0**40  # beyond, the spacing of floats shows in the noise

# The generator: state <- state * FACTOR + SHIFT modulo 2^64 [Knuth's MMIX constants]
FACTOR, SHIFT = 6364136223846793005, 1442695040888963407


def simplex_noise(x: ArrayLike, y: ArrayLike, seed: int) -> NDArray[np.float64]:
    """Noise at points: smooth, zero on average, of about one hill or hollow in a square of side 2.

    S(x, y, seed) = sum_v max(0, 2 - |d_v|^2)^4 (g_v . d_v) / 47,  d_v = (x, y) - v       [Kuhlman2017, sec. 6.1]

    over lattice points v = (i + s, j + s), s = (i + j) (sqrt(3) - 1) / 2, of all integers i and j.

    Parameters
    ----------
    x, y : (...) float       broadcast against each other; at most 2^40 in size
    seed : int               taken modulo 2^64

    Returns
    -------
    (...) float              in [-1, 1]; repeats after 256 lattice points

    Raises
    ------
    InvalidProblemError      if a coordinate is not a number or too large

    Examples
    --------
    >>> simplex_noise([0.0, 0.5, 1.0], 0.25, seed=1).round(3)
    array([ 0.372, -0.143, -0.416])
    """
    across, along = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
    _check_reach("coordinates", across, along)
    from sooner.scenarios._noise_kernels import noise_at

    noise: NDArray[np.float64] = noise_at(across.ravel(), along.ravel(), _permutation(seed))
    return noise.reshape(across.shape)


def elevation(
    shape: tuple[int, int], frequencies: Sequence[float], weights: Sequence[float], seed: int
) -> NDArray[np.float64]:
    """Ground made of several bands of noise.

    T(x, y, seed) = sum_i w_i S(f_i x, f_i y, seed)                                       [Kuhlman2017, sec. 6.1]

    Parameters
    ----------
    shape : (int, int)            H rows y and W columns x
    frequencies : (n_f,) float    f, per cell
    weights : (n_f,) float        w
    seed : int                    the same for every band, as in the paper

    Returns
    -------
    (H, W) float                  within the sum of the weights of zero

    Raises
    ------
    InvalidProblemError           if a frequency lacks its weight, or either is not a number or too large

    Examples
    --------
    >>> elevation((2, 3), frequencies=(0.5,), weights=(1.0,), seed=1).round(3)
    array([[ 0.   , -0.359, -0.359],
           [ 0.465,  0.054, -0.463]])
    """
    if len(frequencies) != len(weights):
        raise InvalidProblemError(f"{len(frequencies)} frequencies and {len(weights)} weights came; expected as many")
    _check_reach("frequencies times columns or rows", np.asarray(frequencies, np.float64) * max(shape))
    _check_reach("weights", np.asarray(weights, np.float64))
    from sooner.scenarios._noise_kernels import add_noise

    total = np.zeros(shape)
    permutation = _permutation(seed)
    bands = [(float(frequency), float(weight)) for frequency, weight in zip(frequencies, weights, strict=True)]

    def add(top: int) -> None:
        for frequency, weight in bands:
            add_noise(total[top : top + ROWS], top, frequency, weight, permutation)

    with ThreadPoolExecutor(THREADS if total.size >= LARGE else 1) as pool:
        list(pool.map(add, range(0, shape[0], ROWS)))
    return total


def _check_reach(what: str, *arrays: NDArray[np.float64]) -> None:
    for array in arrays:
        if not np.all(np.abs(array) <= FARTHEST):
            raise InvalidProblemError(f"{what} of up to {np.max(np.abs(array))} came; expected at most 2^40 in size")


def _draws(state: int) -> Iterator[int]:
    """Signed whole numbers of 64 bits, without end."""
    while True:
        state = (state * FACTOR + SHIFT) % 2**64
        yield state - 2**64 if state >= 2**63 else state


def _permutation(seed: int) -> NDArray[np.int64]:
    """(256,) int64: the numbers 0 to 255, drawn without putting back; hashes lattice points to gradients."""
    draws = _draws(int(seed))
    for _ in range(3):
        next(draws)
    left = list(range(256))
    drawn = np.empty(256, np.int64)
    for last in range(255, -1, -1):  # who stands last takes the place of the one drawn
        place = (next(draws) + 31) % (last + 1)
        drawn[last], left[place] = left[place], left[last]
    return drawn
