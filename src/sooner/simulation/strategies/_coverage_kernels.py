"""Compiled routes of waypoints for a whole mission: what they bring into view and when, and moves that better them.

The value of the routes of a team is

    J = sum_c w_c (T - f_c)^+

with w_c what cell c weighs, f_c the second of its first view by any agent, from now, and T the seconds that are left.
Agents look at whole seconds from 1 to T - 1. Only the agent that changes is flown again, and only from the second
before the change; what the others see is kept as the least over them (`others`). Cell `row * width + col` of `cell_m`
has its centre `col` cells east and `height - 1 - row` north of the origin.
"""

import math

import numpy as np
from numba import njit

from sooner.simulation._flight_kernels import thrust
from sooner.simulation._noise_kernels import high_half, low_half, mixed

STEPS = 4  # of Euler's rule in a second
LEAST = 1e-30  # of a target's share: nothing is ever ruled out
SETTLED = 6  # seconds after the last waypoint in which an agent may still come nearer to it


@njit(cache=True, nogil=True)
def fly_second(px, py, vx, vy, leg, route, length, v_max, a_max, capture_m):
    """One second of flight along a route in steps of 0.25 s: (east, north, both velocities, waypoints reached)."""
    damping = a_max / v_max
    near = capture_m * capture_m
    step_s = 1.0 / STEPS
    for _ in range(STEPS):
        aim = min(leg, length - 1)
        ex, ey = route[aim, 0] - px, route[aim, 1] - py
        while leg < length and ex * ex + ey * ey <= near:
            leg += 1
            aim = min(leg, length - 1)
            ex, ey = route[aim, 0] - px, route[aim, 1] - py
        ux, uy = thrust(ex, ey, vx, vy, a_max)
        px += step_s * vx
        py += step_s * vy
        vx += step_s * (ux - damping * vx)
        vy += step_s * (uy - damping * vy)
    return px, py, vx, vy, leg


@njit(cache=True, nogil=True)
def lay(start, body, route, length, seconds, shape, cell_m, weights, others, first, trail, legs, gains, lasts):
    """Fly a route from now to the end, and remember the way; returns what it adds to J beside the other agents.

    start : (4,) float                place and velocity, east and north
    body : (4,) float                 v_max, a_max, metres at which a waypoint is reached, radius of view in cells
    route : (K, 2) float, length : int, seconds : int (T), shape : (2,) int64 rows and columns
    weights : (M,) float, others : (M,) int32, seconds of first view by others, T for never
    first : (M,) int32                written: seconds of first view by this agent, T for never
    trail : (T, 4), legs, gains : (T,)   written: place and velocity, waypoints reached and value so far, by second
    lasts : (K + 1,) int64            written: the last second up to which waypoint i has had no say in the flight
    """
    height, width = shape[0], shape[1]
    first[:] = seconds
    px, py, vx, vy = start[0], start[1], start[2], start[3]
    radius = body[3]
    square = radius * radius * (1.0 + 1e-12)
    trail[0, 0], trail[0, 1], trail[0, 2], trail[0, 3] = px, py, vx, vy
    legs[0], gains[0] = 0, 0.0
    lasts[: length + 1] = -1
    lasts[0] = 0
    leg, total, rested = 0, 0.0, 0
    if length > 0:
        lasts[1] = 0
    for k in range(1, seconds):
        if length == 0 or rested > SETTLED:
            break
        px, py, vx, vy, leg = fly_second(px, py, vx, vy, leg, route, length, body[0], body[1], body[2])
        if leg == length:
            rested += 1
        else:
            lasts[leg + 1] = k
        east, north = px / cell_m, py / cell_m
        for up in range(max(math.ceil(north - radius), 0), min(math.floor(north + radius), height - 1) + 1):
            left = square - (up - north) * (up - north)
            half = math.sqrt(left) if left > 0.0 else 0.0
            row = (height - 1 - up) * width
            for right in range(max(math.ceil(east - half), 0), min(math.floor(east + half), width - 1) + 1):
                cell = row + right
                if first[cell] == seconds:
                    first[cell] = k
                    if others[cell] > k:
                        total += weights[cell] * (others[cell] - k)
        trail[k, 0], trail[k, 1], trail[k, 2], trail[k, 3] = px, py, vx, vy
        legs[k], gains[k] = leg, total
    for i in range(1, length + 1):
        if lasts[i] < 0:
            lasts[i] = lasts[i - 1]
    return total


