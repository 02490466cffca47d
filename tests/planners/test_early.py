"""Walks that pay early: the same actions in another order, or a little less for much of it sooner."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.planners import max_ticks, solve
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.region_early import brought_forward, quickest_edges
from sooner.planners.region_walk import early_order, walk_of
from sooner.problem import Plan, evaluate
from sooner.problem.region_ground import RegionGround
from tests.planners.region_worlds import all_walks, region_world


def random_walk(ground, seed, length=14):
    rng, here, walk = np.random.default_rng(seed), ground.first, []
    for _ in range(length):
        ways = ground.ways_from(here)
        action, here = ways[rng.integers(len(ways))]
        walk.append(action)
    return walk, here


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000), regions=st.integers(1, 6), legs=st.booleans())
def test_an_early_order_is_the_same_actions_and_ends_in_the_same_region(seed, regions, legs):
    problem = region_world(seed, regions, 200.0, extra=3, legs=legs)
    ground = RegionGround.of(problem)
    walk, end = random_walk(ground, seed)
    counts = np.bincount(walk, minlength=ground.n_actions).astype(np.int32)
    early = early_order(ground, counts)
    assert sorted(early) == sorted(walk)
    assert ground.walked(early) == end
    found, came = evaluate(problem, Plan.of(early)), evaluate(problem, Plan.of(walk))
    assert found.total == pytest.approx(came.total, rel=1e-12)
    assert early == early_order(ground, counts)


def test_an_early_order_comes_near_the_best_of_all_orders():
    lost = []
    for seed in range(5):
        problem = region_world(seed, 4, 16.0)
        by_actions = {}
        for walk in all_walks(problem):
            by_actions.setdefault(tuple(sorted(walk)), []).append(walk)
        orders = max(by_actions.values(), key=len)
        ground = RegionGround.of(problem)
        counts = np.bincount(orders[0], minlength=ground.n_actions).astype(np.int32)
        best = max(evaluate(problem, Plan.of(list(walk))).early_share for walk in orders)
        lost.append(best - evaluate(problem, Plan.of(early_order(ground, counts))).early_share)
    assert max(lost) < 0.03


def test_a_walk_of_thousands_of_actions_is_flown_whatever_its_order():
    ground = RegionGround.of(region_world(2, 3, 1e6))
    counts = np.zeros(ground.n_actions, np.int32)
    counts[:3] = 1500
    counts[3:] = 2
    walk = walk_of(ground, counts, ground.first)
    assert (np.bincount(walk, minlength=len(counts)) == counts).all()
    assert ground.walked(walk) == ground.first


@pytest.mark.parametrize(("seed", "ends"), [(0, False), (1, True), (2, False)])
def test_a_plan_brought_forward_keeps_its_share_of_the_total_and_pays_earlier(seed, ends):
    problem = region_world(seed, 5, 60.0, legs=True, ends=ends)
    plan = solve(problem, RegionAnneal(moves=400, longest=20, walks=2), max_ticks(6), seed).best.plan
    before = evaluate(problem, plan)
    early = brought_forward(problem, plan, 0.99, walks=2, moves=300)
    after = evaluate(problem, early)
    assert after.total >= 0.99 * before.total * (1 - 1e-12)
    assert after.early_share >= before.early_share
    again = brought_forward(problem, plan, 0.99, walks=2, moves=300)
    assert (again.actions[0] == early.actions[0]).all()


def test_a_share_of_the_total_that_is_none_is_refused():
    problem = region_world(0)
    plan = solve(problem, RegionAnneal(moves=50), max_ticks(1)).best.plan
    with pytest.raises(InvalidProblemError, match=r"keep = 1\.5 came"):
        brought_forward(problem, plan, 1.5)


def test_quickest_edges_lead_everywhere_the_quickest_way():
    problem = region_world(4, 6, 100.0, extra=4)
    ground, moves = RegionGround.of(problem), problem.searcher.moves
    nexts = quickest_edges(ground)
    for goal in range(6):
        quickest = moves.seconds_from(goal)
        for region in range(6):
            here, taken = region, 0.0
            while here != goal:
                taken += ground.seconds[nexts[here, goal]]
                here = int(ground.ends[nexts[here, goal]].sum()) - here
            assert taken == pytest.approx(quickest[region])
