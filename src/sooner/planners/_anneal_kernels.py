"""Compiled moves of the `anneal` planner: plain arrays in, plain arrays out.

A walk being annealed is a doubly linked list, so that an edit costs what the edit touches and not what the
walk is long:

nodes : (T + 9, 3) int32       cell, next node, node before; node 0 is the start; rows 0 .. size - 1 are in use
looks : (N, 2) int32           looks at the cell, and a node that may stand on it (a hint, checked when used)
state : (4,) int64             two words of random state, size of the list, and its last node
gains : (N, K) float64         the first K looks; later ones shrink by `ratio` (N,)
neighbours : (N, D) int32      -1 where there is none
where : (N, 2) int32           coordinates in which `_apart` is a lower bound of the steps between two cells
"""

import math

from sooner.planners._random_kernels import below, draw, kernel, uniform

CELL, NEXT, BEFORE = 0, 1, 2
SIZE, TAIL = 2, 3
FAILED = -1e300


@kernel
def _gain(gains, ratio, cell, look):
    """What look number `look` (0 is the first) pays at the cell."""
    last = gains.shape[1] - 1
    if look <= last:
        return gains[cell, look]
    return gains[cell, last] * ratio[cell] ** (look - last)


@kernel
def _apart(where, slots, i, j):
    """Steps between two cells were there no obstacles: L1, Chebyshev or hexagonal by the number of slots."""
    down = where[i, 0] - where[j, 0]
    right = where[i, 1] - where[j, 1]
    if slots == 4:
        return abs(down) + abs(right)
    if slots == 8:
        return max(abs(down), abs(right))
    return max(abs(down), abs(right), abs(down + right))


@kernel
def _straight(where, i, j, steps):
    """Whether two cells lie exactly `steps` apart in one row or column."""
    down = where[i, 0] - where[j, 0]
    right = where[i, 1] - where[j, 1]
    return (down == 0 and abs(right) == steps) or (right == 0 and abs(down) == steps)


@kernel
def _adjacent(neighbours, i, j):
    for slot in range(neighbours.shape[1]):  # noqa: SIM110
        if neighbours[i, slot] == j:
            return True
    return False


@kernel
def _look(looks, pays, gains, ratio, cell):
    """Look once more; returns what it pays."""
    pay = pays[cell]
    looks[cell, 0] += 1
    pays[cell] = _gain(gains, ratio, cell, looks[cell, 0])
    return pay


@kernel
def _unlook(looks, pays, gains, ratio, cell):
    """Take one look back; returns what it paid."""
    looks[cell, 0] -= 1
    pay = _gain(gains, ratio, cell, looks[cell, 0])
    pays[cell] = pay
    return pay


@kernel
def _forget(nodes, looks, pays, gains, ratio, node, count):
    """Take back the looks of `count` nodes from `node` on; returns what they paid."""
    loss = 0.0
    for _ in range(count):
        loss += _unlook(looks, pays, gains, ratio, nodes[node, CELL])
        node = nodes[node, NEXT]
    return loss


@kernel
def _restore(nodes, looks, pays, gains, ratio, node, count):
    for _ in range(count):
        _look(looks, pays, gains, ratio, nodes[node, CELL])
        node = nodes[node, NEXT]


@kernel
def _withdraw(looks, pays, gains, ratio, path, begin, stop):
    for k in range(begin, stop):
        _unlook(looks, pays, gains, ratio, path[k])


@kernel
def _sample(
    neighbours, where, gains, ratio, looks, pays, state, weight, path,
    begin, cell, back, goal, after, steps, wing, greed,
):  # fmt: skip
    """Draw a way of `steps` steps from `cell` to `goal` (or to anywhere, goal -1), cells drawn by their gain.

    Writes the cells between into `path` from `begin` on, looks at them, and returns what they pay, or FAILED
    with no look left behind. `back` and `after` are the cells before and after the way (fixed wing only).
    """
    slots = neighbours.shape[1]
    inner = steps - 1 if goal >= 0 else steps
    total = 0.0
    for k in range(inner):
        left = steps - 1 - k
        found = 0.0
        for slot in range(slots):
            other = neighbours[cell, slot]
            barred = other < 0 or (wing and other == back)
            if not barred and (goal < 0 or _apart(where, slots, other, goal) <= left):
                found += pays[other] + greed
            weight[slot] = found
        if not wing and (goal < 0 or _apart(where, slots, cell, goal) <= left):
            found += pays[cell] + greed
        if found == 0.0:
            _withdraw(looks, pays, gains, ratio, path, begin, begin + k)
            return FAILED
        u = uniform(state) * found
        slot = 0
        while slot < slots and weight[slot] <= u:
            slot += 1
        back = cell
        if slot < slots:
            cell = neighbours[cell, slot]
        total += _look(looks, pays, gains, ratio, cell)
        path[begin + k] = cell
    if goal >= 0:
        legal = _adjacent(neighbours, cell, goal) or (cell == goal and not wing)
        if wing and (goal == back or after == cell):
            legal = False
        if not legal:
            _withdraw(looks, pays, gains, ratio, path, begin, begin + inner)
            return FAILED
    return total


