"""What every planner must keep, checked on one problem; planners of your own can be put through it too."""

import copy

import numpy as np

from sooner.planners import Planner, max_ticks, solve
from sooner.planners.planner import follow
from sooner.problem import SearchProblem, evaluate
from tests.oracles.walks import optimum, soonest


def check_contract(problem: SearchProblem, planner: Planner, ticks: int = 6, most: float | None = None) -> None:
    """Moves legal, endurance kept, value equals evaluate, value <= optimum <= bound, both monotone, same seed same
    plan, problem untouched, safe to close early. `most` is the optimum, where the caller knows it."""
    assert planner.handles(problem) is None
    before = copy.deepcopy((problem.gains.table, problem.gains.ratio, problem.grid.obstacles))
    best = -np.inf
    bound = np.inf
    generator = planner.plans(problem, np.random.default_rng(3))
    advance = follow(generator)
    target = problem.objective.target
    if most is None:
        most = optimum(problem) if target is None else -soonest(problem)
    for tick in range(ticks):
        incumbent = advance(tick / ticks)
        if incumbent is None:
            break
        score = evaluate(problem, incumbent.plan)  # raises where a move is illegal or the budget is passed
        assert incumbent.value == score.value
        assert incumbent.value >= best, "values never fall"
        assert incumbent.bound <= bound, "bounds never rise"
        best, bound = incumbent.value, incumbent.bound
        assert best <= most + 1e-12
        assert most <= bound + 1e-12
    assert best > -np.inf or target is not None, "at least one plan"
    if hasattr(generator, "close"):
        generator.close()
    first = solve(problem, planner, max_ticks(3), seed=5)
    again = solve(problem, planner, max_ticks(3), seed=5)
    assert first.best.plan == again.best.plan, "same seed, same plan"
    after = (problem.gains.table, problem.gains.ratio, problem.grid.obstacles)
    for old, new in zip(before, after, strict=True):
        assert (old is None and new is None) or np.array_equal(old, new), "problem untouched"
