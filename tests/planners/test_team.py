from dataclasses import replace

import numpy as np
import pytest

from sooner.belief import Belief
from sooner.grid import Grid
from sooner.planners import Greedy, solve
from sooner.planners.team import Team
from sooner.problem import Searcher, SearchProblem, detection_gains, evaluate


def two_hills(*starts: tuple[int, int], end: tuple[int, int] | None = None) -> SearchProblem:
    weights = np.zeros((5, 11))
    weights[:, :3] = weights[:, 8:] = 1.0
    gains = detection_gains(Belief.from_weights(weights), 0.8)
    return SearchProblem(Grid((5, 11)), gains, tuple(Searcher(start, 14, end) for start in starts))


def test_two_searchers_side_by_side_share_the_work() -> None:
    problem = two_hills((2, 0), (2, 10))
    alone = solve(replace(problem, searchers=problem.searchers[:1]), Greedy()).best.value
    team = solve(problem, Team(Greedy())).best
    assert team.value > 1.8 * alone
    assert team.value == evaluate(problem, team.plan).value


def test_searchers_from_the_same_start_do_not_fly_the_same_flight() -> None:
    problem = two_hills((2, 1), (2, 1))
    plan = solve(problem, Team(Greedy())).best.plan
    assert not np.array_equal(plan.actions[0], plan.actions[1])


def test_every_searcher_ends_at_its_end() -> None:
    problem = two_hills((2, 1), (2, 3), end=(0, 4))
    plan = solve(problem, Team(Greedy())).best.plan
    assert [problem.grid.cell(flight[-1]) for flight in plan.actions] == [(0, 4), (0, 4)]


def test_a_team_refuses_a_person_who_moves() -> None:
    from sooner.errors import UnsupportedProblemError
    from sooner.motion import drift_transition
    from sooner.problem import Drift

    problem = two_hills((2, 0), (2, 10))
    drift = Drift(problem.gains.first / 0.8, np.full(55, 0.8), drift_transition(problem.grid, 0.2))
    with pytest.raises(UnsupportedProblemError, match="stays"):
        solve(replace(problem, drift=drift), Team(Greedy()))
