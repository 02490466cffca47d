"""Compiled gradient noise on a simplex lattice: plain arrays in, plain arrays out."""

import math

import numpy as np
from numba import njit

# OpenSimplex rounds these to 15 digits; so do we, or far from the origin its noise and ours would drift apart.
STRETCH = -0.211324865405187  # (1 / sqrt(3) - 1) / 2, points to lattice coordinates
SQUISH = 0.366025403784439  # (sqrt(3) - 1) / 2, and back
NORM = 47.0
# Directions of an octagon's corners, longer than one: NORM takes that back.
GRADIENTS = np.array([(5, 2), (2, 5), (-5, 2), (-2, 5), (5, -2), (2, -5), (-5, -2), (-2, -5)], np.float64)
# A point's lattice cell is a rhombus of two triangles. Within sqrt(2), the length of their sides, lie no lattice
# points but the rhombus's corners and the corners of the four triangles that lean against it.
NEAR = np.array([(0, 0), (1, 0), (0, 1), (1, 1), (1, -1), (-1, 1), (2, 0), (0, 2)], np.int64)


@njit(cache=True, nogil=True)
def _noise(x, y, permutation):
    stretch = (x + y) * STRETCH
    column, row = math.floor(x + stretch), math.floor(y + stretch)
    total = 0.0
    for near in range(NEAR.shape[0]):
        i, j = column + NEAR[near, 0], row + NEAR[near, 1]
        squish = (i + j) * SQUISH
        right, up = x - (i + squish), y - (j + squish)
        weight = 2.0 - right * right - up * up
        if weight > 0.0:
            g = permutation[(permutation[i & 255] + j) & 255] // 2 % 8
            weight *= weight
            total += weight * weight * (GRADIENTS[g, 0] * right + GRADIENTS[g, 1] * up)
    return total / NORM


@njit(cache=True, nogil=True)
def noise_at(x, y, permutation):
    """S at each of n points.

    x, y : (n,) float; permutation : (256,) int64; returns (n,) float.
    """
    noise = np.empty(x.size)
    for point in range(x.size):
        noise[point] = _noise(x[point], y[point], permutation)
    return noise


@njit(cache=True, nogil=True)
def add_noise(elevation, top, frequency, weight, permutation):
    """Add weight * S(frequency * column, frequency * row) to every cell, rows counted from `top`.

    elevation : (H, W) float, changed in place; frequency, weight : float; permutation : (256,) int64.
    """
    for row in range(elevation.shape[0]):
        for col in range(elevation.shape[1]):
            elevation[row, col] += weight * _noise(frequency * col, frequency * (top + row), permutation)
