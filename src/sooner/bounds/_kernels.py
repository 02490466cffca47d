"""Kernels of the connected-subgraph bound: arrays and scalars in and out, no validation.

Letters, as in `connected_subgraph`: N cells, D directions, arc (v, d) enters cell v from u = neighbours[v, d];
lam and mu are the multipliers; a cut c is the set of arcs that enter some set of cells, listed as v D + d in
`cut_arc[cut_ptr[c]:cut_ptr[c + 1]]`, charged to the cell `cut_cell[c]` of that set at the price `cut_price[c]`.
"""

import math

import numpy as np
from numba import njit

LONG_TAIL = 64  # looks beyond the table that are summed one by one; the rest is rounded up


@njit(cache=True, nogil=True)
def reverse_slots(neighbours):
    """(N, D) int8: slot of v in the row of its neighbour, so that arc v -> x is (x, reverse[v, d]); -1 if none."""
    n, degree = neighbours.shape
    reverse = np.full((n, degree), -1, np.int8)
    for v in range(n):
        for d in range(degree):
            x = neighbours[v, d]
            if x >= 0:
                for e in range(degree):
                    if neighbours[x, e] == v:
                        reverse[v, d] = e
    return reverse


@njit(cache=True, nogil=True)
def _repeats(row, ratio, first, price, most):
    """Profit of looks first, first + 1, ... that pay more than `price`; at most `most` of them."""
    length = row.shape[0]
    gain = row[min(first, length) - 1]
    for _ in range(length, first):  # several searchers that start on one cell
        gain *= ratio
    profit = 0.0
    for count in range(most):
        k = first + count
        gain = row[k] if k < length else gain * ratio
        if gain <= price:
            return profit
        if k >= length + LONG_TAIL:
            return profit + (most - count) * (gain - price)
        profit += gain - price
    return profit


@njit(cache=True, nogil=True)
def price_arcs(
    neighbours, table, ratio, free, steps, hover, mu, lam, cut_ptr, cut_arc, cut_cell, cut_price, n_cuts,
    cost, prize,
):  # fmt: skip
    """Reduced costs >= 0 of the arcs and prizes >= 0 of the cells that the multipliers leave; returns the rest.

    rest + sum of prizes is a bound, up to the end cells' potential.
    """
    n, degree = neighbours.shape
    for v in range(n):
        prize[v] = 0.0
        for d in range(degree):
            u = neighbours[v, d]
            cost[v, d] = mu - lam[v] + lam[u] if u >= 0 else np.inf
    for c in range(n_cuts):
        y = cut_price[c]
        if y > 0.0:
            prize[cut_cell[c]] -= y
            for i in range(cut_ptr[c], cut_ptr[c + 1]):
                a = cut_arc[i]
                v = a // degree
                cost[v, a - v * degree] -= y
    rest = mu * steps
    for v in range(n):
        cheapest = mu if hover else np.inf
        for d in range(degree):
            u = neighbours[v, d]
            if u >= 0:
                cheapest = min(cheapest, mu - lam[v] + lam[u])
        profit = _repeats(table[v], ratio[v], max(free[v], 1), cheapest, steps) if cheapest < np.inf else 0.0
        if free[v] > 0:  # a start: looked at for nothing, never entered first
            rest += profit + free[v] * lam[v]
            gain = table[v, 0]
            for k in range(free[v]):
                gain = table[v, k] if k < table.shape[1] else gain * ratio[v]
                rest += gain
            prize[v] = 0.0
            cost[v, :] = np.inf
            continue
        least = np.inf
        for d in range(degree):
            least = min(least, cost[v, d])
        if least == np.inf:
            prize[v] = 0.0
            continue
        worth = table[v, 0] + profit + prize[v] - least
        prize[v] = max(worth, 0.0)
        for d in range(degree):
            cost[v, d] = cost[v, d] - least + max(-worth, 0.0)
    return rest


@njit(cache=True, nogil=True)
def _push(key, item, size, k, v):
    i = size
    while i > 0:
        parent = (i - 1) >> 1
        if key[parent] <= k:
            break
        key[i] = key[parent]
        item[i] = item[parent]
        i = parent
    key[i] = k
    item[i] = v
    return size + 1


