"""TopN: joins counted by brute force, hills visited, laws of every plan, published efficiencies."""

from itertools import pairwise, permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.planners import solve
from sooner.planners._climb_kernels import cheapest_order
from sooner.planners.topn import TopN
from sooner.problem import CellMoves, Searcher, SearchProblem
from tests.planners.climbing import check_contract, hilly_problems, two_hills


@settings(max_examples=60)
@given(hilly_problems())
def test_every_plan_is_legal_and_never_worse(problem):
    check_contract(TopN(layers=((3, 3), (2, 1))), problem)


def test_the_hierarchy_is_legal_on_every_topology_with_walls_and_ends():
    walls = np.zeros((13, 19), bool)
    walls[2:11, 9] = True
    for connectivity, kind in product(["square4", "square8", "hex"], ["copter", "fixed_wing"]):
        grid, gains = two_hills((13, 19), ((6, 3), (6, 15)), connectivity, obstacles=walls)
        searcher = Searcher((6, 8), 80, end=(7, 7), moves=CellMoves(kind))
        check_contract(TopN(), SearchProblem(grid, gains, (searcher,)))


def brute_force(matrix, has_last):
    middle = (len(matrix) - 1) // 2
    best = None
    for order in permutations(range(middle)):
        for flips in product((1, 2), repeat=middle):
            at, total = 0, 0
            for segment, flip in zip(order, flips, strict=True):
                total += max(matrix[at, 2 * segment + flip] - 1, 0)
                at = 2 * segment + 3 - flip
            if has_last:
                total += max(matrix[at, -1] - 1, 0)
            best = total if best is None else min(best, total)
    return best


@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.booleans())
def test_the_cheapest_order_is_that_of_all_orders_and_flips(seed, middle, has_last):
    rng = np.random.default_rng(seed)
    ends = rng.integers(0, 30, (2 * middle + 1 + has_last, 2))
    matrix = np.abs(ends[:, None] - ends[None]).sum(axis=2)
    best, order = cheapest_order(matrix, has_last)
    assert best == brute_force(matrix, has_last)
    steps = [max(matrix[a, b] - 1, 0) for a, b in pairwise(order_of_ends(order, len(matrix), has_last))][::2]
    assert sum(steps) == best


def order_of_ends(order, ends, has_last):
    walk = [0]
    for enter in order:
        walk += [enter, enter + 1 if enter % 2 else enter - 1]
    return walk + ([ends - 1] if has_last else [])


def test_both_hills_are_visited_where_there_is_time():
    grid, gains = two_hills()
    problem = SearchProblem(grid, gains, (Searcher((10, 15), 120),))
    plan = solve(problem, TopN(layers=((2, 2),))).best.plan
    for hill in ((10, 5), (10, 25)):
        assert grid.index(hill) in plan.actions[0]


def test_a_hill_that_is_too_far_is_left_out():
    grid, gains = two_hills()
    problem = SearchProblem(grid, gains, (Searcher((10, 10), 14),))
    plan = solve(problem, TopN(layers=((2, 2),))).best.plan
    assert grid.index((10, 5)) in plan.actions[0]
    assert grid.index((10, 25)) not in plan.actions[0]


def test_the_number_of_threads_changes_nothing():
    grid, gains = two_hills()
    problem = SearchProblem(grid, gains, (Searcher((0, 0), 100),))
    assert solve(problem, TopN(threads=1)).best.plan == solve(problem, TopN(threads=4)).best.plan


@pytest.mark.parametrize(
    ("name", "steps", "published", "greedy", "warming"),
    [
        ("hikerpaul", 900, 74.13, 57.11, 55.18),
        ("newyork53", 300, 65.39, 39.95, 38.47),
        ("newyork108", 600, 60.26, 45.34, 52.88),
    ],
)
def test_published_efficiency_is_reached(real_problem, name, steps, published, greedy, warming):
    problem = real_problem(name, steps)
    mean = np.mean([100 * solve(problem, TopN(), seed=s).best.value for s in range(3)]) / problem.teleport.value
    assert mean > published - 3.5
    assert mean > max(greedy, warming)
