"""Loops of branch and bound over regions: plain arrays in, plain arrays out.

ground : tuple of arrays
    seconds (A,), inverse (A,) = 1 / seconds, ends (A, 2), way_starts (R + 1,), ways, to_last (R,)    what can be flown
    starts (A + 1,), atoms, cover_starts (K + 1,), covers, shares = inverse[covers]      who looks at what
    pay, less, sums, rows                                                                what that pays
    before, repeats (C,), cover_before (C,)     looks at an atom that the same action takes before, and in all
places (K,) : where each atom stands in `pay`, the gains of all atoms end to end: rows[k] is the place of its first
    look, one further on is that of its second. The last places of a row pay nothing, as many as an action takes looks
    at an atom, and nobody goes beyond them: an atom moves on only while it pays. less[p] = pay[p] - pay[p + 1];
    sums[p] is what the looks before p have paid.
rates (A,) : what each action would pay a second now.

A search keeps its nodes, each a walk, as rows: `links` (N, 3) int32 the node before, its last action, its region;
`worth` (N, 3) what it has paid, the seconds left, and g; `keys` (N,) int64 a number that its actions, in whatever
order, add up to. `heap_keys` and `heap` are a binary heap, largest first; `table` (2^m,) holds the keys seen, by open
addressing, 0 where free; state (8,) counts, at the places named below.
"""

import numpy as np
from numba import njit

from sooner.planners._region_kernels import IN_TIME

BEFORE, ACTION, REGION = 0, 1, 2
PAID, LEFT, MOST = 0, 1, 2
NODES, OPEN, SEEN, POPPED, EXPANDED, GENERATED, SHUFFLED, SOLVED = 0, 1, 2, 3, 4, 5, 6, 7
BITS = (1 << 62) - 1
DUST = 1e-14  # a rate that is so much smaller than the first is the rounding of nothing
NEVER = -np.inf


@njit(cache=True, nogil=True, fastmath={"nnan", "nsz"})
def _highest(rates):
    """The largest number; compiled to whole vectors at a time, which looking for its place would forbid."""
    best = rates[0]
    for n in range(1, len(rates)):
        best = rates[n] if rates[n] > best else best
    return best


@njit(cache=True, nogil=True)
def _where(rates, rate):
    for n in range(len(rates)):
        if rates[n] == rate:
            return n
    return 0


@njit(cache=True, nogil=True)
def _rates(ground, places, rates):
    """What every action pays a second."""
    _, inverse, _, _, _, _, starts, atoms, _, _, _, pay, _, _, _, before, _, _ = ground
    for action in range(len(rates)):
        total = 0.0
        for entry in range(starts[action], starts[action + 1]):
            total += pay[places[atoms[entry]] + before[entry]]
        rates[action] = total * inverse[action]


@njit(cache=True, nogil=True)
def _fly(ground, places, rates, action):
    """Look where an action looks: answers what it pays, and takes from all rates what is no longer to be had."""
    _, _, _, _, _, _, starts, atoms, cover_starts, covers, shares, pay, less, _, _, _, _, cover_before = ground
    total = 0.0
    for entry in range(starts[action], starts[action + 1]):
        atom = atoms[entry]
        place = places[atom]
        if pay[place] > 0.0:
            total += pay[place]
            places[atom] = place + 1
            for cover in range(cover_starts[atom], cover_starts[atom + 1]):
                rates[covers[cover]] -= less[place + cover_before[cover]] * shares[cover]
    return total


@njit(cache=True, nogil=True)
def _pays(ground, places, action, again):
    """What an action pays after so many more of the same."""
    _, _, _, _, _, _, starts, atoms, _, _, _, pay, _, _, rows, before, repeats, _ = ground
    total, last = 0.0, len(pay) // len(rows) - 1
    for entry in range(starts[action], starts[action + 1]):
        atom = atoms[entry]
        total += pay[min(places[atom] + again * repeats[entry] + before[entry], rows[atom] + last)]
    return total


@njit(cache=True, nogil=True)
def most(ground, places, rates, paid, left, enough, apart, picks):
    """g(N): actions picked by rate, from anywhere, the last one in part, after `paid` [Kuhlman2017, eq. (4)].

    Rates only fall, so what is paid and the best rate for all the time left is never exceeded: where that is no more
    than `enough`, it is answered at once. `apart` lets no pick lower the rates of other actions: looser, and a bound
    even where footprints overlap. Changes places, rates and picks (A,), which need not be set.
    """
    seconds, inverse = ground[0], ground[1]
    picks[:] = 0
    dust = DUST * _highest(rates)
    while True:
        rate = _highest(rates)
        if rate <= dust or paid + rate * left <= enough:
            return paid + rate * left if rate > dust else paid
        action = _where(rates, rate)
        if seconds[action] > left:
            return paid + rate * left
        left -= seconds[action]
        if apart:
            paid += rate * seconds[action]
            picks[action] += 1
            rates[action] = _pays(ground, places, action, picks[action]) * inverse[action]
        else:
            paid += _fly(ground, places, rates, action)


