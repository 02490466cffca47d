"""Fewer places for nearly the same: what goes is told by the judge, and stays legal."""

import numpy as np
import pytest
import shapely

from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace
from sooner.planners.leg_tidy import GIVEN_UP, tidied
from sooner.problem import Plan, Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, place_numbers, places_of
from sooner.sensors.swath import Swath

HOME = (0.0, 0.0)


def strip(end=HOME, holes=None) -> SearchProblem:
    grid = Grid((6, 40), "square8", 10.0)
    free = shapely.box(-5, -5, 395, 55)
    space = Airspace(free if holes is None else free.difference(holes))
    moves = LegMoves(space, Pace(10.0, 2.0), Swath.of_width(grid, 20.0, 15.0), HOME, end)
    gains = effort_gains(np.full(grid.n_cells, 1.0 / grid.n_cells))
    return SearchProblem(grid, gains, (Searcher((5, 0), 200.0, None if end is None else (5, 0), moves),))


def plan_of(*places) -> Plan:
    return Plan((place_numbers(places),))


def test_a_stub_of_a_few_metres_goes():
    problem = strip()
    plan = plan_of(HOME, (200.0, 30.0), (200.3, 30.4), (380.0, 45.0), (380.0, 15.0), HOME)
    found = tidied(problem, plan)
    assert len(found.actions[0]) == 5
    assert [tuple(place) for place in places_of(found.actions[0])[[0, 3]].tolist()] == [HOME, (380.0, 15.0)]
    assert evaluate(problem, found).total >= (1 - GIVEN_UP) * evaluate(problem, plan).total


@pytest.mark.parametrize("end", [HOME, None])
def test_nothing_that_finds_something_goes(end):
    problem = strip(end)
    plan = plan_of(HOME, (200.0, 30.0), (380.0, 45.0), (380.0, 15.0), *([HOME] if end else []))
    assert tidied(problem, plan) == plan


def test_a_place_on_the_way_round_a_zone_stays():
    problem = strip(holes=shapely.box(100, -5, 120, 30))
    way = [HOME, (99.0, 31.0), (121.0, 31.0), (200.0, 0.0), (121.0, 31.0), (99.0, 31.0), HOME]
    found = tidied(problem, plan_of(*way), give_up=0.05)
    assert problem.searcher.moves.fault(problem.grid, problem.searcher, found.actions[0]) is None
    assert evaluate(problem, found).total >= 0.95 * evaluate(problem, plan_of(*way)).total


def test_all_may_go_where_all_may_be_given_up():
    problem = strip()
    found = tidied(problem, plan_of(HOME, (200.0, 30.0), (380.0, 45.0), HOME), give_up=1.0)
    assert places_of(found.actions[0]).tolist() == [list(HOME), list(HOME)]
