"""Compiled hill climbing of the planners of Lin & Goodrich: plain arrays in, plain arrays out.

reach : tuple                  the leading arguments of `sooner.problem._kernels.can_go_on`, neighbours (N, D) first
table : (N, L) float64         gain of the first L looks; later ones shrink by `ratio` (N,)
now : (N,) float64             what the next look at each cell pays; kept up to date here
looks : (N,) int64             looks at each cell so far; kept up to date here
state : (1,) int64             random state, in [1, 2^31 - 2]; ties that nothing else breaks are broken with it
width : int                    columns of the map, for boxes of rows and columns
"""

import numpy as np
from numba import njit

from sooner.grid._kernels import distances
from sooner.problem._kernels import can_go_on

FAR = 1 << 28
EQUAL = 1e-12  # boxes that differ by less, of their sum, hold the same ground in another order
DUST = 2.0**-150  # a smaller gain is nothing, as in the authors' single precision: what ends a wait on one cell


@njit(cache=True, nogil=True)
def _uniform(state):
    """Number in [0, 1): a multiplicative congruential generator modulo 2^31 - 1."""
    state[0] = state[0] * 48271 % 2147483647
    return state[0] / 2147483647.0


@njit(cache=True, nogil=True)
def look(table, ratio, now, looks, cell):
    """Collect what the next look at `cell` pays; returns it."""
    gained = now[cell]
    looks[cell] += 1
    last = table.shape[1] - 1
    if looks[cell] <= last:
        now[cell] = table[cell, looks[cell]]
    else:
        now[cell] = table[cell, last] * ratio[cell] ** (looks[cell] - last)
    if now[cell] < DUST:
        now[cell] = 0.0
    return gained