@kernel
def _drop(nodes, looks, state, node):
    """Give a node's row back; the last row moves into it."""
    last = state[SIZE] - 1
    state[SIZE] = last
    if node != last:
        nodes[node, CELL] = nodes[last, CELL]
        nodes[node, NEXT] = nodes[last, NEXT]
        nodes[node, BEFORE] = nodes[last, BEFORE]
        nodes[nodes[node, BEFORE], NEXT] = node
        if nodes[node, NEXT] >= 0:
            nodes[nodes[node, NEXT], BEFORE] = node
        if state[TAIL] == last:
            state[TAIL] = node
        looks[nodes[node, CELL], 1] = node


@kernel
def _splice(nodes, looks, state, first, old, path, begin, new):
    """Put `new` cells of `path` where `old` nodes follow `first`; looks were counted already."""
    node = first
    for k in range(min(old, new)):
        node = nodes[node, NEXT]
        nodes[node, CELL] = path[begin + k]
        looks[path[begin + k], 1] = node
    for k in range(old, new):
        fresh = state[SIZE]
        state[SIZE] += 1
        then = nodes[node, NEXT]
        nodes[fresh, CELL] = path[begin + k]
        nodes[fresh, BEFORE] = node
        nodes[fresh, NEXT] = then
        nodes[node, NEXT] = fresh
        if then >= 0:
            nodes[then, BEFORE] = fresh
        else:
            state[TAIL] = fresh
        looks[path[begin + k], 1] = fresh
        node = fresh
    for _ in range(new, old):
        gone = nodes[node, NEXT]
        then = nodes[gone, NEXT]
        nodes[node, NEXT] = then
        if then >= 0:
            nodes[then, BEFORE] = node
        else:
            state[TAIL] = node
        if node == state[SIZE] - 1:  # the row that moves is our own foothold
            node = gone
        _drop(nodes, looks, state, gone)


@kernel
def _before(nodes, node, previous):
    """Cell before a node, -1 at a start with a free heading."""
    before = nodes[node, BEFORE]
    return nodes[before, CELL] if before >= 0 else previous


@kernel
def _after(nodes, node):
    then = nodes[node, NEXT]
    return nodes[then, CELL] if then >= 0 else -1


@kernel
def _span(nodes, first, steps):
    """Last node of a window of up to `steps` steps after `first`, and the steps there are."""
    node = first
    for k in range(steps):
        if nodes[node, NEXT] < 0:
            return node, k
        node = nodes[node, NEXT]
    return node, steps