@njit(cache=True, nogil=True)
def _complete(ground, region, left):
    """Whether no action fits in the time left."""
    seconds, _, ends, way_starts, ways, to_last = ground[:6]
    for way in range(way_starts[region], way_starts[region + 1]):
        action = ways[way]
        there = ends[action, 0] + ends[action, 1] - region
        if seconds[action] + to_last[there] <= left + IN_TIME:
            return False
    return True


@njit(cache=True, nogil=True)
def _push(heap_keys, heap, size, key, node):
    """Into a binary heap, the largest first; of equals, the newest."""
    here = size
    while here > 0:
        above = (here - 1) >> 1
        if heap_keys[above] > key:
            break
        heap_keys[here], heap[here] = heap_keys[above], heap[above]
        here = above
    heap_keys[here], heap[here] = key, node


@njit(cache=True, nogil=True)
def _pop(heap_keys, heap, size):
    """The largest of `size`."""
    top, key, node = heap[0], heap_keys[size - 1], heap[size - 1]
    here, last = 0, size - 1
    while 2 * here + 1 < last:
        below = 2 * here + 1
        if below + 1 < last:
            right = heap_keys[below + 1]
            if right > heap_keys[below] or (right == heap_keys[below] and heap[below + 1] > heap[below]):
                below += 1
        if heap_keys[below] < key or (heap_keys[below] == key and heap[below] < node):
            break
        heap_keys[here], heap[here] = heap_keys[below], heap[below]
        here = below
    heap_keys[here], heap[here] = key, node
    return top


@njit(cache=True, nogil=True)
def is_new(table, key):
    """Put a key, not 0, into the table; whether it was not there."""
    mask = len(table) - 1
    slot = (key ^ (key >> 29)) & mask
    while table[slot] != 0:
        if table[slot] == key:
            return False
        slot = (slot + 1) & mask
    table[slot] = key
    return True


@njit(cache=True, nogil=True)
def moved(table, larger):
    """Put all keys of a table into a larger one."""
    for key in table:
        if key != 0:
            is_new(larger, key)


@njit(cache=True, nogil=True)
def _below(state, n):
    """Whole number in [0, n): a multiplicative congruential generator modulo 2^31 - 1."""
    state[SHUFFLED] = state[SHUFFLED] * 48271 % 2147483647
    return state[SHUFFLED] * n // 2147483647


@njit(cache=True, nogil=True)
def _opened(ground, region, left, state, shuffled, found):
    """Actions that fit in the time left, in the order of the ground or in a random one; answers how many."""
    seconds, _, ends, way_starts, ways, to_last = ground[:6]
    count = 0
    for way in range(way_starts[region], way_starts[region + 1]):
        action = ways[way]
        there = ends[action, 0] + ends[action, 1] - region
        if seconds[action] + to_last[there] <= left + IN_TIME:
            found[count] = action
            count += 1
    if shuffled:
        for n in range(count - 1, 0, -1):
            other = _below(state, n + 1)
            found[n], found[other] = found[other], found[n]
    return count


@njit(cache=True, nogil=True)
def _replayed(ground, links, node, places):
    """Places of all atoms after the walk of a node."""
    _, _, _, _, _, _, starts, atoms, _, _, _, pay, _, _, rows, _, _, _ = ground
    places[:] = rows
    while node > 0:
        action = links[node, ACTION]
        for entry in range(starts[action], starts[action + 1]):
            atom = atoms[entry]
            if pay[places[atom]] > 0.0:
                places[atom] += 1
        node = links[node, BEFORE]


@njit(cache=True, nogil=True)
def branch(
    ground, numbers, links, worth, keys, heap_keys, heap, table, state, best,
    alpha, eta, depth_first, apart, early, until,
):  # fmt: skip
    """Algorithms 1 to 3 of [Kuhlman2017], until `until` nodes are popped, none is open, or a better solution is found.

    numbers (A,) are those that keys add up. best (2,) holds the value of the best complete walk, B, and that of the
    best walk popped, complete or not; answers the nodes of both, -1 where neither is new. `early` takes a walk for
    complete where one of the actions that could begin does not fit, and goes on from it all the same.
    """
    ends = ground[2]
    n_actions = len(numbers)
    places, now = np.empty(len(ground[14]), np.int64), np.empty(len(ground[14]), np.int64)
    rates, later = np.empty(n_actions), np.empty(n_actions)
    found, picks = np.empty(n_actions, np.int64), np.empty(n_actions, np.int64)
    furthest, solution = -1, -1
    while state[OPEN] > 0 and state[POPPED] < until:
        node = _pop(heap_keys, heap, state[OPEN])
        state[OPEN] -= 1
        state[POPPED] += 1
        paid, left, region = worth[node, PAID], worth[node, LEFT], links[node, REGION]
        if node > 0 and paid >= best[1]:
            best[1], furthest = paid, node
        fit = _opened(ground, region, left, state, depth_first, found)
        ended = fit == 0 or (early and fit < ground[3][region + 1] - ground[3][region])
        if ended and node > 0 and paid > best[0]:
            best[0], solution = paid, node
            state[SOLVED] += 1
        enough = (1.0 + eta) * best[0] if best[0] > NEVER else NEVER
        if fit == 0 or worth[node, MOST] <= enough:
            if solution >= 0:
                break
            continue
        state[EXPANDED] += 1
        _replayed(ground, links, node, places)
        _rates(ground, places, rates)
        for n in range(fit):
            action = found[n]
            state[GENERATED] += 1
            key = (keys[node] + numbers[action]) & BITS
            if not is_new(table, key):
                continue
            state[SEEN] += 1
            now[:], later[:] = places, rates
            gained = paid + _fly(ground, now, later, action)
            g = most(ground, now, later, gained, left - ground[0][action], enough, apart, picks)
            if g <= enough:
                continue
            child = state[NODES]
            state[NODES] += 1
            links[child, BEFORE], links[child, ACTION] = node, action
            links[child, REGION] = ends[action, 0] + ends[action, 1] - region
            worth[child, PAID], worth[child, LEFT], worth[child, MOST] = gained, left - ground[0][action], g
            keys[child] = key
            hoped = g - eta * best[0] if best[0] > NEVER else g
            first = float(child) if depth_first else gained + alpha * (hoped - gained)
            _push(heap_keys, heap, state[OPEN], first, child)
            state[OPEN] += 1
        if solution >= 0:
            break
    return solution, furthest


