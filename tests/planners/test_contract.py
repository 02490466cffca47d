"""Every planner on every small problem that it handles."""

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sooner.planners.receding import Receding
from sooner.planners.registry import PLANNERS, make_planner
from sooner.planners.soonest import Soonest
from sooner.planners.team import Team
from sooner.problem import SearchProblem
from tests.planners.contract import check_contract
from tests.planners.region_worlds import best_by_enumeration, region_world
from tests.strategies import problems

relaxed = settings(max_examples=40)


def named(moves: str) -> list[str]:
    """Planners for these moves."""
    return [name for name, entry in PLANNERS.items() if moves in entry.moves]


@pytest.mark.parametrize("name", named("cells"))
@relaxed
@given(problem=problems())
def test_every_planner_over_cells_keeps_the_contract(name: str, problem: SearchProblem) -> None:
    planner = make_planner(name)
    assume(planner.handles(problem) is None)
    check_contract(problem, planner)


@pytest.mark.parametrize("name", named("regions"))
@settings(max_examples=3)
@given(seed=st.integers(0, 500), legs=st.booleans(), ends=st.booleans(), regions=st.integers(1, 3))
def test_every_planner_over_regions_keeps_the_contract(
    name: str, seed: int, legs: bool, ends: bool, regions: int
) -> None:
    problem = region_world(seed, regions, 14.0, legs=legs, ends=ends)
    settings = {"moves": 400} if name == "anneal" else {"first_s": 1.0, "ticks": 5} if name == "exact" else {}
    check_contract(problem, make_planner(name, **settings), most=best_by_enumeration(problem))


def test_a_planner_of_other_moves_refuses_with_a_sentence() -> None:
    over_regions = region_world(0)
    for name in set(named("cells")) - set(named("regions")):
        assert make_planner(name).handles(over_regions) == "it plans moves over cells"


def test_settings_go_to_the_planner_that_has_them() -> None:
    made = make_planner("anneal", walks=3, threads=1)
    assert made.regions.walks == 3
    assert made.cells.threads == made.regions.threads == 1
    with pytest.raises(TypeError, match="colour"):
        make_planner("anneal", colour=3)


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
