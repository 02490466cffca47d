"""Every planner on every small problem that it handles."""

import pytest
from hypothesis import assume, given, settings

from sooner.planners.receding import Receding
from sooner.planners.registry import PLANNERS, make_planner
from sooner.planners.soonest import Soonest
from sooner.planners.team import Team
from sooner.problem import SearchProblem
from tests.planners.contract import check_contract
from tests.strategies import problems

relaxed = settings(max_examples=40)


@pytest.mark.parametrize("name", list(PLANNERS))
@relaxed
@given(problem=problems())
def test_every_planner_keeps_the_contract(name: str, problem: SearchProblem) -> None:
    planner = make_planner(name)
    assume(planner.handles(problem) is None)
    check_contract(problem, planner)


@relaxed
@given(problem=problems())
def test_receding_keeps_the_contract(problem: SearchProblem) -> None:
    check_contract(problem, Receding(make_planner("greedy"), every=2))


@relaxed
@given(problem=problems(target=True))
def test_soonest_keeps_the_contract(problem: SearchProblem) -> None:
    check_contract(problem, Soonest(make_planner("greedy")), ticks=12)


@relaxed
@given(problem=problems())
def test_a_team_of_one_keeps_the_contract(problem: SearchProblem) -> None:
    check_contract(problem, Team(make_planner("greedy")))
