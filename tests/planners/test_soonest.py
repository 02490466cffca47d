from dataclasses import replace

import pytest
from hypothesis import given, settings

from sooner.errors import UnsupportedProblemError
from sooner.planners import Greedy, max_ticks, solve
from sooner.planners.soonest import Soonest
from sooner.problem import Objective, Plan, SearchProblem, evaluate
from tests.oracles.walks import soonest
from tests.problem.test_evaluate import line
from tests.strategies import problems


@settings(max_examples=40)
@given(problem=problems(target=True))
def test_it_is_never_quicker_than_the_quickest_of_all_walks(problem: SearchProblem) -> None:
    best = solve(problem, Soonest(Greedy()), max_ticks(20)).best
    assert -best.value >= soonest(problem)


def test_a_horizon_of_its_own_beats_truncating_the_long_plan() -> None:
    """A greedy flight is the same for every horizon, so the gain is shown with a planner that looks at the horizon."""
    from sooner.problem import Incumbent

    class LeftOrRight:
        """All it can do is fly to one side: to the near small hill, or to the far big one."""

        def handles(self, problem: SearchProblem) -> None:
            return None

        def plans(self, problem: SearchProblem, rng):
            steps, start = problem.searcher.budget, problem.grid.index(problem.searcher.start)
            flights = [[start + way * min(t, reach) for t in range(steps + 1)] for way, reach in ((-1, 2), (1, 6))]
            best = max((Plan.of(f) for f in flights), key=lambda plan: evaluate(problem, plan).value)
            yield Incumbent(best, evaluate(problem, best).value)

    weights = [3.0, 3.0, 0, 0, 0, 0, 0, 3.0, 9.0]
    problem = replace(line(*weights, glimpse=1.0, budget=8), objective=Objective(target=0.3))
    problem = replace(problem, searchers=(replace(problem.searcher, start=(0, 2)),))
    whole = next(LeftOrRight().plans(replace(problem, objective=Objective()), None)).plan
    assert evaluate(problem, whole).value == -6
    assert solve(problem, Soonest(LeftOrRight()), max_ticks(30)).best.value == -2


def test_the_flight_goes_on_after_the_target_and_comes_home() -> None:
    problem = replace(line(1, 1, 1, 1, budget=7, end=(0, 0)), objective=Objective(target=0.25))
    best = solve(problem, Soonest(Greedy()), max_ticks(20)).best
    assert len(best.plan.actions[0]) == 8
    assert best.plan.actions[0][-1] == 0
    assert best.value == -soonest(problem)


def test_a_target_out_of_reach_is_worth_minus_infinity_but_the_best_flight_is_kept() -> None:
    problem = replace(line(1, 1, 1, budget=2), objective=Objective(target=0.99))
    best = solve(problem, Soonest(Greedy()), max_ticks(20)).best
    assert best.value == float("-inf")
    assert evaluate(problem, best.plan).total > 0.3


def test_without_a_target_it_refuses() -> None:
    with pytest.raises(UnsupportedProblemError, match="target"):
        solve(line(1, 1), Soonest(Greedy()))