@njit(cache=True, nogil=True)
def _pop(key, item, size):
    size -= 1
    k, v = key[size], item[size]
    i = 0
    while True:
        child = 2 * i + 1
        if child >= size:
            break
        if child + 1 < size and key[child + 1] < key[child]:
            child += 1
        if key[child] >= k:
            break
        key[i] = key[child]
        item[i] = item[child]
        i = child
    key[i] = k
    item[i] = v
    return size


@njit(cache=True, nogil=True)
def _reach_from(x, neighbours, reverse, cost, reached, stack):
    """Mark all that can be reached from x over arcs of no cost."""
    reached[x] = True
    stack[0] = x
    size = 1
    while size > 0:
        size -= 1
        u = stack[size]
        for d in range(neighbours.shape[1]):
            v = neighbours[u, d]
            if v >= 0 and not reached[v] and cost[v, reverse[u, d]] == 0.0:
                reached[v] = True
                stack[size] = v
                size += 1


@njit(cache=True, nogil=True)
def start_ascent(neighbours, reverse, free, cost, prize, state, reached, key, item, mark, queue):
    """Queue every cell with a prize that no start reaches at no cost. state = (queued, tick, scans)."""
    n = neighbours.shape[0]
    reached[:] = False
    mark[:] = 0
    for v in range(n):
        if free[v] > 0 and not reached[v]:
            _reach_from(v, neighbours, reverse, cost, reached, queue)
    size = 0
    for v in range(n):
        if prize[v] > 0.0 and not reached[v]:
            size = _push(key, item, size, 1.0, v)
    state[0] = size
    state[1] = 0


@njit(cache=True, nogil=True)
def ascend(
    neighbours, reverse, cost, prize, patience, budget, state, reached, key, item, mark, queue, arcs,
    cut_ptr, cut_arc, cut_cell, cut_price, n_cuts, smallest,
):  # fmt: skip
    """Wong's dual ascent: raise the price of the arcs into the set of cells that can reach a prize at no cost.

    Smallest sets first; a set that has grown to `patience` times the next in the queue goes back into it. Stops
    after `budget` scans, to be called again until state[0] == 0. Cuts raised by more than `smallest` are kept, while
    there is room; returns their number.
    """
    degree = neighbours.shape[1]
    size, tick = state[0], state[1]
    scans = 0
    while size > 0 and scans < budget:
        v, known = item[0], key[0]
        size = _pop(key, item, size)
        if reached[v] or prize[v] <= 0.0:
            continue
        tick += 1
        mark[v] = tick
        queue[0] = v
        grown, seen, n_arcs, hit = 1, 0, 0, False
        while True:
            while seen < grown and not hit:
                x = queue[seen]
                seen += 1
                for d in range(degree):
                    u = neighbours[x, d]
                    if u < 0 or mark[u] == tick:
                        continue
                    if cost[x, d] == 0.0:
                        if reached[u]:
                            hit = True
                            break
                        mark[u] = tick
                        queue[grown] = u
                        grown += 1
                    elif cost[x, d] < np.inf:
                        arcs[n_arcs] = x * degree + d
                        n_arcs += 1
            scans += seen
            if hit:
                break
            if size > 0 and grown > patience * key[0] + 4 and grown > known:
                size = _push(key, item, size, float(grown), v)
                break
            raise_by, kept = np.inf, 0
            for i in range(n_arcs):
                a = arcs[i]
                x = a // degree
                d = a - x * degree
                if mark[neighbours[x, d]] != tick:
                    arcs[kept] = a
                    kept += 1
                    raise_by = min(raise_by, cost[x, d])
            n_arcs = kept
            scans += n_arcs
            if raise_by >= prize[v]:
                raise_by = prize[v]
                prize[v] = 0.0
            else:
                prize[v] -= raise_by
            if raise_by > smallest and n_cuts < cut_cell.shape[0] and cut_ptr[n_cuts] + n_arcs <= cut_arc.shape[0]:
                first = cut_ptr[n_cuts]
                for i in range(n_arcs):
                    cut_arc[first + i] = arcs[i]
                cut_ptr[n_cuts + 1] = first + n_arcs
                cut_cell[n_cuts] = v
                cut_price[n_cuts] = raise_by
                n_cuts += 1
            kept = 0
            for i in range(n_arcs):
                a = arcs[i]
                x = a // degree
                d = a - x * degree
                left = cost[x, d] - raise_by
                cost[x, d] = left
                if left > 0.0:
                    arcs[kept] = a
                    kept += 1
                    continue
                u = neighbours[x, d]
                if mark[u] != tick:
                    hit = hit or reached[u]
                    mark[u] = tick
                    queue[grown] = u
                    grown += 1
            n_arcs = kept
            if hit or prize[v] <= 0.0:
                break
        if hit:
            _join(grown, neighbours, reverse, cost, reached, queue)
    state[0], state[1] = size, tick
    state[2] += scans
    return n_cuts