@njit(cache=True, nogil=True)
def worth(
    change, body, route, length, seconds, shape, cell_m, weights, others, first, trail, legs, gains, lasts, marks, mark
):
    """What a route would add to J that is as the one laid up to waypoint `change`; nothing is remembered.

    marks : (M,) int64, written `mark` in cells that come in view after the change. The rest as `lay` left it.
    """
    height, width = shape[0], shape[1]
    begin = lasts[change]
    px, py, vx, vy = trail[begin, 0], trail[begin, 1], trail[begin, 2], trail[begin, 3]
    leg, total = legs[begin], gains[begin]
    radius = body[3]
    square = radius * radius * (1.0 + 1e-12)
    rested = 0
    for k in range(begin + 1, seconds):
        if length == 0 or rested > SETTLED:
            break
        px, py, vx, vy, leg = fly_second(px, py, vx, vy, leg, route, length, body[0], body[1], body[2])
        if leg == length:
            rested += 1
        east, north = px / cell_m, py / cell_m
        for up in range(max(math.ceil(north - radius), 0), min(math.floor(north + radius), height - 1) + 1):
            left = square - (up - north) * (up - north)
            half = math.sqrt(left) if left > 0.0 else 0.0
            row = (height - 1 - up) * width
            for right in range(max(math.ceil(east - half), 0), min(math.floor(east + half), width - 1) + 1):
                cell = row + right
                if marks[cell] != mark:
                    marks[cell] = mark
                    if others[cell] > k and first[cell] > begin:
                        total += weights[cell] * (others[cell] - k)
    return total


@njit(cache=True, nogil=True, inline="always")
def draw(dice):
    """Number in (0, 1); dice : (2,) uint64, a key and how often it was asked."""
    dice[1] += np.uint64(1)
    return high_half(mixed(dice[0], dice[1]))


@njit(cache=True, nogil=True)
def draw_below(dice, n):
    """Whole number from 0 to n - 1."""
    return min(int(draw(dice) * n), n - 1)


@njit(cache=True, nogil=True)
def near(dice, east, north, sigma_m, low, high):
    """A place normally about another, kept on the ground."""
    dice[1] += np.uint64(1)
    word = mixed(dice[0], dice[1])
    length, turn = sigma_m * math.sqrt(-2.0 * math.log(high_half(word))), 2.0 * math.pi * low_half(word)
    east = min(max(east + length * math.cos(turn), low[0]), high[0])
    north = min(max(north + length * math.sin(turn), low[1]), high[1])
    return east, north


@njit(cache=True, nogil=True)
def add_up(weights, others, first, waits):
    """Sums, cell by cell, of weight times seconds until the first view by any agent, written to `waits` (M,)."""
    total = 0.0
    for cell in range(weights.shape[0]):
        total += weights[cell] * min(others[cell], first[cell])
        waits[cell] = total


@njit(cache=True, nogil=True)
def heavy_cell(dice, waits):
    """The heavier of two cells drawn as often as they wait long for their first view, by weight."""
    best, most = 0, -1.0
    for _ in range(2):
        cell = min(np.searchsorted(waits, draw(dice) * waits[-1]), waits.shape[0] - 1)
        value = waits[cell] - (waits[cell - 1] if cell > 0 else 0.0)
        if value > most:
            best, most = cell, value
    return best


