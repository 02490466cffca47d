"""Compiled kriging on a grid: the covariance is a small stencil, and conjugate gradients solve for the weights.

Arrays over cells stand in a frame of zeros as wide as the stencil reaches, so that no loop asks where the map ends.
"""

import math

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def covariance(east, north, angles, weights, along_m, across_m):
    """sum_p w_p exp(-|T R_p h|) of a lag h in metres: how alike two cells are, `along_m` and `across_m` the scales."""
    total = 0.0
    for p in range(angles.shape[0]):
        cosine, sine = math.cos(angles[p]), math.sin(angles[p])
        along = (cosine * east + sine * north) / along_m
        across = (cosine * north - sine * east) / across_m
        total += weights[p] * math.exp(-math.sqrt(along * along + across * across))
    return total


@njit(cache=True, nogil=True)
def stencil(angles, weights, along_m, across_m, cell_m, reach, least, width, shifts, values):
    """Lags of up to `reach` cells each way whose covariance is at least `least`, but for none; returns how many.

    width : of the framed grid; shifts : (k,) int64, the lag as a distance between numbers in it, one of each pair
    h and -h; values : (k,) float; both written.
    """
    n = 0
    for down in range(reach + 1):
        for right in range(-reach if down > 0 else 1, reach + 1):
            value = covariance(right * cell_m, -down * cell_m, angles, weights, along_m, across_m)
            if value >= least:
                shifts[n], values[n] = down * width + right, value
                n += 1
    return n


@njit(cache=True, nogil=True)
def _spread(x, shifts, values, n, first, last, out):
    """out = K x on the framed cells `first` to `last`; slices of one length let the compiler take several at a time."""
    size = last - first
    here, result = x[first:last], out[first:last]
    for i in range(size):
        result[i] = here[i]
    for k in range(n):
        shift, value = shifts[k], values[k]
        before, after = x[first - shift : last - shift], x[first + shift : last + shift]
        for i in range(size):
            result[i] += value * (before[i] + after[i])


@njit(cache=True, nogil=True)
def _solve(goal, known, shifts, values, n, first, last, tolerance, most, x, r, p, q):
    """K x = goal on the known cells by conjugate gradients from x as it comes; r, p, q are room to work in."""
    size = last - first
    wanted, mask, answer = goal[first:last], known[first:last], x[first:last]
    residual, way, image = r[first:last], p[first:last], q[first:last]
    _spread(x, shifts, values, n, first, last, q)
    left = 0.0
    for i in range(size):
        residual[i] = mask[i] * (wanted[i] - image[i])
        way[i] = residual[i]
        left += residual[i] * residual[i]
    rounds = 0
    while left > tolerance and rounds < most:
        _spread(p, shifts, values, n, first, last, q)
        bend = 0.0
        for i in range(size):
            bend += way[i] * image[i]
        if not bend > 0.0:
            break
        step = left / bend
        after = 0.0
        for i in range(size):
            answer[i] += step * way[i]
            residual[i] -= step * mask[i] * image[i]
            after += residual[i] * residual[i]
        turn = after / left
        for i in range(size):
            way[i] = residual[i] + turn * way[i]
        left = after
        rounds += 1
    return rounds


@njit(cache=True, nogil=True)
def peaks(edge_angles, counts, angles, weights):
    """The directions with the most edges, three bins at a time, and the share of each; returns how many.

    edge_angles : (E,) float, radians; counts : (n,) float, room for the histogram of half a turn;
    angles, weights : (P,) float, written. Without edges, P equal parts of half a turn.
    """
    n_bins, most = counts.shape[0], angles.shape[0]
    counts[:] = 0.0
    for edge in range(edge_angles.shape[0]):
        counts[math.floor(edge_angles[edge] * n_bins / math.pi) % n_bins] += 1.0
    found, total = 0, 0.0
    while found < most:
        best, heaviest, middle = -1, 0.0, 0.0
        for b in range(n_bins):
            held = counts[b - 1] + counts[b] + counts[(b + 1) % n_bins]
            if held > heaviest or (held == heaviest and counts[b] > middle):
                best, heaviest, middle = b, held, counts[b]
        if best < 0:
            break
        angles[found], weights[found] = (best + 0.5) * math.pi / n_bins, heaviest
        counts[best - 1], counts[best], counts[(best + 1) % n_bins] = 0.0, 0.0, 0.0
        total += heaviest
        found += 1
    if found == 0:
        for p in range(most):
            angles[p], weights[p] = p * math.pi / most, 1.0 / most
        return most
    for p in range(found):
        weights[p] /= total
    return found


@njit(cache=True, nogil=True)
def krige(
    void, explored, height, width, frame, angles, weights, along_m, across_m, cell_m, least, error, most, floor, room,
    out,
):  # fmt: skip
    """Ordinary kriging of `void` from the explored cells; returns the rounds of both solutions, or -1 if none is.

    void, out : (M,) float, explored : (M,) bool; frame : int, how many cells the stencil reaches;
    error : root mean square of what the solutions may leave; most : rounds; floor : the clip to [floor, 1 - floor];
    room : (8, (height + 2 frame) (width + 2 frame)) float: known, void, the two solutions (warm starts) and work.
    """
    across = width + 2 * frame
    known, goal, ones, x, w, r, p, q = room[0], room[1], room[2], room[3], room[4], room[5], room[6], room[7]
    p[:] = 0.0
    n_known = 0
    top, bottom = height, -1
    for row in range(height):
        for col in range(width):
            cell = row * width + col
            i = (row + frame) * across + frame + col
            if explored[cell]:
                known[i], goal[i], ones[i] = 1.0, void[cell], 1.0
                n_known += 1
                top, bottom = min(top, row), max(bottom, row)
            else:
                known[i], goal[i], ones[i], x[i], w[i] = 0.0, 0.0, 0.0, 0.0, 0.0
    if n_known == 0:
        return -1
    shifts = np.empty((2 * frame + 1) * (2 * frame + 1), np.int64)
    values = np.empty(shifts.shape[0])
    n = stencil(angles, weights, along_m, across_m, cell_m, frame, least, across, shifts, values)
    first, last = (top + frame) * across + frame, (bottom + frame) * across + frame + width
    tolerance = error * error * n_known
    rounds = _solve(goal, known, shifts, values, n, first, last, tolerance, most, x, r, p, q)
    rounds += _solve(ones, known, shifts, values, n, first, last, tolerance, most, w, r, p, q)
    above, below = 0.0, 0.0
    for i in range(first, last):
        above += x[i]
        below += w[i]
    mean = above / below
    first, last = frame * across + frame, (height - 1 + frame) * across + frame + width
    for i in range(first, last):
        p[i] = x[i] - mean * w[i]
    _spread(p, shifts, values, n, first, last, q)
    for row in range(height):
        for col in range(width):
            cell = row * width + col
            if explored[cell]:
                out[cell] = void[cell]
            else:
                out[cell] = min(max(mean + q[(row + frame) * across + frame + col], floor), 1.0 - floor)
    return rounds