@kernel
def _rewrite_pair(
    nodes, looks, pays, state, gains, ratio, neighbours, where, weight, path, pinned, wing, previous, bar, greed
):
    """Shorten one window and lengthen another by as much; returns the change of value, 0 where rejected."""
    size = state[SIZE]
    slots = neighbours.shape[1]
    less = 2 if slots == 4 else 1 + below(state, 2)
    if slots == 4 and not wing and below(state, 4) == 0:
        less = 1
    a = below(state, size)
    b, m = _span(nodes, a, less + 1 + below(state, 4))
    if m <= less:
        return 0.0
    goal = nodes[b, CELL]
    if nodes[b, NEXT] < 0 and not pinned:
        return 0.0
    if _apart(where, slots, nodes[a, CELL], goal) > m - less:
        return 0.0
    c = below(state, size)
    d, w = _span(nodes, c, 1 + below(state, 4))
    free = nodes[d, NEXT] < 0 and not pinned
    if w == 0 and not free:
        return 0.0
    node = c  # the windows must not overlap, nor share a corner that a fixed wing turns in
    for _ in range(w + 1):
        other = nodes[a, BEFORE] if nodes[a, BEFORE] >= 0 else a
        for _ in range(m + 3):
            if other == node:
                return 0.0
            if nodes[other, NEXT] < 0:
                break
            other = nodes[other, NEXT]
        if nodes[node, NEXT] < 0:
            break
        node = nodes[node, NEXT]
    loss = _forget(nodes, looks, pays, gains, ratio, nodes[a, NEXT], m - 1)
    short = _sample(
        neighbours, where, gains, ratio, looks, pays, state, weight, path,
        0, nodes[a, CELL], _before(nodes, a, previous), goal, _after(nodes, b), m - less, wing, greed,
    )  # fmt: skip
    if short == FAILED:
        _restore(nodes, looks, pays, gains, ratio, nodes[a, NEXT], m - 1)
        return 0.0
    old = w if free else w - 1
    loss += _forget(nodes, looks, pays, gains, ratio, nodes[c, NEXT], old)
    half = m - less - 1
    long = _sample(
        neighbours, where, gains, ratio, looks, pays, state, weight, path, half, nodes[c, CELL],
        _before(nodes, c, previous), -1 if free else nodes[d, CELL], _after(nodes, d), w + less, wing, greed,
    )  # fmt: skip
    if long == FAILED or short + long - loss < bar:
        if long != FAILED:
            _withdraw(looks, pays, gains, ratio, path, half, half + old + less)
        _restore(nodes, looks, pays, gains, ratio, nodes[c, NEXT], old)
        _withdraw(looks, pays, gains, ratio, path, 0, half)
        _restore(nodes, looks, pays, gains, ratio, nodes[a, NEXT], m - 1)
        return 0.0
    _splice(nodes, looks, state, c, old, path, half, old + less)
    _splice(nodes, looks, state, a, m - 1, path, 0, half)
    return short + long - loss


@kernel
def _rewrite(
    nodes, looks, pays, state, gains, ratio, neighbours, where, weight, path,
    first, span, change, pinned, wing, previous, bar, price, greed,
):  # fmt: skip
    """Replace the window of `span` steps after `first` by a way `change` steps longer; the change of value."""
    slots = neighbours.shape[1]
    last, m = _span(nodes, first, span)
    free = nodes[last, NEXT] < 0 and not pinned
    steps = m + change
    if steps < 1 and not (free and steps >= 0 and m > 0):
        return 0.0
    if not free:
        if m == 0 or _apart(where, slots, nodes[first, CELL], nodes[last, CELL]) > steps:
            return 0.0
        if change == 0 and slots == 4 and _straight(where, nodes[first, CELL], nodes[last, CELL], m):
            return 0.0  # as it is, is the only way
    old = m if free else m - 1
    loss = _forget(nodes, looks, pays, gains, ratio, nodes[first, NEXT], old)
    pay = _sample(
        neighbours, where, gains, ratio, looks, pays, state, weight, path, 0, nodes[first, CELL],
        _before(nodes, first, previous), -1 if free else nodes[last, CELL], _after(nodes, last), steps, wing, greed,
    )  # fmt: skip
    if pay == FAILED or pay - loss - price * change < bar:
        if pay != FAILED:
            _withdraw(looks, pays, gains, ratio, path, 0, old + change)
        _restore(nodes, looks, pays, gains, ratio, nodes[first, NEXT], old)
        return 0.0
    _splice(nodes, looks, state, first, old, path, 0, old + change)
    return pay - loss


@kernel
def _reverse(nodes, state, a, b):
    """Turn around the stretch from the node after `a` to `b`."""
    first, then = nodes[a, NEXT], nodes[b, NEXT]
    node = first
    while node != then:
        nxt = nodes[node, NEXT]
        nodes[node, NEXT] = nodes[node, BEFORE]
        nodes[node, BEFORE] = nxt
        node = nxt
    nodes[a, NEXT] = b
    nodes[b, BEFORE] = a
    nodes[first, NEXT] = then
    if then >= 0:
        nodes[then, BEFORE] = first
    else:
        state[TAIL] = first


