"""Beam-stack search over regions: as good as enumeration, in little memory."""

import itertools
from math import inf

import numpy as np
import pytest

from sooner.errors import InvalidProblemError
from sooner.planners.beam_stack import BeamStack
from sooner.planners.branch_and_bound import BranchAndBound
from sooner.problem import Plan, evaluate
from tests.planners.region_worlds import best_by_enumeration, region_world
from tests.planners.test_branch_and_bound import check_region_contract, disjoint_world, last_record


@pytest.mark.parametrize("how", [{}, {"legs": True}, {"ends": True}, {"legs": True, "ends": True}], ids=repr)
def test_the_contract_is_kept(how):
    for seed in range(3):
        check_region_contract(region_world(seed, n_regions=3, budget=20.0, **how), BeamStack(width=3))


@pytest.mark.parametrize("width", [1, 2, 7, 1000])
@pytest.mark.parametrize("alpha", [0.3, 1.0])
def test_without_overlaps_patience_finds_the_optimum_at_any_width(width, alpha):
    for seed in range(3):
        problem = disjoint_world(seed, n_regions=4, budget=18.0, legs=seed == 1, ends=seed == 2)
        found = last_record(problem, BeamStack(width, alpha, eta=0.0, iterations=inf))
        assert found.finished
        assert found.value == pytest.approx(best_by_enumeration(problem), rel=1e-12)


@pytest.mark.parametrize("width", [1, 5])
def test_with_overlaps_a_g_that_keeps_actions_apart_finds_the_optimum(width):
    for seed in range(3):
        problem = region_world(seed, n_regions=4, budget=16.0, ends=seed == 1)
        found = last_record(problem, BeamStack(width, eta=0.0, iterations=inf, apart=True))
        assert found.value == pytest.approx(best_by_enumeration(problem), rel=1e-12)


def test_impatience_costs_no_more_than_it_promises():
    for seed in range(3):
        problem = disjoint_world(seed, n_regions=4, budget=18.0)
        found = last_record(problem, BeamStack(width=2, eta=0.1, iterations=inf))
        assert found.value * 1.1 >= best_by_enumeration(problem) * (1 - 1e-12)


def test_memory_is_at_most_width_times_depth_and_the_optimum_that_of_a_search_without_limit():
    problem = region_world(7, n_regions=5, budget=24.0)
    wide = last_record(problem, BranchAndBound(eta=0.0, iterations=inf, apart=True))
    depth = int(24.0 / problem.searcher.moves.graph.seconds.min())
    for width in (1, 4):
        narrow = last_record(problem, BeamStack(width, eta=0.0, iterations=inf, apart=True))
        assert narrow.value == pytest.approx(wide.value, rel=1e-12)
        assert narrow.stored <= 1 + width * depth < wide.stored
        assert narrow.expanded > wide.expanded, "which is paid for by coming back"


def test_one_pass_finds_a_complete_walk_and_coming_back_finds_better_ones():
    problem = region_world(2, n_regions=6, budget=40.0)
    records = list(BeamStack(width=1, alpha=1.0, iterations=400).searched(problem, np.random.default_rng(0)))
    solved = [record for record in records if record.success]
    assert solved[0].expanded <= 40.0 / problem.searcher.moves.graph.seconds.min()
    assert solved[-1].value > solved[0].value == solved[0].first_value
    assert all(after.value >= before.value for before, after in itertools.pairwise(solved))
    for record in records:
        assert evaluate(problem, Plan.of(list(record.walk))).value >= record.value - 1e-9


def test_nothing_is_drawn_at_random():
    problem = region_world(1, n_regions=6, budget=40.0)
    found = {last_record(problem, BeamStack(width=4), seed).walk for seed in range(3)}
    assert len(found) == 1


@pytest.mark.parametrize("settings", [{"width": 0}, {"iterations": 0}, {"alpha": 2.0}, {"eta": inf}])
def test_settings_that_mean_nothing_are_refused(settings):
    with pytest.raises(InvalidProblemError, match="came; expected"):
        BeamStack(**settings)
