from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from sooner.bounds import Bound
from sooner.planners import Greedy, max_ticks, solve
from sooner.planners.proved import Proved
from sooner.planners.receding import Receding
from sooner.planners.soonest import Soonest
from sooner.problem import SearchProblem, evaluate
from tests.planners.contract import check_contract
from tests.problem.test_evaluate import drifting, line
from tests.strategies import problems


@settings(max_examples=25)
@given(problem=problems())
def test_a_proved_planner_keeps_the_contract(problem: SearchProblem) -> None:
    check_contract(problem, Proved(Greedy(), linger=0.2))


@settings(max_examples=15)
@given(problem=problems(target=True))
def test_a_proved_soonest_keeps_the_contract(problem: SearchProblem) -> None:
    check_contract(problem, Proved(Soonest(Greedy()), linger=0.2))


def test_it_names_the_proof_and_what_that_assumes() -> None:
    best = solve(line(1, 2, 3, budget=3), Proved(Greedy())).best
    assert best.bound >= best.value
    assert best.bound_proof
    assert "look" in best.bound_assumes


def test_the_proof_changes_nothing_about_the_plan() -> None:
    problem = line(1, 5, 2, 2, 8, budget=5)
    alone = solve(problem, Greedy(), seed=2).best.plan
    assert solve(problem, Proved(Greedy()), seed=2).best.plan == alone


def test_where_nothing_is_proved_the_bound_is_infinite() -> None:
    best = solve(drifting(), Proved(Receding(Greedy(), every=2), linger=0.1)).best
    assert best.bound == np.inf
    assert best.bound_proof == ""


def test_a_proof_that_breaks_says_so() -> None:
    def broken(problem, known):
        yield Bound(1.0, "first", "")
        raise ZeroDivisionError("in the proof")

    with pytest.raises(ZeroDivisionError, match="in the proof"):
        solve(line(1, 2, 3), Proved(Greedy(), prover=broken))


def test_a_target_out_of_reach_is_proved_to_be_so_and_the_time_still_used() -> None:
    from sooner.problem import Objective

    problem = replace(line(1, 1, 1, budget=2), objective=Objective(target=0.99))
    solution = solve(problem, Proved(Soonest(Greedy())), max_ticks(50))
    assert solution.best.value == solution.best.bound == -np.inf
    assert solution.status.value in ("stopped", "finished")
    assert evaluate(problem, solution.best.plan).total > 0.3