@njit(cache=True, nogil=True)
def move(dice, route, length, shape, cell_m, low, high, waits, other):
    """Write a neighbour of a route to `other`; returns its length and its first waypoint that differs.

    shift 50 %, insert 24, delete 10, reverse 10, relocate 6
    """
    most = route.shape[0]
    other[:length] = route[:length]
    what = draw(dice)
    if length == 0 or (what >= 0.76 and length < most):  # insert
        at = draw_below(dice, length + 1)
        if draw(dice) < 0.7 or length == 0 or at == length:
            cell = heavy_cell(dice, waits)
            row = cell // shape[1]
            east, north = near(dice, (cell - row * shape[1]) * cell_m, (shape[0] - 1 - row) * cell_m, cell_m, low, high)
            at, least = 0, np.inf  # where it costs the least way, or anywhere
            if draw(dice) < 0.7:
                for i in range(length + 1):
                    way = 0.0
                    if i > 0:
                        way += math.hypot(route[i - 1, 0] - east, route[i - 1, 1] - north)
                    if i < length:
                        way += math.hypot(route[i, 0] - east, route[i, 1] - north)
                    if 0 < i < length:
                        way -= math.hypot(route[i, 0] - route[i - 1, 0], route[i, 1] - route[i - 1, 1])
                    if way < least:
                        at, least = i, way
            else:
                at = draw_below(dice, length + 1)
        else:
            before = max(at - 1, 0)
            east, north = near(
                dice, 0.5 * (route[before, 0] + route[at, 0]), 0.5 * (route[before, 1] + route[at, 1]), 9.0, low, high
            )
        other[at + 1 : length + 1] = route[at:length]
        other[at, 0], other[at, 1] = east, north
        return length + 1, at
    if what < 0.1 and length > 1:  # delete
        at = draw_below(dice, length)
        other[at : length - 1] = route[at + 1 : length]
        return length - 1, at
    if what < 0.2 and length > 1:  # reverse
        i, j = draw_below(dice, length), draw_below(dice, length)
        i, j = min(i, j), max(i, j)
        for k in range(i, j + 1):
            other[k] = route[i + j - k]
        return length, i
    if what < 0.26 and length > 1:  # relocate
        i, j = draw_below(dice, length), draw_below(dice, length)
        if i < j:
            other[i:j] = route[i + 1 : j + 1]
        else:
            other[j + 1 : i + 1] = route[j:i]
        other[j] = route[i]
        return length, min(i, j)
    at = draw_below(dice, length)  # shift
    scale = draw_below(dice, 3)
    sigma_m = 3.0 if scale == 0 else (9.0 if scale == 1 else 25.0)
    other[at, 0], other[at, 1] = near(dice, route[at, 0], route[at, 1], sigma_m, low, high)
    return length, at


@njit(cache=True, nogil=True)
def least_of(firsts, but, and_but, seconds, others):
    """First views by all agents but two, second by second the least, written to `others`."""
    others[:] = seconds
    for agent in range(firsts.shape[0]):
        if agent != but and agent != and_but:
            row = firsts[agent]
            for cell in range(others.shape[0]):
                others[cell] = min(others[cell], row[cell])


@njit(cache=True, nogil=True)
def crossed(dice, routes, lengths, a, b, one, two):
    """Two routes that exchange their tails, or of which one gives a waypoint to the other; returns their lengths.

    Both lengths are -1 if there is no room.
    """
    n, m, most = lengths[a], lengths[b], routes.shape[1]
    i, j = draw_below(dice, n + 1), draw_below(dice, m + 1)
    if draw(dice) < 0.5:
        if i + m - j > most or j + n - i > most:
            return -1, -1
        one[:i], two[:j] = routes[a, :i], routes[b, :j]
        one[i : i + m - j], two[j : j + n - i] = routes[b, j:m], routes[a, i:n]
        return i + m - j, j + n - i
    if n < 2 or m == most:
        return -1, -1
    i = min(i, n - 1)
    one[:i], one[i : n - 1] = routes[a, :i], routes[a, i + 1 : n]
    two[:j], two[j + 1 : m + 1] = routes[b, :j], routes[b, j:m]
    two[j] = routes[a, i]
    return n - 1, m + 1