@njit(cache=True, nogil=True)
def _join(grown, neighbours, reverse, cost, reached, queue):
    """The set in the queue has been reached: so has all that it reaches."""
    members = queue[:grown].copy()
    for x in members:
        if reached[x]:
            continue
        for d in range(neighbours.shape[1]):
            u = neighbours[x, d]
            if u >= 0 and cost[x, d] == 0.0 and reached[u]:
                _reach_from(x, neighbours, reverse, cost, reached, queue)
                break


@njit(cache=True, nogil=True)
def _smoothed(
    neighbours, table, ratio, free, ends, n_open, steps, hover, mu, lam,
    cut_ptr, cut_arc, cut_cell, cut_price, n_cuts, tau, cost, charged, g, g_cut, flow, visited,
):  # fmt: skip
    """The bound at these multipliers, and the slope of its smoothing by tau (soft maxima over each cell's arcs)."""
    n, degree = neighbours.shape
    for v in range(n):
        charged[v] = 0.0
        g[v] = free[v] - ends[v]
        for d in range(degree):
            u = neighbours[v, d]
            cost[v, d] = mu - lam[v] + lam[u] if u >= 0 else np.inf
            flow[v, d] = 0.0
        visited[v] = 0.0
    for c in range(n_cuts):
        y = cut_price[c]
        if y > 0.0:
            charged[cut_cell[c]] += y
            for i in range(cut_ptr[c], cut_ptr[c + 1]):
                a = cut_arc[i]
                v = a // degree
                cost[v, a - v * degree] -= y
    bound, g_mu = mu * steps, float(steps)
    lowest = np.min(lam)
    if n_open > 0:
        total = 0.0
        for v in range(n):
            if lam[v] < lowest + 20.0 * tau:
                total += math.exp((lowest - lam[v]) / tau)
        for v in range(n):
            if lam[v] < lowest + 20.0 * tau:
                g[v] -= n_open * math.exp((lowest - lam[v]) / tau) / total
        bound -= n_open * lowest
    soft = np.empty(degree)
    for v in range(n):
        cheapest = mu if hover else np.inf
        for d in range(degree):
            u = neighbours[v, d]
            if u >= 0:
                cheapest = min(cheapest, mu - lam[v] + lam[u])
        first = max(free[v], 1)
        profit = 0.0
        if cheapest < np.inf:
            profit = _repeats(table[v], ratio[v], first, cheapest, steps)
            gain = table[v, min(first, table.shape[1]) - 1]
            for k in range(first, first + min(steps, 8)):
                gain = table[v, k] if k < table.shape[1] else gain * ratio[v]
                if gain <= cheapest - 16.0 * tau:
                    break
                top = max(0.0, gain - cheapest)
                total = math.exp(-top / tau)
                still = math.exp((gain - mu - top) / tau) if hover else 0.0
                total += still
                for d in range(degree):
                    u = neighbours[v, d]
                    if u >= 0:
                        soft[d] = math.exp((gain - mu + lam[v] - lam[u] - top) / tau)
                        total += soft[d]
                g_mu -= still / total
                for d in range(degree):
                    u = neighbours[v, d]
                    if u >= 0:
                        share = soft[d] / total
                        g[v] += share
                        g[u] -= share
                        g_mu -= share
        if free[v] > 0:
            bound += profit + free[v] * lam[v]
            gain = table[v, 0]
            for k in range(free[v]):
                gain = table[v, k] if k < table.shape[1] else gain * ratio[v]
                bound += gain
            continue
        least = np.inf
        for d in range(degree):
            least = min(least, cost[v, d])
        if least == np.inf:
            continue
        worth = table[v, 0] + profit - charged[v] - least
        bound += max(worth, 0.0)
        if worth < -16.0 * tau:
            continue
        top = max(worth, 0.0)
        total = math.exp(-top / tau)
        for d in range(degree):
            soft[d] = math.exp((worth + least - cost[v, d] - top) / tau) if cost[v, d] < np.inf else 0.0
            total += soft[d]
        for d in range(degree):
            share = soft[d] / total
            if share > 0.0:
                flow[v, d] = share
                visited[v] += share
                g[v] += share
                g[neighbours[v, d]] -= share
                g_mu -= share
    for v in range(n):
        if ends[v] > 0:
            bound -= ends[v] * lam[v]
    for c in range(n_cuts):
        slack = -visited[cut_cell[c]]
        for i in range(cut_ptr[c], cut_ptr[c + 1]):
            a = cut_arc[i]
            v = a // degree
            slack += flow[v, a - v * degree]
        g_cut[c] = slack
    return bound, g_mu


