"""Compiled fitting of Gaussian mixtures: plain arrays in, plain arrays out."""

import math

import numpy as np
from numba import njit

NOTHING = -30.0  # a component this far below the likeliest, in logarithms, has no share of a point


@njit(cache=True, nogil=True)
def k_means(points, counts, centres, rounds):
    """Lloyd's algorithm over points that count several times each.

    points : (n, 2) float; counts : (n,) float; centres : (K, 2) float, where to begin; returns labels (n,) int64.
    """
    n, k = points.shape[0], centres.shape[0]
    labels = np.full(n, -1, np.int64)
    centres = centres.copy()
    for _ in range(rounds):
        changed = False
        sums = np.zeros((k, 3))
        for i in range(n):
            nearest, least = 0, np.inf
            for j in range(k):
                apart = (points[i, 0] - centres[j, 0]) ** 2 + (points[i, 1] - centres[j, 1]) ** 2
                if apart < least:
                    nearest, least = j, apart
            if nearest != labels[i]:
                labels[i] = nearest
                changed = True
            sums[nearest, 0] += counts[i]
            sums[nearest, 1] += counts[i] * points[i, 0]
            sums[nearest, 2] += counts[i] * points[i, 1]
        if not changed:
            break
        for j in range(k):
            if sums[j, 0] > 0:
                centres[j, 0] = sums[j, 1] / sums[j, 0]
                centres[j, 1] = sums[j, 2] / sums[j, 0]
    return labels


@njit(cache=True, nogil=True)
def _maximise(sums, floor, weights, means, covariances):
    """The M step, from each component's mass and its first and second moments, (K, 6)."""
    total = 0.0
    for j in range(sums.shape[0]):
        mass = sums[j, 0] + 1e-12
        row, col = sums[j, 1] / mass, sums[j, 2] / mass
        weights[j], means[j, 0], means[j, 1] = mass, row, col
        covariances[j, 0, 0] = max(sums[j, 3] / mass - row * row, 0.0) + floor
        covariances[j, 0, 1] = covariances[j, 1, 0] = sums[j, 4] / mass - row * col
        covariances[j, 1, 1] = max(sums[j, 5] / mass - col * col, 0.0) + floor
        total += mass
    for j in range(sums.shape[0]):
        weights[j] /= total


@njit(cache=True, nogil=True, fastmath=True)
def _expect(points, counts, weights, means, covariances, sums):
    """The E step: each component's moments over its shares of the points; returns the mean log likelihood."""
    k = weights.shape[0]
    scale = np.empty((k, 4))
    logs = np.empty(k)
    for j in range(k):
        rr, rc, cc = covariances[j, 0, 0], covariances[j, 0, 1], covariances[j, 1, 1]
        determinant = rr * cc - rc * rc
        scale[j, 0] = math.log(weights[j]) - math.log(2 * math.pi) - 0.5 * math.log(determinant)
        scale[j, 1], scale[j, 2], scale[j, 3] = -0.5 * cc / determinant, rc / determinant, -0.5 * rr / determinant
    sums[:] = 0.0
    likelihood, total = 0.0, 0.0
    for i in range(points.shape[0]):
        row, col, count = points[i, 0], points[i, 1], counts[i]
        largest = -1e300
        for j in range(k):
            down, right = row - means[j, 0], col - means[j, 1]
            logs[j] = scale[j, 0] + scale[j, 1] * down * down + scale[j, 2] * down * right + scale[j, 3] * right * right
            largest = max(largest, logs[j])
        mass = 0.0
        for j in range(k):
            below = logs[j] - largest
            logs[j] = math.exp(below) if below > NOTHING else 0.0
            mass += logs[j]
        for j in range(k):
            share = logs[j] * count / mass
            if share > 0.0:
                sums[j, 0] += share
                sums[j, 1] += share * row
                sums[j, 2] += share * col
                sums[j, 3] += share * row * row
                sums[j, 4] += share * row * col
                sums[j, 5] += share * col * col
        likelihood += count * (largest + math.log(mass))
        total += count
    return likelihood / total


@njit(cache=True, nogil=True)
def fit(points, counts, centres, floor, tolerance, rounds):
    """k-means, then expectation maximisation, until the mean log likelihood changes by less than `tolerance`.

    points : (n, 2) float       where, best around the origin; counts : (n,) float     how often
    centres : (K, 2) float      where k-means begins
    floor : float               added to the variances
    Returns weights (K,), means (K, 2), covariances (K, 2, 2), and whether it converged within `rounds`.
    """
    n, k = points.shape[0], centres.shape[0]
    labels = k_means(points, counts, centres, 100)
    sums = np.zeros((k, 6))
    for i in range(n):
        row, col, share = points[i, 0], points[i, 1], counts[i]
        moments = (share, share * row, share * col, share * row * row, share * row * col, share * col * col)
        for m in range(6):
            sums[labels[i], m] += moments[m]
    weights, means, covariances = np.empty(k), np.empty((k, 2)), np.empty((k, 2, 2))
    _maximise(sums, floor, weights, means, covariances)
    before = -1e300
    for _ in range(rounds):
        likelihood = _expect(points, counts, weights, means, covariances, sums)
        _maximise(sums, floor, weights, means, covariances)
        if abs(likelihood - before) < tolerance:
            return weights, means, covariances, True
        before = likelihood
    return weights, means, covariances, False