@kernel
def _reconnect(nodes, looks, state, neighbours, pinned, wing, previous, a, b, farthest):
    """2-opt of a walk: where `a` and `b` stand side by side, fly the stretch between them the other way."""
    ahead, behind = a, a
    for _ in range(farthest):
        if ahead >= 0:
            ahead = nodes[ahead, NEXT]
        if behind >= 0:
            behind = nodes[behind, BEFORE]
        if ahead == b or behind == b:
            break
    if behind == b:
        a, b = b, a
    elif ahead != b:
        return
    first, then = nodes[a, NEXT], nodes[b, NEXT]
    if first == b:
        return
    if then < 0:
        if pinned:
            return
    elif not (
        _adjacent(neighbours, nodes[first, CELL], nodes[then, CELL])
        or (not wing and nodes[first, CELL] == nodes[then, CELL])
    ):
        return
    if wing:
        if _before(nodes, a, previous) == nodes[b, CELL] or _before(nodes, b, previous) == nodes[a, CELL]:
            return
        if then >= 0 and (_after(nodes, first) == nodes[then, CELL] or _after(nodes, then) == nodes[first, CELL]):
            return
    _reverse(nodes, state, a, b)


@kernel
def anneal(
    nodes, looks, pays, state, gains, ratio, neighbours, where, limit, pinned, wing, previous,
    moves, temperature, price, greed, mix, weight, path,
):  # fmt: skip
    """Metropolis moves on one walk of at most `limit` cells; returns the change of value.

    pinned : bool         the last cell must stay
    price : float         of one step more while there are fewer than the budget
    greed : float         of a way's cells: low draws them by gain, high uniformly
    mix : (4,) float      cumulated shares of: windows, pairs of windows, long shortcuts, tails; rest: reconnections
    weight, path          scratch: (D + 1,) float64 and (256,) int32
    """
    slots = neighbours.shape[1]
    total = 0.0
    for _ in range(moves):
        size = state[SIZE]
        bar = temperature * math.log(uniform(state) + 1e-10)
        kind = uniform(state)
        first, span, change = -1, 0, 0
        if kind < mix[0]:
            first, span = below(state, size), 1 + below(state, 6)
            if kind < mix[0] * 0.4:
                change = 2 - 4 * (draw(state) & 1)
                if not (wing and slots == 4) and below(state, 3) == 0:
                    change //= 2
        elif kind < mix[1]:
            total += _rewrite_pair(
                nodes,
                looks,
                pays,
                state,
                gains,
                ratio,
                neighbours,
                where,
                weight,
                path,
                pinned,
                wing,
                previous,
                bar,
                greed,
            )
        elif kind < mix[2]:
            a = below(state, size)
            b, span = _span(nodes, a, 6 + below(state, 60))
            straight = _apart(where, slots, nodes[a, CELL], nodes[b, CELL])
            if (nodes[b, NEXT] >= 0 or pinned) and 0 < straight < span:
                first, change = a, straight - span
        elif kind < mix[3]:
            if not pinned:
                first, span = state[TAIL], 1
                for _ in range(below(state, 30)):
                    if nodes[first, BEFORE] >= 0:
                        first = nodes[first, BEFORE]
                        span += 1
                change = below(state, 9) - 4
        else:
            a = below(state, size) if draw(state) & 1 or pinned else state[TAIL]
            cell = neighbours[nodes[a, CELL], below(state, slots)]
            if cell >= 0:
                b = looks[cell, 1]
                if 0 <= b < size and nodes[b, CELL] == cell and b != a:
                    _reconnect(nodes, looks, state, neighbours, pinned, wing, previous, a, b, 4096)
        if first >= 0:
            total += _rewrite(
                nodes, looks, pays, state, gains, ratio, neighbours, where, weight, path,
                first, span, min(change, limit - size), pinned, wing, previous, bar, price, greed,
            )  # fmt: skip
    return total


@kernel
def load(walk, nodes, looks, pays, state, gains, ratio):
    """Make the list from a walk (n,) int32 of n <= T + 1 cells; returns what it pays."""
    total = 0.0
    for cell in range(len(pays)):
        looks[cell, 0] = 0
        looks[cell, 1] = -1
        pays[cell] = gains[cell, 0]
    n = len(walk)
    for k in range(n):
        nodes[k, CELL] = walk[k]
        nodes[k, NEXT] = k + 1 if k + 1 < n else -1
        nodes[k, BEFORE] = k - 1
        total += _look(looks, pays, gains, ratio, walk[k])
        looks[walk[k], 1] = k
    state[SIZE] = n
    state[TAIL] = n - 1
    return total