@njit(cache=True, nogil=True)
def descend(
    neighbours, table, ratio, free, ends, n_open, steps, hover, price, lam, moments,
    cut_ptr, cut_arc, cut_cell, cut_price, cut_moments, n_cuts, tau, rate, iterations, mean_flow, mean_visited,
):  # fmt: skip
    """Adam on the smoothed bound, in lam, the cuts' prices and mu together. Returns the least bound met.

    price = (mu, first moment, second moment, iterations so far); moments (2, N); cut_moments (2, cuts). The shares
    in which arcs are used and cells visited are averaged into mean_flow (N, D) and mean_visited (N,).
    """
    n, degree = neighbours.shape
    cost, flow = np.empty((n, degree)), np.empty((n, degree))
    charged, visited, g, g_cut = np.empty(n), np.empty(n), np.empty(n), np.empty(n_cuts)
    best = np.inf
    for _ in range(iterations):
        bound, g_mu = _smoothed(
            neighbours, table, ratio, free, ends, n_open, steps, hover, price[0], lam,
            cut_ptr, cut_arc, cut_cell, cut_price, n_cuts, tau, cost, charged, g, g_cut, flow, visited,
        )  # fmt: skip
        best = min(best, bound)
        for v in range(n):
            mean_visited[v] += 0.05 * (visited[v] - mean_visited[v])
            for d in range(degree):
                mean_flow[v, d] += 0.05 * (flow[v, d] - mean_flow[v, d])
        price[3] += 1.0
        fresh, slow = 1.0 - 0.9 ** price[3], 1.0 - 0.99 ** price[3]
        for v in range(n):
            moments[0, v] = 0.9 * moments[0, v] + 0.1 * g[v]
            moments[1, v] = 0.99 * moments[1, v] + 0.01 * g[v] * g[v]
            if moments[0, v] != 0.0:
                lam[v] -= rate * moments[0, v] / fresh / (math.sqrt(moments[1, v] / slow) + 0.05)
        for c in range(n_cuts):
            cut_moments[0, c] = 0.9 * cut_moments[0, c] + 0.1 * g_cut[c]
            cut_moments[1, c] = 0.99 * cut_moments[1, c] + 0.01 * g_cut[c] * g_cut[c]
            move = rate * cut_moments[0, c] / fresh / (math.sqrt(cut_moments[1, c] / slow) + 0.05)
            cut_price[c] = max(0.0, cut_price[c] - move)
        price[1] = 0.9 * price[1] + 0.1 * g_mu
        price[2] = 0.99 * price[2] + 0.01 * g_mu * g_mu
        price[0] = max(0.0, price[0] - 0.1 * rate * price[1] / fresh / (math.sqrt(price[2] / slow) + 1e-3))
    return best


