"""Compiled moves of annealing over regions: plain arrays in, plain arrays out.

What a plan collects and how long it takes does not depend on the order of its actions. So what is annealed is no walk
but how often each action is flown; such numbers can be flown as one walk where the edges used are connected with the
first region, every searched region lies on them, and only the first and the last region have an odd number of them.

counts (A,) int32      how often each action is flown; a < R searches region a
degree (R,) int32      edges used at each region
looks (K,) int32       looks at each atom
whole (8,) int64       two words of random state, END region, STAMP of marks, EDGES used in all, UNDO length,
                       BEST_END, where the best numbers end, and TOUCHED, how many regions a move has touched
real (3,) float64      SECONDS used, VALUE, BEST value
kept (A,) int32        the best numbers so far
marks (R,), queue (2, R), undo (U,)     scratch
touched (6 LONGEST,)                    regions at which a move has parted what was joined

Most moves are refused for what they would cost, so that is asked first. Whether what is left hangs together takes a
search, and it is made only for moves that would else be taken, and only where the last copy of an edge has gone.
"""

import math

from sooner.planners._random_kernels import below, draw, kernel

END, STAMP, EDGES, UNDO, BEST_END, TOUCHED = 2, 3, 4, 5, 6, 7
SECONDS, VALUE, BEST = 0, 1, 2
LONGEST = 16  # most edges of a cycle


@kernel
def _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, sign):
    """Fly an action once more or once less."""
    last = gains.shape[1] - 1
    value = 0.0
    if sign > 0:
        for entry in range(starts[action], starts[action + 1]):
            atom = atoms[entry]
            value += gains[atom, min(looks[atom], last)]
            looks[atom] += 1
    else:
        for entry in range(starts[action], starts[action + 1]):
            atom = atoms[entry]
            looks[atom] -= 1
            value -= gains[atom, min(looks[atom], last)]
    real[VALUE] += value
    real[SECONDS] += sign * seconds[action]
    counts[action] += sign
    if action >= len(degree):
        degree[ends[action, 0]] += sign
        degree[ends[action, 1]] += sign
        whole[EDGES] += sign
    undo[whole[UNDO]] = (action + 1) * sign
    whole[UNDO] += 1


@kernel
def _joined(way_starts, ways, ends, counts, marks, queue, whole, one, other):
    """Whether edges in use join two regions: searched from both sides, a step at a time."""
    if one == other:
        return True
    whole[STAMP] += 2
    stamp = whole[STAMP]
    marks[one], marks[other] = stamp, stamp + 1
    queue[0, 0], queue[1, 0] = one, other
    head0, head1, size0, size1 = 0, 0, 1, 1
    while True:
        side = 0 if head0 <= head1 else 1
        if side == 0:
            if head0 == size0:
                return False
            here = queue[0, head0]
            head0 += 1
        else:
            if head1 == size1:
                return False
            here = queue[1, head1]
            head1 += 1
        for way in range(way_starts[here] + 1, way_starts[here + 1]):
            action = ways[way]
            if counts[action] > 0:
                there = ends[action, 0] + ends[action, 1] - here
                if marks[there] == stamp + 1 - side:
                    return True
                if marks[there] != stamp + side:
                    marks[there] = stamp + side
                    if side == 0:
                        queue[0, size0] = there
                        size0 += 1
                    else:
                        queue[1, size1] = there
                        size1 += 1


@kernel
def _touch(whole, touched, one, other):
    """Remember two regions that an edge has ceased, or begun, to join."""
    touched[whole[TOUCHED]], touched[whole[TOUCHED] + 1] = one, other
    whole[TOUCHED] += 2


@kernel
def _one_piece(way_starts, ways, ends, counts, degree, marks, queue, whole, first, touched):
    """Whether a move has left all edges in use in one piece with the first region.

    Before it they were. What is added begins at a region in use, or at the first; so every piece that a move can make
    has a touched region in it, and these need only be joined with one another.
    """
    reference = -1
    for number in range(whole[TOUCHED]):
        region = touched[number]
        if degree[region] == 0:
            if counts[region] > 0 and region != first:
                return False
        elif degree[first] == 0:
            return False
        elif reference < 0:
            reference = region
        elif not _joined(way_starts, ways, ends, counts, marks, queue, whole, reference, region):
            return False
    return whole[TOUCHED] == 0 or whole[EDGES] == 0 or degree[first] > 0


@kernel
def _take_back(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, value, used, end):
    """Undo everything since the undo list was empty."""
    for back in range(whole[UNDO] - 1, -1, -1):
        action = abs(undo[back]) - 1
        sign = -1 if undo[back] > 0 else 1
        _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, sign)
        whole[UNDO] -= 1
    whole[UNDO] = 0
    whole[END] = end
    real[VALUE], real[SECONDS] = value, used


