"""In which order, and from which end, to fly stretches so that little is flown between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.decomposition.patterns.legs import Tracks, roomy

__all__ = ["toured"]

_MANY = 1000  # stretches beyond which the first order is kept: improving it takes their square in memory
_REVERSED = 50_000_000  # pairs that are looked at
_AROUND = 1.5  # what a way counts for that is not straight, in straight ones


def toured(stretches: Sequence[NDArray[np.float64]], free: Any, near: float) -> Tracks:
    """The stretches in the order of a short tour that begins and ends anywhere; some are turned round.

    Nearest first, then improved by reversing parts of the order while that makes it shorter (2-opt).

    Parameters
    ----------
    stretches : sequence of (n, 2) float    metres
    free : (Multi)Polygon                   where the drone may be
    near : float                            metres up to which ways between ends are tried for being straight; others
                                            count for half as much again

    Examples
    --------
    >>> lanes = [np.array([(0.0, y), (9.0, y)]) for y in (0.0, 2.0, 1.0)]
    >>> [lane.tolist() for lane in toured(lanes, shapely.box(0, 0, 9, 9), near=5.0)]
    [[[0.0, 0.0], [9.0, 0.0]], [[9.0, 1.0], [0.0, 1.0]], [[0.0, 2.0], [9.0, 2.0]]]
    """
    if len(stretches) < 2:
        return tuple(stretches)
    ends = np.array([(stretch[0], stretch[-1]) for stretch in stretches])
    if len(stretches) > 10 * _MANY:
        order = [2 * number for number in range(len(stretches))]
    elif len(stretches) > _MANY:
        places = ends.reshape(-1, 2)
        order = _nearest_first(len(places), lambda here: np.hypot(*(places - places[here]).T))
    else:
        apart = _apart(ends, free, near)
        order = _improved(_nearest_first(len(apart), lambda here: apart[here]), apart)
    return tuple(stretches[at // 2] if at % 2 == 0 else stretches[at // 2][::-1] for at in order)


def _apart(ends: NDArray[np.float64], free: Any, near: float) -> NDArray[np.float64]:
    """(2 n, 2 n): metres between ends; that of stretch k where it begins is 2 k, where it ends 2 k + 1.

    More where the way between them is not straight.
    """
    places = ends.reshape(-1, 2)
    apart = np.asarray(np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)))
    if free.convex_hull.area <= free.area * (1 + 1e-9):
        return apart
    a, b = np.nonzero(np.triu(apart <= near, 1))
    clear = shapely.covers(roomy(free), shapely.linestrings(np.stack([places[a], places[b]], axis=1)))
    straight = np.zeros(apart.shape, bool)
    straight[a[clear], b[clear]] = straight[b[clear], a[clear]] = True
    return np.asarray(np.where(straight, apart, _AROUND * apart + (apart <= near) * near))


def _nearest_first(count: int, apart: Callable[[int], NDArray[np.float64]]) -> list[int]:
    """From the first stretch on, the end of each at which it is entered; `apart` gives metres from one to all ends."""
    order, here = [0], 1
    left = np.full(count, True)
    left[:2] = False
    while left.any():
        entered = int(np.argmin(np.where(left, apart(here), np.inf)))
        order.append(entered)
        left[[entered, entered ^ 1]] = False
        here = entered ^ 1
    return order


def _improved(order: list[int], apart: NDArray[np.float64]) -> list[int]:
    """The order after reversals, the best first, until none makes it shorter by a millimetre."""
    tour = np.array(order)
    n = len(tour)
    for _ in range(min(4 * n, _REVERSED // n**2)):
        entered, left = tour, tour ^ 1
        # reversing i..j: what led into i leads into where j was left, and j's next is led into from where i was entered
        before = np.concatenate([[np.inf], apart[left[:-1], entered[1:]]])
        now_in = np.where(np.isfinite(before), before, 0.0)
        now_out = np.append(now_in[1:], 0.0)
        into = np.zeros((n, n))
        into[1:] = apart[np.ix_(left[:-1], left)]
        out = np.zeros((n, n))
        out[:, :-1] = apart[np.ix_(entered, entered[1:])]
        change = np.triu(into + out - now_in[:, None] - now_out[None])
        i, j = np.unravel_index(int(np.argmin(change)), change.shape)
        if change[i, j] > -1e-3:
            break
        tour = np.concatenate([tour[:i], tour[i : j + 1][::-1] ^ 1, tour[j + 1 :]])
    return [int(at) for at in tour]