@njit(cache=True, nogil=True)
def reduced_distances(neighbours, reverse, free, cost, limit):
    """(N,) float: cheapest way from a start to each cell over reduced costs; inf beyond `limit`."""
    n, degree = neighbours.shape
    distance = np.full(n, np.inf)
    settled = np.zeros(n, np.bool_)
    key, item = np.empty(n * degree + n), np.empty(n * degree + n, np.int32)
    size = 0
    for v in range(n):
        if free[v] > 0:
            distance[v] = 0.0
            size = _push(key, item, size, 0.0, v)
    while size > 0:
        u, near = item[0], key[0]
        size = _pop(key, item, size)
        if settled[u]:
            continue
        settled[u] = True
        for d in range(degree):
            v = neighbours[u, d]
            if v < 0 or settled[v]:
                continue
            far = near + cost[v, reverse[u, d]]
            if far < distance[v] and far <= limit:
                distance[v] = far
                size = _push(key, item, size, far, v)
    return distance


@njit(cache=True, nogil=True)
def separate(
    neighbours, reverse, free, flow, visited, order, tolerance, nested, budget, room,
    cut_ptr, cut_arc, cut_cell, cut_price, n_cuts,
):  # fmt: skip
    """Find sets that less flow enters than one of their cells is visited: minimum cuts from the starts to cells.

    Cells are tried in `order`; once cut off, the arcs of the cut are widened to find up to `nested` further cuts.
    Stops after `budget` scans or `room` new cuts, which get price 0. Returns their number in all, and how far in
    `order` it came.
    """
    n, degree = neighbours.shape
    width = flow.copy()
    left = np.empty((n, degree))
    left[:] = width
    touched = np.empty(n, np.int32)
    toward, slot = np.empty(n, np.int32), np.empty(n, np.int32)
    queue, mark = np.empty(n, np.int32), np.zeros(n, np.int64)
    dirty = np.zeros(n, np.bool_)
    covered = np.zeros(n, np.bool_)
    tick, scans, last = 0, 0, n_cuts + room
    for position in range(order.shape[0]):
        target = order[position]
        if covered[target] or free[target] > 0:
            continue
        if scans > budget or n_cuts >= last:
            return n_cuts, position
        for _ in range(nested):
            n_touched, sent, grown = 0, 0.0, 0
            start = -1
            while sent < visited[target] - tolerance:
                tick += 1
                queue[0], mark[target] = target, tick
                grown, seen, start = 1, 0, -1
                while seen < grown and start < 0:
                    x = queue[seen]
                    seen += 1
                    for d in range(degree):
                        u = neighbours[x, d]
                        if u >= 0 and mark[u] != tick and left[x, d] > 1e-7:
                            mark[u], toward[u], slot[u] = tick, x, d
                            queue[grown] = u
                            grown += 1
                            if free[u] > 0:
                                start = u
                                break
                scans += seen
                if start < 0:
                    break
                push = visited[target] - sent
                u = start
                while u != target:
                    push = min(push, left[toward[u], slot[u]])
                    u = toward[u]
                u = start
                while u != target:
                    x = toward[u]
                    left[x, slot[u]] -= push
                    left[u, reverse[x, slot[u]]] += push
                    for w in (np.int64(u), np.int64(x)):
                        if not dirty[w]:
                            dirty[w] = True
                            touched[n_touched] = w
                            n_touched += 1
                    u = x
                sent += push
            for i in range(n_touched):
                left[touched[i]] = width[touched[i]]
                dirty[touched[i]] = False
            if start >= 0 or sent >= visited[target] - tolerance:
                break
            entering, first = 0.0, cut_ptr[n_cuts]
            size = first
            payer = target
            for i in range(grown):
                x = queue[i]
                if visited[x] > visited[payer]:
                    payer = x
                for d in range(degree):
                    u = neighbours[x, d]
                    if u >= 0 and mark[u] != tick:
                        entering += flow[x, d]
                        if size < cut_arc.shape[0]:
                            cut_arc[size] = x * degree + d
                        size += 1
                        width[x, d] = 1.0
                        left[x, d] = 1.0
            if n_cuts >= cut_cell.shape[0] or size > cut_arc.shape[0]:
                return n_cuts, position
            for i in range(grown):
                covered[queue[i]] = True
            if entering < visited[payer] - tolerance:
                cut_ptr[n_cuts + 1] = size
                cut_cell[n_cuts] = payer
                cut_price[n_cuts] = 0.0
                n_cuts += 1
    return n_cuts, order.shape[0]
