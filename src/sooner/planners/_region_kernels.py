"""Loops over actions and atoms for planners over regions: plain arrays in, plain arrays out.

`looks` (K,) counts looks at each atom; `gains` (K, L + 1) pays by that count, and its last column is zero, so that a
count beyond L, clamped, pays nothing. An action that looks at an atom more than once has an entry for each look, and
`before` (C,) says how many of them came before: 0, 1, 2, ... in order.
"""

from __future__ import annotations

import numpy as np
from numba import njit

IN_TIME = 1e-9


@njit(cache=True, nogil=True, inline="always")
def pays(gains, atom, look):
    """What the next look at an atom pays that had so many."""
    return gains[atom, min(look, gains.shape[1] - 1)]


@njit(cache=True, nogil=True)
def reward(starts, atoms, before, gains, looks, action):
    """What an action would pay now."""
    total = 0.0
    for entry in range(starts[action], starts[action + 1]):
        total += pays(gains, atoms[entry], looks[atoms[entry]] + before[entry])
    return total


@njit(cache=True, nogil=True)
def fly(starts, atoms, gains, looks, action):
    """Look where an action looks; answers what that pays."""
    total = 0.0
    for entry in range(starts[action], starts[action + 1]):
        atom = atoms[entry]
        total += pays(gains, atom, looks[atom])
        looks[atom] += 1
    return total


@njit(cache=True, nogil=True)
def relaxed(
    starts, atoms, before, cover_starts, covers, cover_before, seconds, gains, looks, time_left, counts
):  # fmt: skip
    """Actions picked by rate, from anywhere, until the time is used up, the last one in part [Kuhlman2017, eq. (4)].

    looks (K,) is changed; counts (A,) receives how often each action was picked whole. Answers what they pay.
    """
    n_actions = len(seconds)
    rewards = np.empty(n_actions)
    for action in range(n_actions):
        rewards[action] = reward(starts, atoms, before, gains, looks, action)
    total = 0.0
    while True:
        best, rate = -1, 0.0
        for action in range(n_actions):
            if rewards[action] > rate * seconds[action]:
                best, rate = action, rewards[action] / seconds[action]
        if best < 0:
            return total
        if seconds[best] > time_left:
            return total + rate * time_left
        time_left -= seconds[best]
        counts[best] += 1
        total += rewards[best]
        for entry in range(starts[best], starts[best + 1]):
            atom = atoms[entry]
            look = looks[atom]
            looks[atom] += 1
            if pays(gains, atom, look) > 0.0:
                for other in range(cover_starts[atom], cover_starts[atom + 1]):
                    next_look = look + cover_before[other]
                    rewards[covers[other]] -= pays(gains, atom, next_look) - pays(gains, atom, next_look + 1)


@njit(cache=True, nogil=True)
def greedy(starts, atoms, before, way_starts, ways, ends, seconds, gains, looks, first, time_left, to_last, actions):
    """The open action of the best rate, ties by what it pays, until none fits [Kuhlman2017, sec. 4.1].

    Fills `actions`; answers how many.
    """
    here, count = first, 0
    while count < len(actions):
        best, best_rate, best_reward = -1, -1.0, -1.0
        for way in range(way_starts[here], way_starts[here + 1]):
            action = ways[way]
            there = ends[action, 0] + ends[action, 1] - here
            if seconds[action] + to_last[there] > time_left + IN_TIME:
                continue
            gained = reward(starts, atoms, before, gains, looks, action)
            rate = gained / seconds[action]
            if rate > best_rate or (rate == best_rate and gained > best_reward):
                best, best_rate, best_reward = action, rate, gained
        if best < 0:
            return count
        fly(starts, atoms, gains, looks, best)
        time_left -= seconds[best]
        here = ends[best, 0] + ends[best, 1] - here
        actions[count] = best
        count += 1
    return count