@kernel
def unload(nodes, looks, pays, gains, ratio, neighbours, pinned, wing, previous, walk):
    """Write the walk of the list, steps left over spent one at a time where they pay most; returns its length.

    Shorter than `walk` only where a fixed wing has nowhere to go on, or must stay at its end cell.
    """
    limit = len(walk)
    node, n = 0, 0
    while node >= 0:
        walk[n] = nodes[node, CELL]
        n += 1
        node = nodes[node, NEXT]
    while n < limit and not (pinned and wing):
        best, choice = -1.0, -1
        if pinned:  # hover where it pays most
            at = 0
            for k in range(n):
                if pays[walk[k]] > best:
                    best, at = pays[walk[k]], k
            for k in range(n, at, -1):
                walk[k] = walk[k - 1]
            choice = walk[at]
        else:
            cell = walk[n - 1]
            back = walk[n - 2] if n > 1 else previous
            for slot in range(neighbours.shape[1] + 1):
                other = cell if slot == neighbours.shape[1] else neighbours[cell, slot]
                barred = other < 0 or (wing and (other == back or slot == neighbours.shape[1]))
                if not barred and pays[other] > best:
                    best, choice = pays[other], other
            if choice < 0:
                break
            walk[n] = choice
        _look(looks, pays, gains, ratio, choice)
        n += 1
    for k in range(n):  # take back the looks of what was added here, and of nothing else
        _unlook(looks, pays, gains, ratio, walk[k])
    node = 0
    while node >= 0:
        _look(looks, pays, gains, ratio, nodes[node, CELL])
        node = nodes[node, NEXT]
    return n


@kernel
def route(where, slots, anchors, prize, cost, start, end, budget, spare, state, moves, hot, cold, inside, best, order):
    """Anneal which pieces of ground to visit, and in what order; returns how many, written to `order`.

    anchors : (P,) int32 cells; prize, cost : (P,) float64; spare : what a step left over is worth
    inside : (P,) int32 of 0 and best : (P,) int32, scratch
    """
    pieces = len(anchors)
    if pieces == 0:
        return 0
    n = 0
    length = 0.0 if end < 0 else float(_apart(where, slots, start, end))
    temperature = hot
    cooling = (cold / hot) ** (1.0 / max(moves, 1))
    best_value, value = 0.0, 0.0
    full = spare
    best_n = 0
    for move in range(moves):
        temperature *= cooling
        spare = full * min(1.0, 2.0 * move / moves)  # time is free at first, or no route would leave for far hills
        bar = temperature * math.log(uniform(state) + 1e-10)
        kind = uniform(state)
        if kind < 0.6 or n < 2:
            p = below(state, pieces)
            if inside[p]:
                continue
            swap = -1
            if n > 0 and kind < 0.3:
                swap = below(state, n)  # this one goes
            saved, lost = 0.0, 0.0
            if swap >= 0:
                left = anchors[order[swap - 1]] if swap > 0 else start
                gone = anchors[order[swap]]
                right = anchors[order[swap + 1]] if swap + 1 < n else end
                saved = cost[order[swap]] + _apart(where, slots, left, gone)
                if right >= 0:
                    saved += _apart(where, slots, gone, right) - _apart(where, slots, left, right)
                lost = prize[order[swap]]
            cheapest, at = 1e300, 0
            here = anchors[p]
            left = start
            for k in range(n + 1):
                if k == swap:
                    continue
                right = anchors[order[k]] if k < n else end
                extra = float(_apart(where, slots, left, here))
                if right >= 0:
                    extra += _apart(where, slots, here, right) - _apart(where, slots, left, right)
                if extra < cheapest:
                    cheapest, at = extra, k
                left = right
            longer = cheapest + cost[p] - saved
            delta = prize[p] - lost - spare * longer
            if length + longer <= budget and delta >= bar:
                if swap >= 0:
                    inside[order[swap]] = 0
                    for k in range(swap, n - 1):
                        order[k] = order[k + 1]
                    n -= 1
                    if at > swap:
                        at -= 1
                for k in range(n, at, -1):
                    order[k] = order[k - 1]
                order[at] = p
                inside[p] = 1
                n += 1
                length += longer
                value += prize[p] - lost - full * longer
        elif kind < 0.75:
            i = below(state, n)
            run = min(1 + below(state, 3), n - i)
            left = anchors[order[i - 1]] if i > 0 else start
            stop = anchors[order[i + run]] if i + run < n else end
            saved, lost = 0.0, 0.0
            here = left
            for k in range(i, i + run):
                saved += cost[order[k]] + _apart(where, slots, here, anchors[order[k]])
                lost += prize[order[k]]
                here = anchors[order[k]]
            if stop >= 0:
                saved += _apart(where, slots, here, stop) - _apart(where, slots, left, stop)
            delta = spare * saved - lost
            if delta >= bar:
                for k in range(i, i + run):
                    inside[order[k]] = 0
                for k in range(i, n - run):
                    order[k] = order[k + run]
                n -= run
                length -= saved
                value += full * saved - lost
        else:
            i = below(state, n)
            j = below(state, n)
            if i > j:
                i, j = j, i
            if i == j:
                continue
            left = anchors[order[i - 1]] if i > 0 else start
            right = anchors[order[j + 1]] if j + 1 < n else end
            longer = float(
                _apart(where, slots, left, anchors[order[j]]) - _apart(where, slots, left, anchors[order[i]])
            )
            if right >= 0:
                longer += _apart(where, slots, anchors[order[i]], right)
                longer -= _apart(where, slots, anchors[order[j]], right)
            if length + longer <= budget and -spare * longer >= bar:
                while i < j:
                    order[i], order[j] = order[j], order[i]
                    i += 1
                    j -= 1
                length += longer
                value -= full * longer
        if value > best_value:
            best_value = value
            best_n = n
            for k in range(n):
                best[k] = order[k]
    for k in range(best_n):
        order[k] = best[k]
    return best_n


