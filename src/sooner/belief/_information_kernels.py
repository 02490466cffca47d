"""Compiled information of looks: plain arrays in, plain arrays out."""

import math

import numpy as np
from numba import njit

NOTHING = 1e-18  # an outcome that could add less than this share of the entropy is left out


@njit(cache=True, nogil=True)
def _unknown(present, absent, q, most, log_odds, on_hit, on_miss, nothing):
    """Entropy of the cell that q looks leave, expected over the number of hits up to `most`, in nats.

    A share p of certainty for and c against leaves p log(1 + c/p) + c log(1 + p/c). With x the smaller over the
    larger, log(1 + 1/x) = log(1 + x) - log x, and -log x is the distance of the log-odds from zero.
    """
    left = 0.0
    for m in range(most + 1):
        smaller, larger = min(present[m], absent[m]), max(present[m], absent[m])
        distance = abs(log_odds + m * on_hit + (q - m) * on_miss)
        if smaller * (2.0 + distance) > nothing:
            grown = math.log1p(smaller / larger)
            left += larger * grown + smaller * (grown + distance)
    return left


@njit(cache=True, nogil=True)
def information(theta, detect, false_alarm, out):
    """Bits that each look adds, by binomials over the number of hits.

    theta, detect, false_alarm : (N,) float; out : (N, L) float, written: no row rises, none is negative.
    """
    looks = out.shape[1]
    present, absent = np.empty(looks + 1), np.empty(looks + 1)  # P(m hits, target) and P(m hits, none)
    out[:] = 0.0
    for i in range(theta.shape[0]):
        prior, d, f = theta[i], detect[i], false_alarm[i]
        if prior <= 0.0 or prior >= 1.0 or d == f:
            continue
        # an infinite weight of a hit or miss belongs to outcomes with no mass on one side, which are left out
        on_hit = math.log(d) - math.log(f) if d > 0.0 and f > 0.0 else 0.0  # d / f may be beyond all numbers
        on_miss = math.log((1.0 - d) / (1.0 - f)) if d < 1.0 and f < 1.0 else 0.0
        log_odds = math.log(prior) - math.log1p(-prior)
        present[:], absent[:] = 0.0, 0.0
        present[0], absent[0] = prior, 1.0 - prior
        before = -prior * math.log(prior) - (1.0 - prior) * math.log1p(-prior)
        nothing, last = NOTHING * before, np.inf
        for q in range(1, looks + 1):
            most = 0 if f == 0.0 else q  # without false alarms one hit leaves no doubt
            for m in range(most, 0, -1):
                present[m] = present[m] * (1.0 - d) + present[m - 1] * d
                absent[m] = absent[m] * (1.0 - f) + absent[m - 1] * f
            present[0] *= 1.0 - d
            absent[0] *= 1.0 - f
            left = min(_unknown(present, absent, q, most, log_odds, on_hit, on_miss, nothing), before)
            last = min((before - left) / math.log(2.0), last)
            out[i, q - 1] = last
            before = left
            if left == 0.0:
                break