@njit(cache=True, nogil=True)
def _left(ground, counts, more, limit):
    """Seconds left after actions flown so often, and one more: always summed in the same order."""
    seconds = ground[0]
    taken = 0.0
    for action in range(len(counts)):
        taken += (counts[action] + (1 if action == more else 0)) * seconds[action]
    return limit - taken


@njit(cache=True, nogil=True)
def _placed(ground, counts, places):
    """Places of all atoms after actions flown so often."""
    _, _, _, _, _, _, starts, atoms, _, _, _, pay, _, _, rows, _, _, _ = ground
    last = len(pay) // len(rows) - 1
    places[:] = rows
    for action in range(len(counts)):
        if counts[action] > 0:
            for entry in range(starts[action], starts[action + 1]):
                places[atoms[entry]] += counts[action]
    for atom in range(len(rows)):
        place = min(places[atom], rows[atom] + last)
        while place > rows[atom] and pay[place - 1] == 0.0:
            place -= 1  # to where looks begin to pay nothing: what an action looks at again lies beyond it in the row
        places[atom] = place


@njit(cache=True, nogil=True)
def next_layer(
    ground, numbers, counts, regions, keys, limit, legs, after, after_key, best, alpha, eta, apart,
    table, state, links, hopes, child_keys, solved,
):  # fmt: skip
    """Children of a layer of nodes that could be worth it, for `BeamStack`; answers how many.

    counts (W, A) says how often each node flew each action; limit is the time in all, legs what was paid before.
    links (M, 3), hopes (M, 2), child_keys (M,) receive the node before, the action, the region; R + alpha (g - R)
    [Kuhlman2017, eq. (5)] and R; and the key. Children that do not come after (`after`, `after_key`), by hope and then
    by key, were there before and are left out. `best` (1,) is B; solved (2,) the node and action of a new one.

    Whatever the order of its actions, a walk has the same R and g to the last digit: everything is summed up anew.
    """
    ends, pay, sums = ground[2], ground[11], ground[13]
    n_actions, n_atoms = len(numbers), len(ground[14])
    places, now = np.empty(n_atoms, np.int64), np.empty(n_atoms, np.int64)
    rates, picks, found = np.empty(n_actions), np.empty(n_actions, np.int64), np.empty(n_actions, np.int64)
    kept = 0
    for node in range(len(regions)):
        state[EXPANDED] += 1
        _placed(ground, counts[node], places)
        left = _left(ground, counts[node], -1, limit)
        for n in range(_opened(ground, regions[node], left, state, False, found)):
            action = found[n]
            state[GENERATED] += 1
            key = (keys[node] + numbers[action]) & BITS
            if not is_new(table, key):
                continue
            state[SEEN] += 1
            now[:] = places
            for entry in range(ground[6][action], ground[6][action + 1]):
                atom = ground[7][entry]
                if pay[now[atom]] > 0.0:
                    now[atom] += 1
            paid = legs
            for atom in range(n_atoms):
                paid += sums[now[atom]]
            region = ends[action, 0] + ends[action, 1] - regions[node]
            then = _left(ground, counts[node], action, limit)
            if _complete(ground, region, then):
                if paid > best[0]:
                    best[0] = paid
                    state[SOLVED] += 1
                    solved[0], solved[1] = node, action
                continue
            enough = (1.0 + eta) * best[0] if best[0] > NEVER else NEVER
            _rates(ground, now, rates)
            g = most(ground, now, rates, paid, then, enough, apart, picks)
            if g <= enough:
                continue
            hope = paid + alpha * (g - paid)
            if hope > after or (hope == after and key <= after_key):
                continue
            links[kept, BEFORE], links[kept, ACTION], links[kept, REGION] = node, action, region
            hopes[kept, 0], hopes[kept, 1], child_keys[kept] = hope, paid, key
            kept += 1
    return kept