@njit(cache=True, nogil=True, fastmath=True)
def _box(now, width, cell, kernel):
    """Sum of `now` over the box of kernel x kernel cells around `cell`; beyond the map lies nothing."""
    half = kernel // 2
    row, col = cell // width, cell % width
    total = 0.0
    for r in range(max(row - half, 0), min(row + half + 1, now.shape[0] // width)):
        for c in range(max(col - half, 0), min(col + half + 1, width)):
            total += now[r * width + c]
    return total


@njit(cache=True, nogil=True)
def _best_step(reach, now, width, kernel, cell, before, left, state):
    """The open cell within one step whose next look pays most; ties by the box around it, then at random.

    With `left` >= 0 a step must leave a way to fly exactly `left` more; -1 asks for no more than the next step.
    Returns -1 where no step is open.
    """
    neighbours, fixed_wing = reach[0], reach[1]
    best, best_pay, best_box, ties = -1, -1.0, -1.0, 0
    for slot in range(-1, neighbours.shape[1]):
        other = cell if slot < 0 else neighbours[cell, slot]
        if other < 0 or (fixed_wing and (slot < 0 or other == before)):
            continue
        pay = now[other]
        if pay < best_pay:
            continue
        if left >= 0 and not can_go_on(
            reach[0], reach[1], reach[2], reach[3], reach[4], reach[5], reach[6], other, cell, left
        ):
            continue
        if pay > best_pay:
            best, best_pay, best_box, ties = other, pay, -1.0, 1
            continue
        box = 0.0
        if kernel > 0:
            if best_box < 0:
                best_box = _box(now, width, best, kernel)
            box = _box(now, width, other, kernel)
        else:
            best_box = 0.0
        if box > best_box * (1.0 + EQUAL):
            best, best_box, ties = other, box, 1
        elif box >= best_box * (1.0 - EQUAL):
            ties += 1
            if _uniform(state) * ties < 1.0:
                best = other
    return best


@njit(cache=True, nogil=True)
def climb(reach, table, ratio, now, looks, width, kernel, cell, before, steps, state):
    """`steps` steps of local hill climbing from `cell`, which has been looked at already.

    Returns the path, (steps + 1,) int64 with `cell` first, and what it collected.
    """
    path = np.empty(steps + 1, np.int64)
    path[0] = cell
    gained = 0.0
    for n in range(steps):
        other = _best_step(reach, now, width, kernel, path[n], before, steps - 1 - n, state)
        if other < 0:
            return path[: n + 1], gained
        gained += look(table, ratio, now, looks, other)
        before = path[n]
        path[n + 1] = other
    return path, gained


@njit(cache=True, nogil=True)
def fly(reach, table, ratio, now, looks, width, kernel, wanted, before, steps, state):
    """Exactly `steps` legal steps along `wanted`, a path that may break rules or be too long or too short.

    Follows it for as long as each step is legal and leaves a way to finish, then climbs. `now` and `looks` are
    those before anything was looked at. Returns the path, (steps + 1,) int64.
    """
    neighbours, fixed_wing = reach[0], reach[1]
    path = np.empty(steps + 1, np.int64)
    path[0] = wanted[0]
    look(table, ratio, now, looks, path[0])
    at = 0
    while at < steps and at + 1 < wanted.shape[0]:
        here, other = path[at], wanted[at + 1]
        legal = here == other and not fixed_wing
        for slot in range(neighbours.shape[1]):
            legal = legal or neighbours[here, slot] == other
        if not legal or (fixed_wing and other == before):
            break
        if not can_go_on(
            reach[0], reach[1], reach[2], reach[3], reach[4], reach[5], reach[6], other, here, steps - 1 - at
        ):
            break
        look(table, ratio, now, looks, other)
        before = here
        at += 1
        path[at] = other
    rest, _ = climb(reach, table, ratio, now, looks, width, kernel, path[at], before, steps - at, state)
    path[at : at + rest.shape[0]] = rest
    return path[: at + rest.shape[0]]


@njit(cache=True, nogil=True)
def _apart(neighbours, where, free, ends, matrix):
    """Fill `matrix` with the steps between the cells `ends`; FAR where there is no way.

    where : (N, 2) int32   coordinates in which steps are L1, Chebyshev or hexagonal by the number of slots; they
                           hold where no obstacle stands (`free`), else steps are counted on the graph
    """
    slots = neighbours.shape[1]
    for a in range(ends.shape[0]):
        if not free:
            steps = distances(neighbours, ends[a])
            for b in range(ends.shape[0]):
                matrix[a, b] = steps[ends[b]] if steps[ends[b]] >= 0 else FAR
            continue
        for b in range(ends.shape[0]):
            down = where[ends[a], 0] - where[ends[b], 0]
            right = where[ends[a], 1] - where[ends[b], 1]
            if slots == 4:
                matrix[a, b] = abs(down) + abs(right)
            elif slots == 8:
                matrix[a, b] = max(abs(down), abs(right))
            else:
                matrix[a, b] = max(abs(down), abs(right), abs(down + right))


@njit(cache=True, nogil=True)
def cheapest_order(matrix, has_last):
    """Fewest cells that connect all segments, over all orders and flips, and the order that needs them.

    matrix : (E, E) int64    steps between loose ends: 0 the first segment's, 2 m + 1 and 2 m + 2 those of middle
                             segment m, and, with `has_last`, E - 1 the last segment's

    Two ends d steps apart need d - 1 cells between them. Returns the number, and (M,) int64: the ends by which
    the middle segments are entered, in order. Held and Karp over the subsets of segments.
    """
    middle = (matrix.shape[0] - 1) // 2
    cost = np.full((1 << middle, 2 * middle + 1), FAR, np.int64)  # by segments done and the end that is loose
    came = np.zeros((1 << middle, 2 * middle + 1), np.int64)
    cost[0, 0] = 0
    for done in range(1 << middle):
        for end in range(2 * middle + 1):
            if cost[done, end] >= FAR:
                continue
            for enter in range(1, 2 * middle + 1):
                segment = (enter - 1) // 2
                if (done >> segment) & 1:
                    continue
                leave = enter + 1 if enter % 2 else enter - 1
                total = cost[done, end] + max(matrix[end, enter] - 1, 0)
                after = done | (1 << segment)
                if total < cost[after, leave]:
                    cost[after, leave] = total
                    came[after, leave] = end
    done = (1 << middle) - 1
    best, last = FAR, 0
    for end in range(2 * middle + 1):
        total = cost[done, end]
        if has_last and total < FAR:
            total += max(matrix[end, matrix.shape[0] - 1] - 1, 0)
        if total < best:
            best, last = total, end
    order = np.zeros(middle, np.int64)
    if best >= FAR:
        return best, order
    for n in range(middle - 1, -1, -1):
        order[n] = last + 1 if last % 2 else last - 1
        before = came[done, last]
        done ^= 1 << ((last - 1) // 2)
        last = before
    return best, order


@njit(cache=True, nogil=True)
def grow(reach, where, free, table, ratio, now, looks, width, kernel, seeds, befores, has_last, left, state):
    """Grow all segments of TopN, each time the one whose next cell pays most [Lin2014, Fig. 8].

    seeds : (E,) int64      loose ends as in `cheapest_order`; the second end of each middle segment is chosen here
    befores : (E,) int64    the cell before each seed; -1 where its heading is free
    left : int              cells that may still be added, the second ends among them

    Stops when the cells left are just enough to connect all segments. Returns trails (E, left + 2) int64, their
    lengths (E,) int64 and the order of entry (M,); an empty order of length 1 more than M where time is too short.
    """
    n_ends = seeds.shape[0]
    middle = (n_ends - 1) // 2
    trails = np.full((n_ends, left + 2), -1, np.int64)
    sizes = np.ones(n_ends, np.int64)
    ends = seeds.copy()
    befores = befores.copy()
    failed = np.zeros(middle + 1, np.int64)
    for end in range(n_ends):
        if end % 2 == 1 and end <= 2 * middle:
            look(table, ratio, now, looks, ends[end])
            partner = _best_step(reach, now, width, kernel, ends[end], -1, -1, state)
            if partner < 0 or left < 1:
                return trails, sizes, failed
            ends[end + 1] = partner
            befores[end], befores[end + 1] = partner, ends[end]
            look(table, ratio, now, looks, partner)
            left -= 1
        trails[end, 0] = ends[end]
    matrix = np.zeros((n_ends, n_ends), np.int64)
    _apart(reach[0], where, free, ends, matrix)
    cost, order = cheapest_order(matrix, has_last)
    slack = left - cost
    if slack < 0:
        return trails, sizes, failed
    while slack > 1:
        for _ in range(slack // 2):  # a step takes one cell and adds at most one to the connections
            best, best_cell, best_pay = -1, -1, -1.0
            for end in range(n_ends):
                cell = _best_step(reach, now, width, kernel, ends[end], befores[end], -1, state)
                if cell >= 0 and now[cell] > best_pay:
                    best, best_cell, best_pay = end, cell, now[cell]
            if best < 0:
                return trails, sizes, order
            look(table, ratio, now, looks, best_cell)
            befores[best], ends[best] = ends[best], best_cell
            trails[best, sizes[best]] = best_cell
            sizes[best] += 1
            left -= 1
        _apart(reach[0], where, free, ends, matrix)
        cost, order = cheapest_order(matrix, has_last)
        slack = left - cost
    return trails, sizes, order
