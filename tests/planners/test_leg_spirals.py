"""Spirals about one home: round trips that sweep what lies about it, once."""

from itertools import islice

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace
from sooner.planners.leg_ground import LegGround, Routes
from sooner.planners.leg_seeds import first_routes
from sooner.planners.leg_spirals import spiral_loop, spiral_routes
from sooner.problem import Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves
from sooner.sensors.swath import Swath
from tests.grounds import ground as random_ground


def length(way):
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def open_world(searchers, metres, home=(300.0, 300.0), end=(300.0, 300.0), accel=np.inf, space=None):
    """A metre a second over 600 x 600 m."""
    grid = Grid((61, 61), cell_m=10.0)
    space = space or Airspace(shapely.box(-50, -50, 650, 650))
    swath, pace = Swath.seen(grid, 20.0), Pace(1.0, accel)
    flown = tuple(Searcher((30, 30), metres, moves=LegMoves(space, pace, swath, home, end)) for _ in range(searchers))
    return SearchProblem(grid, effort_gains(np.full(grid.n_cells, 1 / grid.n_cells)), flown)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_loops_begin_and_end_at_home_and_sweep_little_twice(count, sense):
    loops = [spiral_loop(number, count, 40.0 / count, 10.0, sense) for number in range(count)]
    assert all(np.abs(loop[[0, -1]]).max() < 1e-9 for loop in loops)
    swept = shapely.union_all([shapely.LineString(loop).buffer(5.0) for loop in loops]).area
    assert 0.94 <= swept / (10.0 * sum(map(length, loops))) <= 1.0
    assert np.ptp([length(loop) for loop in loops]) < 0.01 * length(loops[0])


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("accel", [np.inf, 0.5])
def test_routes_use_up_the_budget_and_are_legal(count, accel):
    problem = open_world(count, 2000.0, accel=accel)
    ground = LegGround(problem)
    routes = spiral_routes(ground, 40.0, 1.0)
    seconds = [ground.seconds(number, route) for number, route in enumerate(routes)]
    assert all(1950.0 < each <= 2000.0 for each in seconds)
    assert evaluate(problem, ground.plan(routes)).value > 0


def test_arms_end_where_nothing_pays():
    problem = open_world(1, 100_000.0)
    route = spiral_routes(LegGround(problem), 40.0, 1.0)[0]
    assert length(route) < 100_000 / 3
    assert evaluate(problem, LegGround(problem).plan([route])).value > 0.95


@pytest.mark.parametrize("end", [None, (200.0, 300.0)])
def test_there_are_none_where_drones_do_not_come_home(end):
    assert spiral_routes(LegGround(open_world(1, 2000.0, end=end)), 40.0, 1.0) is None


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), searchers=st.integers(1, 3))
def test_among_walls_routes_are_legal_by_the_judge(seed, searchers):
    rng = np.random.default_rng(seed)
    drawn = random_ground(rng, 600.0).free
    assume(not drawn.is_empty)
    space = Airspace(drawn)
    homes = rng.uniform(0, 600, (50, 2))
    homes = homes[space.sees(homes)]
    assume(len(homes))
    home = tuple(homes[0].round(2))
    ground = LegGround(open_world(searchers, 1000.0, home, home, float(rng.choice([1.0, np.inf])), space))
    routes = spiral_routes(ground, 40.0, 1.0)
    assert routes is not None
    evaluate(ground.problem, ground.plan(routes))


def test_with_time_to_spare_nothing_is_left_unseen():
    problem = open_world(2, 20_000.0)
    ground = LegGround(problem)
    best = max(Routes(ground, routes, ground.fine).value for routes in islice(first_routes(ground, None), 7))
    assert best == pytest.approx(1.0)