@kernel
def _elementary(
    starts, atoms, way_starts, ways, ends, cycle_starts, cycles, gains, seconds, first, free_end,
    counts, degree, looks, whole, real, undo, touched,
):  # fmt: skip
    """One random change that keeps degrees right; False where what was drawn cannot be done."""
    n_regions = len(degree)
    n_edges = len(seconds) - n_regions
    kind = below(whole, 16)
    sign = 1 if draw(whole) & 1 else -1
    if kind < 7 or n_edges == 0:  # a search more, or less
        region = below(whole, n_regions)
        if (sign < 0 and counts[region] == 0) or (sign > 0 and degree[region] == 0 and region != first):
            return False
        _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, region, sign)
        return True
    if kind < 11:  # there and back once more, or less
        action = n_regions + below(whole, n_edges)
        one, other = ends[action, 0], ends[action, 1]
        if sign < 0:
            if counts[action] < 2:
                return False
            _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, -1)
            _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, -1)
            for region in (one, other):  # nobody comes by to search it any more
                while degree[region] == 0 and region != first and counts[region] > 0 and whole[UNDO] < len(undo) - 8:
                    _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, region, -1)
            if counts[action] == 0:
                _touch(whole, touched, one, other)
            return True
        new_one, new_other = degree[one] == 0 and one != first, degree[other] == 0 and other != first
        if new_one and new_other:
            return False
        _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, 1)
        _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, 1)
        if new_one or new_other:
            region = one if new_one else other
            _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, region, 1)
        return True
    if kind < 13:  # end elsewhere
        if not free_end:
            return False
        here = whole[END]
        n_ways = way_starts[here + 1] - way_starts[here] - 1
        if n_ways == 0:
            return False
        action = ways[way_starts[here] + 1 + below(whole, n_ways)]
        if sign < 0 and counts[action] == 0:
            return False
        there = ends[action, 0] + ends[action, 1] - here
        _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, sign)
        whole[END] = there
        if counts[action] == 0:
            _touch(whole, touched, here, there)
        return True
    n_cycles = len(cycle_starts) - 1  # round a cycle once more, or one part of it more and the other less
    if n_cycles == 0:
        return False
    cycle = below(whole, n_cycles)
    mixed = draw(whole)
    if kind < 14:
        mixed = 0
    begin, stop = cycle_starts[cycle], cycle_starts[cycle + 1]
    for entry in range(begin, stop):
        if (mixed >> (entry - begin)) & 1 and counts[cycles[entry]] == 0:
            return False
    known, parted = False, False
    for entry in range(begin, stop):
        action = cycles[entry]
        one, other = ends[action, 0], ends[action, 1]
        known = known or degree[one] > 0 or one == first or degree[other] > 0 or other == first
        parted = parted or ((mixed >> (entry - begin)) & 1 and counts[action] == 1)
    if not known:
        return False
    for entry in range(begin, stop):
        action = cycles[entry]
        sign = -1 if (mixed >> (entry - begin)) & 1 else 1
        if parted and counts[action] == (1 if sign < 0 else 0):
            _touch(whole, touched, ends[action, 0], ends[action, 1])
        _change(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, action, sign)
    return True


@kernel
def _keep(counts, kept, whole, real):
    """Remember the present numbers as the best."""
    for action in range(len(counts)):
        kept[action] = counts[action]
    real[BEST] = real[VALUE]
    whole[BEST_END] = whole[END]


@kernel
def anneal(
    starts, atoms, way_starts, ways, ends, cycle_starts, cycles, gains, seconds, limit_s, first, free_end,
    counts, degree, looks, whole, real, kept, marks, queue, undo, touched, temperature, moves,
):  # fmt: skip
    """Make so many moves of one to three changes each, at one temperature."""
    for _ in range(moves):
        value, used, end = real[VALUE], real[SECONDS], whole[END]
        whole[UNDO], whole[TOUCHED] = 0, 0
        parts = 1 + below(whole, 3)
        done = True
        for _ in range(parts):
            if whole[UNDO] > len(undo) // 2:
                break
            if not _elementary(
                starts, atoms, way_starts, ways, ends, cycle_starts, cycles, gains, seconds, first, free_end,
                counts, degree, looks, whole, real, undo, touched,
            ):  # fmt: skip
                done = False
                break
        gained = real[VALUE] - value
        taken = done and real[SECONDS] <= limit_s
        if taken and gained < 0.0:
            taken = gained > temperature * math.log((draw(whole) + 1.0) * 2.3283064365386963e-10)
        if taken and _one_piece(way_starts, ways, ends, counts, degree, marks, queue, whole, first, touched):
            if gained >= 0.0 or value <= real[BEST] + 1e-12:
                continue
            # The first step down from a new best is spent on remembering it.
            _take_back(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, value, used, end)
            _keep(counts, kept, whole, real)
            continue
        _take_back(starts, atoms, gains, seconds, ends, counts, degree, looks, whole, real, undo, value, used, end)
    if real[VALUE] > real[BEST] + 1e-12:
        _keep(counts, kept, whole, real)
