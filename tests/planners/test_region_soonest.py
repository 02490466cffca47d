"""A target over regions: reached as early as enumeration finds it, and never earlier than is proved."""

from dataclasses import replace
from itertools import islice
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.bounds import bounds
from sooner.planners import max_ticks, solve
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.region_greedy import RegionGreedy
from sooner.planners.region_soonest import RegionSoonest
from sooner.planners.team import Team
from sooner.problem import Objective, Plan, evaluate
from tests.planners.contract import check_contract
from tests.planners.region_worlds import all_walks, region_world, unlike_team

INNER = RegionAnneal(moves=300, longest=20, walks=2)


def with_target(problem, share):
    """A target of a share of what greedy collects."""
    total = solve(problem, Team(RegionGreedy())).best.value
    return replace(problem, objective=Objective("information", share * total))


def soonest_walk(problem):
    return max(evaluate(problem, Plan.of(list(walk))).value for walk in all_walks(problem))


@settings(max_examples=12)
@given(
    seed=st.integers(0, 500),
    legs=st.booleans(),
    ends=st.booleans(),
    regions=st.integers(1, 3),
    share=st.sampled_from([0.2, 0.6, 0.9, 1.5]),
)
def test_it_keeps_the_contract(seed, legs, ends, regions, share):
    problem = with_target(region_world(seed, regions, 14.0, legs=legs, ends=ends), share)
    check_contract(problem, RegionSoonest(INNER), ticks=12, most=soonest_walk(problem))


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_it_comes_near_the_soonest_of_all_walks(share):
    late = []
    for seed in range(6):
        problem = with_target(region_world(seed, 3, 16.0, ends=bool(seed % 2)), share)
        found = solve(problem, RegionSoonest(INNER, ticks=10), max_ticks(300), seed).best.value
        best = soonest_walk(problem)
        assert found <= best
        late.append(found / best)
    assert np.mean(late) < 1.05


@settings(max_examples=25)
@given(
    seed=st.integers(0, 500), legs=st.booleans(), ends=st.booleans(), share=st.sampled_from([0.2, 0.5, 0.8, 1.0, 3.0])
)
def test_nothing_is_sooner_than_is_proved(seed, legs, ends, share):
    problem = with_target(region_world(seed, 3, 14.0, legs=legs, ends=ends), share)
    best = soonest_walk(problem)
    found = [bound.value for bound in islice(bounds(problem, best), 40)]
    assert found == sorted(found, reverse=True)
    assert best <= found[-1]
    assert found[-1] > -inf or best == -inf


def test_a_target_that_no_plan_reaches_is_proved_to_be_none():
    problem = with_target(region_world(1, 3, 14.0), 50.0)
    assert [bound.value for bound in bounds(problem)][-1] == -inf


def test_a_proof_says_something():
    """At half of what greedy collects, at least a quarter of the best time is ruled out in the mean."""
    shares = []
    for seed in range(8):
        problem = with_target(region_world(seed, 4, 24.0), 0.5)
        found = solve(problem, RegionSoonest(INNER, ticks=6), max_ticks(100), seed).best.value
        shares.append(list(bounds(problem, found))[-1].value / found)
    assert np.mean(shares) > 0.25


def test_a_team_reaches_a_target_together():
    team = with_target(unlike_team(3), 0.7)
    found = solve(team, RegionSoonest(Team(INNER, ticks=5), ticks=30), max_ticks(200)).best
    pairs = ([*all_walks(replace(team, searchers=(one,)))] for one in team.searchers)
    ones, others = pairs
    best = max(evaluate(team, Plan.of(list(a), list(b))).value for a in ones for b in others)
    assert -inf < found.value <= best
    assert best <= list(bounds(team, found.value))[-1].value


def test_it_refuses_a_search_without_a_target_or_over_cells():
    problem = region_world(0)
    assert "detection_target" in RegionSoonest(INNER).handles(problem)
    assert RegionSoonest(INNER).handles(with_target(problem, 0.5)) is None
    team = with_target(replace(problem, searchers=problem.searchers * 2), 0.5)
    assert "one searcher" in RegionSoonest(INNER).handles(team)
