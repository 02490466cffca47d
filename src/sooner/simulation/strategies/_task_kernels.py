"""Compiled waypoint tasks: where they lie, what a flight to each is worth, and who takes which.

Cell `row * width + col` of `cell_m` has its centre `col` cells east and `height - 1 - row` north of the origin.
"""

import math

import numpy as np
from numba import njit

from sooner.simulation._flight_kernels import fly_to

NONE = -1.0  # the utility of what must not be chosen: below any that can be
NEXT_TO_NOTHING = 1e-9  # bits by which, of flights that are worth nothing, the shortest is chosen


@njit(cache=True, nogil=True)
def nearest_sites(sites, height, width, cell_m, reach, owner):
    """The site nearest to each cell's centre; the first of equals.

    sites : (n, 2) float; owner : (M,) int32, written; reach : (height,) float, metres within which every cell of a row
    is known to have a site; how far the farthest has it is written. A row at a time, which the compiler vectorises.
    """
    easts, best, own = np.empty(width, np.float32), np.empty(width, np.float32), np.empty(width, np.int32)
    for col in range(width):
        easts[col] = col * cell_m
    for row in range(height):
        north = (height - 1 - row) * cell_m
        best[:] = np.inf
        for site in range(sites.shape[0]):
            if abs(sites[site, 1] - north) > reach[row]:
                continue
            east, up = np.float32(sites[site, 0]), np.float32((sites[site, 1] - north) ** 2)
            for col in range(width):
                apart = (easts[col] - east) * (easts[col] - east) + up
                nearer = apart < best[col]
                best[col] = apart if nearer else best[col]
                own[col] = site if nearer else own[col]
        reach[row] = math.sqrt(best.max())
        owner[row * width : (row + 1) * width] = own


@njit(cache=True, nogil=True)
def lloyd(density, height, width, cell_m, gain, most, near_m, sites, owner, middles):
    """Move every site a share of the way to its cells' centre of mass, until all are near theirs; returns the rounds.

    density : (M,) float, above 0; gain : the share; most : rounds; near_m : how near is near, on average over sites;
    sites : (n, 2) float, changed in place; owner : (M,) int32 and middles : (n, 2), the centres of mass, written.
    """
    n = sites.shape[0]
    mass, reach = np.empty(n), np.full(height, np.inf)
    for rounds in range(1, most + 1):
        nearest_sites(sites, height, width, cell_m, reach, owner)
        mass[:], middles[:] = 0.0, 0.0
        for row in range(height):
            north = (height - 1 - row) * cell_m
            for col in range(width):
                cell = row * width + col
                site, weight = owner[cell], density[cell]
                mass[site] += weight
                middles[site, 0] += weight * (col * cell_m)
                middles[site, 1] += weight * north
        off, farthest = 0.0, 0.0
        for site in range(n):
            if mass[site] > 0.0:
                middles[site, 0] /= mass[site]
                middles[site, 1] /= mass[site]
            else:
                middles[site, 0], middles[site, 1] = sites[site, 0], sites[site, 1]
            east, north = middles[site, 0] - sites[site, 0], middles[site, 1] - sites[site, 1]
            apart = math.sqrt(east * east + north * north)
            off += apart
            farthest = max(farthest, apart)
            sites[site, 0] += gain * east
            sites[site, 1] += gain * north
        if off <= near_m * n:
            return rounds
        reach += gain * farthest + 1e-3  # no site has moved farther, but for rounding
    return most


