"""The same legs, earlier: nothing is lost, and what was to be found soon is found no later."""

import numpy as np
import pytest
import shapely

from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace
from sooner.planners.leg_early import earlier_within
from sooner.problem import Plan, Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, place_numbers
from sooner.sensors.swath import Swath

HOME = (0.0, 0.0)


def two_sorties(wind=(0.0, 0.0), budget=100.0):
    """Two batteries of one drone, one after the other, over a strip whose far end holds most."""
    grid = Grid((3, 40), "square8", 10.0)
    poc = np.tile(np.linspace(0.1, 1.0, 40) ** 4, (3, 1))
    space, pace = Airspace(shapely.box(-5, -5, 395, 25)), Pace(10.0, 2.0, airspeed_mps=15.0, wind=wind)
    swath = Swath.seen(grid, 12.0)
    searchers = tuple(
        Searcher((2, 0), budget, (2, 0), LegMoves(space, pace, swath, HOME, HOME, departs)) for departs in (0.0, 200.0)
    )
    return SearchProblem(grid, effort_gains(poc / poc.sum()), searchers)


def plan_of(*ways) -> Plan:
    return Plan(tuple(place_numbers([HOME, *way, HOME]) for way in ways))


def test_the_sortie_that_finds_most_flies_first():
    problem = two_sorties()
    late = plan_of([(100.0, 10.0)], [(380.0, 10.0)])
    early = earlier_within(problem, late, 10.0)
    before, after = evaluate(problem, late), evaluate(problem, early)
    assert after.total == pytest.approx(before.total, rel=1e-9)
    assert after.early_share > before.early_share + 0.1
    assert early.actions[0].tolist() in (late.actions[1].tolist(), late.actions[1][::-1].tolist())


def test_a_flight_is_reversed_where_its_end_is_rich():
    problem = two_sorties(budget=150.0)
    way = [(100.0, 10.0), (20.0, 20.0), (380.0, 0.0)]
    early = earlier_within(problem, plan_of(way, [(10.0, 10.0)]), 10.0)
    assert early.actions[0].tolist() == plan_of(way[::-1]).actions[0].tolist()


def test_what_has_no_time_the_other_way_round_stays():
    problem = two_sorties(wind=(7.0, 0.0), budget=95.0)
    way = [(380.0, 5.0)]
    plan = plan_of(way, [(30.0, 10.0)])
    early = earlier_within(problem, plan, 10.0)
    assert evaluate(problem, early).early_share >= evaluate(problem, plan).early_share


def test_a_plan_that_finds_nothing_and_no_time_leave_it_as_it_is():
    problem = two_sorties()
    nothing = Plan(tuple(place_numbers([HOME, HOME]) for _ in range(2)))
    assert earlier_within(problem, nothing, 1.0) == nothing or evaluate(problem, nothing).total > 0
    late = plan_of([(100.0, 10.0)], [(380.0, 10.0)])
    assert earlier_within(problem, late, -1.0) == late