@njit(cache=True, nogil=True)
def improve(
    starts, bodies, routes, lengths, seconds, shape, cell_m, low, high, weights, rounds, moves, crossings, dice
):
    """Climb: moves of one agent's route after another, then moves between two; only what raises J is kept.

    starts : (A, 4), bodies : (A, 4), routes : (A, K, 2), lengths : (A,) int64; the last two are changed in place
    weights : (M,) float; low, high : (2,) corners of the ground; dice : (2,) uint64

    Returns J.
    """
    n_agents, most, n_cells = routes.shape[0], routes.shape[1], weights.shape[0]
    firsts = np.empty((n_agents, n_cells), np.int32)
    others, first_one, first_two = (
        np.empty(n_cells, np.int32), np.empty(n_cells, np.int32), np.empty(n_cells, np.int32),
    )  # fmt: skip
    trail, legs, gains = np.empty((seconds, 4)), np.empty(seconds, np.int64), np.empty(seconds)
    lasts, marks, mark = np.empty(most + 2, np.int64), np.full(n_cells, -1), 0
    one, two, waits = np.empty((most, 2)), np.empty((most, 2)), np.empty(n_cells)
    others[:] = seconds
    for a in range(n_agents):
        lay(
            starts[a], bodies[a], routes[a], lengths[a], seconds, shape, cell_m, weights, others, firsts[a],
            trail, legs, gains, lasts,
        )  # fmt: skip
    for _ in range(rounds):
        for a in range(n_agents):
            least_of(firsts, a, a, seconds, others)
            body, first = bodies[a], firsts[a]
            best = lay(
                starts[a], body, routes[a], lengths[a], seconds, shape, cell_m, weights, others, first,
                trail, legs, gains, lasts,
            )  # fmt: skip
            add_up(weights, others, first, waits)
            for _ in range(moves):
                length, change = move(dice, routes[a], lengths[a], shape, cell_m, low, high, waits, one)
                mark += 1
                value = worth(
                    change, body, one, length, seconds, shape, cell_m, weights, others, first, trail, legs, gains,
                    lasts, marks, mark,
                )  # fmt: skip
                if value > best * (1.0 + 1e-9):
                    routes[a, :length], lengths[a] = one[:length], length
                    best = lay(
                        starts[a], body, routes[a], length, seconds, shape, cell_m, weights, others, first,
                        trail, legs, gains, lasts,
                    )  # fmt: skip
                    add_up(weights, others, first, waits)
        for _ in range(crossings if n_agents > 1 else 0):
            a = draw_below(dice, n_agents)
            b = (a + 1 + draw_below(dice, n_agents - 1)) % n_agents
            n, m = crossed(dice, routes, lengths, a, b, one, two)
            if n < 0:
                continue
            least_of(firsts, a, b, seconds, others)
            before = 0.0
            for cell in range(n_cells):
                before += weights[cell] * max(others[cell] - min(firsts[a, cell], firsts[b, cell]), 0)
            value = lay(
                starts[a], bodies[a], one, n, seconds, shape, cell_m, weights, others, first_one,
                trail, legs, gains, lasts,
            )  # fmt: skip
            for cell in range(n_cells):
                others[cell] = min(others[cell], first_one[cell])
            value += lay(
                starts[b], bodies[b], two, m, seconds, shape, cell_m, weights, others, first_two,
                trail, legs, gains, lasts,
            )  # fmt: skip
            if value > before * (1.0 + 1e-9):
                routes[a, :n], lengths[a], firsts[a] = one[:n], n, first_one
                routes[b, :m], lengths[b], firsts[b] = two[:m], m, first_two
    return total_value(firsts, weights, seconds, others)


@njit(cache=True, nogil=True)
def total_value(firsts, weights, seconds, others):
    """J of first views by agent; `others` is room to work in."""
    least_of(firsts, -1, -1, seconds, others)
    total = 0.0
    for cell in range(weights.shape[0]):
        total += weights[cell] * (seconds - others[cell])
    return total


@njit(cache=True, nogil=True)
def value_of(starts, bodies, routes, lengths, seconds, shape, cell_m, weights, alone):
    """J of the routes; `alone` : (A,), written, what each would be worth without the others."""
    n_agents, n_cells = routes.shape[0], weights.shape[0]
    firsts, others = np.empty((n_agents, n_cells), np.int32), np.full(n_cells, seconds, np.int32)
    trail, legs, gains = np.empty((seconds, 4)), np.empty(seconds, np.int64), np.empty(seconds)
    lasts = np.empty(routes.shape[1] + 2, np.int64)
    for a in range(n_agents):
        alone[a] = lay(
            starts[a], bodies[a], routes[a], lengths[a], seconds, shape, cell_m, weights, others, firsts[a],
            trail, legs, gains, lasts,
        )  # fmt: skip
    return total_value(firsts, weights, seconds, others)


