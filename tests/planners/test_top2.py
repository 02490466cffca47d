"""Top2: the halves meet, the time is shared well, laws of every plan, published efficiencies."""

import numpy as np
import pytest
from hypothesis import given, settings

from sooner.grid import Grid
from sooner.planners import solve
from sooner.planners.top2 import Top2
from sooner.problem import CellMoves, Gains, Searcher, SearchProblem
from tests.planners.climbing import check_contract, hilly_problems, two_hills


@settings(max_examples=30)
@given(hilly_problems())
def test_every_plan_is_legal_and_never_worse(problem):
    check_contract(Top2(layers=(3, 2)), problem)


@pytest.mark.parametrize("connectivity", ["square4", "square8", "hex"])
@pytest.mark.parametrize("kind", ["copter", "fixed_wing"])
def test_the_path_goes_through_both_hills_and_the_point_between(connectivity, kind):
    grid, gains = two_hills(connectivity=connectivity)
    problem = SearchProblem(grid, gains, (Searcher((10, 9), 120, moves=CellMoves(kind)),))
    cells = check_contract(Top2(layers=(2,)), problem).plan.actions[0]
    for cell in ((10, 5), (10, 25), (10, 15)):
        assert grid.index(cell) in cells


def test_more_time_goes_to_the_larger_hill():
    grid, _ = two_hills()
    rows, cols = np.indices(grid.shape)
    small = (abs(rows - 10) <= 1) & (abs(cols - 5) <= 1)
    large = (abs(rows - 10) <= 6) & (abs(cols - 24) <= 6)
    height = (small * (2.0 - 0.1 * abs(rows - 10) - 0.1 * abs(cols - 5))) + large * (
        1.5 - 0.01 * abs(rows - 10) - 0.01 * abs(cols - 24)
    )
    gains = Gains.independent(height / height.sum(), np.ones(height.shape))
    problem = SearchProblem(grid, gains, (Searcher((10, 5), 150),))
    cells = solve(problem, Top2(layers=(2,))).best.plan.actions[0]
    assert (cells % grid.shape[1] > 15).sum() > 100


def test_ground_without_hills_still_gets_a_plan():
    for height in (np.zeros(12), np.ones(12) / 12):
        problem = SearchProblem(Grid((3, 4)), Gains.independent(height, np.ones(12)), (Searcher((0, 0), 7),))
        check_contract(Top2(), problem)


def test_the_number_of_threads_changes_nothing():
    grid, gains = two_hills()
    problem = SearchProblem(grid, gains, (Searcher((0, 0), 100),))
    assert solve(problem, Top2(threads=1)).best.plan == solve(problem, Top2(threads=4)).best.plan


def test_published_efficiency_is_reached(real_problem):
    problem = real_problem("newyork108", 300)
    assert 100 * solve(problem, Top2()).best.value / problem.teleport.value > 60.73 - 2.5