@njit(cache=True, nogil=True)
def most_valuable(utilities, chosen):
    """Give each row a column of its own so that the total utility is largest: the Hungarian method.

    utilities : (n, m) float, n <= m; chosen : (n,) int64, the column of each row, written.
    One row after another joins; prices of rows and columns keep each reduced cost at 0 or above, and a shortest path
    over reduced costs tells which rows must change columns.
    """
    n, m = utilities.shape
    row_price, price = np.zeros(n), np.zeros(m)
    holder, came_from = np.full(m, -1), np.empty(m, np.int64)
    cost, done = np.empty(m), np.empty(m, np.bool_)
    for new in range(n):
        cost[:], done[:], came_from[:] = np.inf, False, -1
        row, column, total = new, -1, 0.0
        while True:
            nearest = -1
            for j in range(m):
                if done[j]:
                    continue
                reached = total - utilities[row, j] - row_price[row] - price[j]
                if reached < cost[j]:
                    cost[j], came_from[j] = reached, column
                if nearest < 0 or cost[j] < cost[nearest]:
                    nearest = j
            column, total = nearest, cost[nearest]
            if holder[column] < 0:
                break
            done[column] = True
            row = holder[column]
        row_price[new] += total
        for j in range(m):
            if done[j]:
                row_price[holder[j]] += total - cost[j]
                price[j] -= total - cost[j]
        while column >= 0:
            before = came_from[column]
            holder[column] = holder[before] if before >= 0 else new
            column = before
    for j in range(m):
        if holder[j] >= 0:
            chosen[holder[j]] = j


@njit(cache=True, nogil=True)
def highest_in_view(east, north, radius, left, share, height, width):
    """The most that a look teaches of one cell whose centre is within the radius of a place; 0 if there is none.

    east, north, radius : in cells; left : (M,) bits to be learnt; share : (M,) what one look takes of them
    """
    highest = 0.0
    square = radius * radius * (1.0 + 1e-12)
    for up in range(max(math.ceil(north - radius), 0), min(math.floor(north + radius), height - 1) + 1):
        rest = square - (up - north) * (up - north)
        half = math.sqrt(rest) if rest > 0.0 else 0.0
        row = (height - 1 - up) * width
        for right in range(max(math.ceil(east - half), 0), min(math.floor(east + half), width - 1) + 1):
            highest = max(highest, left[row + right] * share[row + right])
    return highest


@njit(cache=True, nogil=True)
def taught_in_view(east, north, radius, left, share, height, width, mark, marks, now):
    """What a look teaches of all cells in view, as in `highest_in_view`, after those that bear the same mark.

    marks : (M,) int64 and now : (M,) float, what is left of cells that bear the mark; both written
    """
    total = 0.0
    square = radius * radius * (1.0 + 1e-12)
    for up in range(max(math.ceil(north - radius), 0), min(math.floor(north + radius), height - 1) + 1):
        rest = square - (up - north) * (up - north)
        half = math.sqrt(rest) if rest > 0.0 else 0.0
        row = (height - 1 - up) * width
        for right in range(max(math.ceil(east - half), 0), min(math.floor(east + half), width - 1) + 1):
            cell = row + right
            if marks[cell] != mark:
                marks[cell], now[cell] = mark, left[cell]
            taught = now[cell] * share[cell]
            now[cell] -= taught
            total += taught
    return total


@njit(cache=True, nogil=True)
def _nearest_tasks(east, north, tasks, taken, n_near, near):
    """Up to `n_near` of the tasks not taken, the nearest first; returns how many."""
    n = tasks.shape[0]
    apart = np.empty(n)
    for task in range(n):
        apart[task] = np.inf if taken[task] else (tasks[task, 0] - east) ** 2 + (tasks[task, 1] - north) ** 2
    for k in range(n_near):
        best = apart.argmin()
        if apart[best] == np.inf:
            return k
        near[k] = best
        apart[best] = np.inf
    return n_near