@njit(cache=True, nogil=True)
def roll_out(starts, bodies, routes, lengths, seconds, shape, cell_m, low, high, weights, rollouts, waypoints, dice):
    """Agent after agent tries routes of random waypoints beside those of the others; the best it knows is kept.

    routes : (A, K, 2), lengths : (A,) int64, changed in place; rollouts : int, shared out among agents equally
    waypoints : int, of a random route. A waypoint is any place, or one within 40 m of the one before. Returns J.
    """
    n_agents, n_cells = routes.shape[0], weights.shape[0]
    firsts, others = np.empty((n_agents, n_cells), np.int32), np.full(n_cells, seconds, np.int32)
    trail, legs, gains = np.empty((seconds, 4)), np.empty(seconds, np.int64), np.empty(seconds)
    lasts, marks, mark = np.empty(routes.shape[1] + 2, np.int64), np.full(n_cells, -1), 0
    one = np.empty((waypoints, 2))
    for a in range(n_agents):
        lay(
            starts[a], bodies[a], routes[a], lengths[a], seconds, shape, cell_m, weights, others, firsts[a],
            trail, legs, gains, lasts,
        )  # fmt: skip
    for a in range(n_agents):
        least_of(firsts, a, a, seconds, others)
        best = lay(
            starts[a], bodies[a], routes[a], lengths[a], seconds, shape, cell_m, weights, others, firsts[a],
            trail, legs, gains, lasts,
        )  # fmt: skip
        for _ in range(rollouts // n_agents):
            east, north = starts[a, 0], starts[a, 1]
            for i in range(waypoints):
                if draw(dice) < 0.2:
                    east, north = (
                        low[0] + draw(dice) * (high[0] - low[0]), low[1] + draw(dice) * (high[1] - low[1]),
                    )  # fmt: skip
                else:
                    east, north = near(dice, east, north, 25.0, low, high)
                one[i, 0], one[i, 1] = east, north
            mark += 1
            value = worth(
                0, bodies[a], one, waypoints, seconds, shape, cell_m, weights, others, firsts[a], trail, legs, gains,
                lasts, marks, mark,
            )  # fmt: skip
            if value > best * (1.0 + 1e-9):
                best = value
                routes[a, :waypoints], lengths[a] = one, waypoints
        lay(
            starts[a], bodies[a], routes[a], lengths[a], seconds, shape, cell_m, weights, others, firsts[a],
            trail, legs, gains, lasts,
        )  # fmt: skip
    return total_value(firsts, weights, seconds, others)


@njit(cache=True, nogil=True)
def drift(shares, void, height, width, steps, least, around, sent):
    """The target may have moved to a cell beside: its share of each cell spreads over the streets that may be there.

    r'_c = r_c / 2 + (1 / 2) sum over the eight j beside c of b_j / max(sum of 1 - v around j, least),  b = r (1 - v)

    shares : (M,) float, r, changed in place so that b totals one; void : (M,) float, v; around, sent : (M,) room
    """
    for _ in range(steps):
        total = 0.0
        for row in range(height):
            for col in range(width):
                held = 0.0
                for r in range(max(row - 1, 0), min(row + 1, height - 1) + 1):
                    for c in range(max(col - 1, 0), min(col + 1, width - 1) + 1):
                        held += 1.0 - void[r * width + c]
                cell = row * width + col
                held -= 1.0 - void[cell]
                around[cell] = held
                sent[cell] = shares[cell] * (1.0 - void[cell]) / max(held, least)
        for row in range(height):
            for col in range(width):
                came = 0.0
                for r in range(max(row - 1, 0), min(row + 1, height - 1) + 1):
                    for c in range(max(col - 1, 0), min(col + 1, width - 1) + 1):
                        came += sent[r * width + c]
                cell = row * width + col
                shares[cell] = 0.5 * shares[cell] + 0.5 * (came - sent[cell])
                total += shares[cell] * (1.0 - void[cell])
        if total > 0.0:
            for cell in range(shares.shape[0]):
                shares[cell] /= total


@njit(cache=True, nogil=True)
def look(shares, cells, target_ratios):
    """Bayes' law for the target's shares: cells : (k,) int, target_ratios : (k,) P(level | target) / without."""
    for i in range(cells.shape[0]):
        shares[cells[i]] = max(shares[cells[i]] * target_ratios[i], LEAST)


@njit(cache=True, nogil=True)
def weigh(void, nodes, shares, weight, weights):
    """w = n / N + weight b: what it is worth to see each cell a second sooner, written to `weights`.

    n = 1 - v in cells without a detected node, N the nodes detected and those expected, b = r (1 - v) / sum r (1 - v)
    """
    expected, held = 0.0, 0.0
    for cell in range(void.shape[0]):
        expected += 1.0 if nodes[cell] else 1.0 - void[cell]
        held += shares[cell] * (1.0 - void[cell])
    expected, weight = max(expected, 1e-9), weight / max(held, LEAST)
    for cell in range(void.shape[0]):
        here = 0.0 if nodes[cell] else (1.0 - void[cell]) / expected
        weights[cell] = here + weight * shares[cell] * (1.0 - void[cell])
