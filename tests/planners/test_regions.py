"""Planners over regions on small random worlds, against every walk there is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.planners import max_ticks, solve
from sooner.planners.depth_first import DepthFirst, relaxation
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.region_greedy import RegionGreedy
from sooner.planners.region_walk import walk_of
from sooner.problem import Plan, evaluate
from sooner.problem.region_ground import RegionGround
from tests.planners.contract import check_contract
from tests.planners.region_worlds import best_by_enumeration, region_world

QUICK = RegionAnneal(moves=400, longest=20, walks=2)
PLANNERS = {"greedy": RegionGreedy(), "depth first": DepthFirst(), "anneal": QUICK}


@pytest.mark.parametrize("planner", PLANNERS.values(), ids=PLANNERS)
@settings(max_examples=12)
@given(seed=st.integers(0, 500), legs=st.booleans(), ends=st.booleans(), regions=st.integers(1, 4))
def test_every_planner_over_regions_keeps_the_contract(planner, seed, legs, ends, regions):
    problem = region_world(seed, regions, 16.0, legs=legs, ends=ends)
    check_contract(problem, planner, most=best_by_enumeration(problem))


@pytest.mark.parametrize("seed", range(8))
def test_annealing_finds_the_best_of_all_walks(seed):
    problem = region_world(seed, 4, 18.0, legs=seed % 2 == 1, ends=seed % 3 == 1)
    found = solve(problem, RegionAnneal(moves=3000), max_ticks(24), seed).best.value
    assert found == pytest.approx(best_by_enumeration(problem), abs=1e-9)


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000))
def test_numbers_of_a_walk_are_flown_as_another_walk_of_the_same_worth(seed):
    problem = region_world(seed, 5, 60.0, extra=3)
    ground = RegionGround.of(problem)
    rng = np.random.default_rng(seed)
    here, walk = ground.first, []
    for _ in range(14):
        action, here = ground.ways_from(here)[rng.integers(len(ground.ways_from(here)))]
        walk.append(action)
    counts = np.bincount(walk, minlength=ground.n_actions).astype(np.int32)
    other = walk_of(ground, counts, here)
    assert sorted(other) == sorted(walk)
    assert ground.walked(other) == here
    assert evaluate(problem, Plan.of(other)).value == pytest.approx(evaluate(problem, Plan.of(walk)).value, rel=1e-12)


def test_greedy_takes_the_open_action_of_the_best_rate():
    problem = region_world(3, 4, 30.0)
    ground = RegionGround.of(problem)
    (first, *_) = solve(problem, RegionGreedy()).best.plan.actions[0]
    rates = {
        action: evaluate(problem, Plan.of([action])).value / ground.seconds[action]
        for action, _ in ground.ways_from(ground.first)
    }
    assert first == max(rates, key=rates.get)


def test_depth_first_searches_no_region_more_often_than_the_relaxation_does():
    problem = region_world(1, 6, 90.0)
    wanted = relaxation(RegionGround.of(problem))[1]
    flown = np.bincount(solve(problem, DepthFirst()).best.plan.actions[0], minlength=len(wanted))
    assert (flown[:6] <= wanted[:6]).all()
    assert flown[:6].sum() > 0


def test_a_second_searcher_is_refused_with_a_sentence():
    problem = region_world(0)
    two = problem.__class__(problem.grid, problem.gains, problem.searchers * 2)
    assert RegionAnneal().handles(two) == "it plans for one searcher; this problem has 2"