@njit(cache=True, nogil=True)
def assign(
    places, velocities, v_max, a_max, radius_m, arrive_m, tasks, own, left, shares, kinds, height, width, cell_m,
    n_near, utility, step_s, routes,
):  # fmt: skip
    """Waypoints one step after another: at each, the agents share the tasks so that the total utility is largest.

    places, velocities : (A, 2); v_max, a_max, radius_m, arrive_m : (A,); tasks : (n, 2); own : (A,) int64, a task that
    is no candidate of an agent's first step; left : (M,), bits to be learnt of each cell, from which what looks along
    chosen flights take is removed; shares : (K, M), what one look of each kind takes; kinds : (A,) int64, whose looks
    are of which kind; utility : int, over the seconds of the way, of what looks along it teach of cells in view: the
    largest (0), the sum of each look's largest (1) or the sum over cells (2); routes : (A, steps, 2), written.
    """
    n_agents, n_tasks = places.shape[0], tasks.shape[0]
    trace, marks, now = np.empty((512, 2)), np.full(left.shape[0], -1), np.empty(left.shape[0])
    utilities, taken, near = np.empty((n_agents, n_tasks)), np.zeros(n_tasks, np.bool_), np.empty(n_near, np.int64)
    chosen = np.empty(n_agents, np.int64)
    states = np.empty((n_agents, 4))
    states[:, :2], states[:, 2:] = places, velocities
    mark = 0
    for step in range(routes.shape[1]):
        utilities[:] = 0.0
        for agent in range(n_agents):
            for task in range(n_tasks):
                if taken[task]:
                    utilities[agent, task] = NONE
            excluded = step == 0 and not taken[own[agent]]
            if excluded:
                taken[own[agent]] = True
            x, y, vx, vy = states[agent]
            share, radius = shares[kinds[agent]], radius_m[agent] / cell_m
            highest = (left * share).max()
            for k in range(_nearest_tasks(x, y, tasks, taken, n_near, near)):
                task = near[k]
                seconds, n_seen, _, _, _, _ = fly_to(
                    x, y, vx, vy, tasks[task, 0], tasks[task, 1], v_max[agent], a_max[agent], arrive_m[agent],
                    float(trace.shape[0]), step_s, 1.0, trace,
                )  # fmt: skip
                worth = 0.0
                for i in range(n_seen):
                    east, north = trace[i, 0] / cell_m, trace[i, 1] / cell_m
                    if utility == 2:
                        worth += taught_in_view(east, north, radius, left, share, height, width, mark, marks, now)
                    elif utility == 1:
                        worth += highest_in_view(east, north, radius, left, share, height, width)
                    elif worth < highest:
                        worth = max(worth, highest_in_view(east, north, radius, left, share, height, width))
                mark += 1
                utilities[agent, task] = (worth + NEXT_TO_NOTHING) / max(seconds, 1.0)
            if excluded:
                taken[own[agent]] = False
        most_valuable(utilities, chosen)
        for agent in range(n_agents):
            task = chosen[agent]
            taken[task] = True
            routes[agent, step, 0], routes[agent, step, 1] = tasks[task, 0], tasks[task, 1]
            x, y, vx, vy = states[agent]
            _, n_seen, x, y, vx, vy = fly_to(
                x, y, vx, vy, tasks[task, 0], tasks[task, 1], v_max[agent], a_max[agent], arrive_m[agent],
                float(trace.shape[0]), step_s, 1.0, trace,
            )  # fmt: skip
            states[agent, 0], states[agent, 1], states[agent, 2], states[agent, 3] = x, y, vx, vy
            share, radius = shares[kinds[agent]], radius_m[agent] / cell_m
            for i in range(n_seen):
                _learn(trace[i, 0] / cell_m, trace[i, 1] / cell_m, radius, left, share, height, width)


@njit(cache=True, nogil=True)
def _learn(east, north, radius, left, share, height, width):
    """A look takes its share of what is left of cells in view."""
    square = radius * radius * (1.0 + 1e-12)
    for up in range(max(math.ceil(north - radius), 0), min(math.floor(north + radius), height - 1) + 1):
        rest = square - (up - north) * (up - north)
        half = math.sqrt(rest) if rest > 0.0 else 0.0
        row = (height - 1 - up) * width
        for right in range(max(math.ceil(east - half), 0), min(math.floor(east + half), width - 1) + 1):
            left[row + right] -= left[row + right] * share[row + right]
