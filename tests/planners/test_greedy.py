"""One-step greedy against its definition, and on every topology."""

from itertools import pairwise

import numpy as np
from hypothesis import given, settings

from sooner.grid import Grid
from sooner.planners import Greedy, solve
from sooner.problem import CellMoves, Gains, Reach, Searcher, SearchProblem
from tests.planners.climbing import check_contract, hilly_problems
from tests.strategies import problems


@settings(max_examples=60)
@given(hilly_problems())
def test_every_plan_is_legal(problem):
    check_contract(Greedy(), problem)


@settings(max_examples=100)
@given(problems())
def test_every_step_goes_where_the_next_look_pays_most(problem):
    plan = solve(problem, Greedy()).best.plan
    reach, looks = Reach(problem.grid, problem.searcher), np.zeros(problem.grid.n_cells, int)
    path, before = plan.actions[0].tolist(), reach.came_from
    for n, (here, there) in enumerate(pairwise(path)):
        looks[here] += 1
        steps_left = problem.searcher.budget - n - 1
        around = [int(c) for c in problem.grid.neighbours[here] if c >= 0 and not (reach.fixed_wing and c == before)]
        around += [] if reach.fixed_wing else [here]
        pays = {c: float(problem.gains.of(c, looks[c])) for c in around if reach.can_go_on(c, here, steps_left)}
        assert pays[there] == max(pays.values())
        before = here


def test_ties_are_broken_at_random_and_by_the_seed_alone():
    gains = Gains.independent(np.full(25, 0.04), np.ones(25))
    problem = SearchProblem(Grid((5, 5)), gains, (Searcher((2, 2), 6, moves=CellMoves("fixed_wing")),))
    plans = {solve(problem, Greedy(), seed=seed).best.plan for seed in range(12)}
    assert len(plans) > 3
    assert solve(problem, Greedy(), seed=4).best.plan == solve(problem, Greedy(), seed=4).best.plan