@kernel
def _leg(neighbours, where, gains, seen, far, best, queue, cell, goal, strict):
    """Label cells with their steps to `goal` until `cell` is reached, and the most that a shortest way pays.

    far (N,) holds -1 elsewhere; returns the number of labelled cells, written to `queue`. With `strict`
    only cells between the two are labelled, which suffices where no obstacle is in the way.
    """
    slots = neighbours.shape[1]
    direct = _apart(where, slots, cell, goal)
    queue[0] = goal
    far[goal] = 0
    head, tail = 0, 1
    while head < tail:
        here = queue[head]
        head += 1
        if far[cell] >= 0 and far[here] >= far[cell]:
            break
        most = 0.0
        for slot in range(slots):
            other = neighbours[here, slot]
            if other < 0:
                continue
            if far[other] < 0:
                if far[cell] < 0 and (not strict or far[here] + 1 + _apart(where, slots, other, cell) <= direct):
                    far[other] = far[here] + 1
                    queue[tail] = other
                    tail += 1
            elif far[other] == far[here] - 1:
                most = max(most, best[other])
        best[here] = most + (gains[here, 0] if seen[here] == 0 else 0.0)
    return tail


@kernel
def join(neighbours, where, gains, anchors, start, end, to_end, wing, previous, seen, far, best, queue, walk):
    """Fly shortest ways between anchors, each the one that pays most; returns the length of `walk`.

    to_end : (N,) int32 steps from each cell to the end (unused where end is -1); seen : (N,) zeros, left so;
    far : (N,) int32 of -1, left so; best (N,) float64, queue (N,) int32: scratch. 0: no way was found.
    """
    limit = len(walk)
    slots = neighbours.shape[1]
    walk[0] = start
    seen[start] = 1
    n = 1
    cell, back = start, previous
    for k in range(len(anchors) + 1):
        goal = anchors[k] if k < len(anchors) else end
        for _ in range(4):  # a fixed wing may have to step aside before it can turn to its goal
            if goal < 0 or goal == cell or n == limit:
                break
            tail = _leg(neighbours, where, gains, seen, far, best, queue, cell, goal, True)
            if far[cell] < 0:
                for q in range(tail):
                    far[queue[q]] = -1
                tail = _leg(neighbours, where, gains, seen, far, best, queue, cell, goal, False)
            fits = far[cell] >= 0 and (end < 0 or n - 1 + far[cell] + to_end[goal] < limit)
            while fits and cell != goal and n < limit:
                choice, aside = -1, -1
                for slot in range(slots):
                    other = neighbours[cell, slot]
                    if other < 0 or (wing and other == back):
                        continue
                    if far[other] >= 0 and far[other] < far[cell]:
                        if choice < 0 or best[other] > best[choice]:
                            choice = other
                    elif aside < 0 or (seen[other] == 0 and gains[other, 0] > gains[aside, 0]):
                        aside = other
                fits = choice >= 0
                if choice < 0:
                    choice = aside
                if choice < 0:
                    break
                back = cell
                cell = choice
                walk[n] = cell
                seen[cell] = 1
                n += 1
            for q in range(tail):
                far[queue[q]] = -1
    for k in range(n):
        seen[walk[k]] = 0
    return n
