from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from sooner.belief import Belief
from sooner.bounds import bounds
from sooner.grid import Grid
from sooner.planners import Greedy, max_ticks, solve
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.region_greedy import RegionGreedy
from sooner.planners.team import Team
from sooner.problem import Searcher, SearchProblem, detection_gains, evaluate
from tests.planners.region_worlds import region_world


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


@pytest.mark.parametrize("seed", range(4))
def test_two_searchers_over_regions_collect_more_than_one_and_no_more_than_is_proved(seed):
    one = region_world(seed, 5, 16.0, extra=2)
    two = replace(one, searchers=one.searchers * 2)
    inner = RegionAnneal(moves=400, longest=20, walks=2)
    alone = solve(one, inner, max_ticks(20), seed).best.value
    team = solve(two, Team(inner, rounds=1, ticks=8), seed=seed).best
    assert alone < team.value <= min(bound.value for bound in islice(bounds(two), 20)) + 1e-9
    assert team.value == evaluate(two, team.plan).value


def test_what_others_look_at_is_what_is_left_over_regions():
    problem = region_world(3, 5, 16.0)
    two = replace(problem, searchers=problem.searchers * 2)
    first = solve(two, Team(RegionGreedy(), rounds=0)).best.plan.actions
    looked = problem.searcher.moves.looks(problem.grid, problem.searcher, first[0]).items
    left = replace(problem, gains=problem.gains.after(np.bincount(looked, minlength=problem.gains.n_cells)))
    assert np.array_equal(first[1], solve(left, RegionGreedy()).best.plan.actions[0])
