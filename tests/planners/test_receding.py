from dataclasses import replace

import numpy as np
import pytest

from sooner.planners import Greedy, max_ticks, solve
from sooner.planners.receding import Receding, held_still
from sooner.problem import evaluate
from tests.problem.test_evaluate import drifting, line


def test_without_drift_it_never_loses_to_planning_once() -> None:
    for weights in ((1, 0, 0, 3), (2, 1, 5, 1), (0, 0, 0, 1)):
        problem = line(*weights, budget=9)
        once = solve(problem, Greedy(), seed=4).best.value
        assert solve(problem, Receding(Greedy(), every=2), seed=4).best.value >= once


def test_with_drift_it_finds_a_person_who_has_walked_away() -> None:
    gained = []
    for seed in range(10):
        problem = drifting(seed)
        once = solve(problem, Receding(Greedy(), every=5), seed=seed).best.value
        again = solve(problem, Receding(Greedy(), every=1), seed=seed).best.value
        gained.append(again - once)
    assert np.mean(gained) > 0


def test_its_value_is_that_of_the_judge_who_lets_the_person_move() -> None:
    problem = drifting(3)
    best = solve(problem, Receding(Greedy(), every=2)).best
    assert best.value == evaluate(problem, best.plan).value


def test_the_person_is_held_where_he_will_be_in_the_middle_of_the_window() -> None:
    problem = drifting(2)
    moved = problem.drift.poc @ problem.drift.transition @ problem.drift.transition
    assert held_still(problem, 4).gains.first == pytest.approx(moved * problem.drift.glimpse)
    assert held_still(replace(problem, drift=None), 4).gains is problem.gains


def test_a_run_of_known_length_is_shared_out_among_the_replans() -> None:
    problem = line(1, 2, 3, 4, budget=8)
    assert len(solve(problem, Receding(Greedy(), every=2), max_ticks(100)).best.plan.actions[0]) == 9
