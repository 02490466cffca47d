"""Moves along legs: places as numbers, every refusal in words, looks in time; and the judge against plain NumPy."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sooner.errors import IllegalPlanError, InfeasibleProblemError, InvalidProblemError
from sooner.grid import Grid
from sooner.grid.airspace import KEPT_M, Airspace
from sooner.motion.pace import Pace, Terrain
from sooner.problem import Gains, Plan, Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, place_numbers, places_of
from sooner.sensors.swath import Swath
from tests.grounds import leg_world, seconds_of

seeds = st.integers(0, 2**32 - 1)
grid = Grid((10, 10), cell_m=10.0)
box = Airspace(shapely.box(0, 0, 90, 90))


def moves(home=(10.0, 10.0), end=(10.0, 10.0), space=box, pace=None, **more):
    return LegMoves(space, pace or Pace(10.0, math.inf), Swath.seen(grid, 12.0), home, end, **more)


def problem_of(each, budget=30.0):
    return SearchProblem(grid, effort_gains(np.full(100, 0.01)), (Searcher((9, 0), budget, moves=each),))


# ---------------------------------------------------------------- places


@given(places=st.lists(st.tuples(*[st.floats(-1e7, 1e7)] * 2), min_size=1, max_size=9).map(np.array))
def test_places_are_kept_to_the_centimetre(places):
    kept = places_of(place_numbers(places))
    assert np.abs(kept - places).max() <= KEPT_M / 2 + 1e-6
    assert (place_numbers(kept) == place_numbers(places)).all()


@pytest.mark.parametrize("place", [(math.nan, 0.0), (math.inf, 0.0), (1.1e7, 0.0), (0.0, -1e300)])
def test_places_beyond_the_earth_are_refused(place):
    with pytest.raises(InvalidProblemError, match="not finite or farther off"):
        place_numbers([place])


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("make", "kind", "told"),
    [
        (lambda: moves(home=(200.0, 0.0)), InvalidProblemError, r"home at \[200.0, 0.0\] m came"),
        (lambda: moves(end=(90.0, 95.0)), InvalidProblemError, r"end at \[90.0, 95.0\] m came"),
        (lambda: moves(departs_s=-1.0), InvalidProblemError, "departs_s = -1.0"),
        (lambda: moves(departs_s=math.nan), InvalidProblemError, "departs_s = nan"),
        (lambda: problem_of(moves(), 0.0), InvalidProblemError, "searcher 0: a budget of 0.0 s came"),
        (lambda: problem_of(moves(), math.nan), InvalidProblemError, "a budget of nan s came"),
        (lambda: problem_of(moves(end=(80.0, 10.0)), 6.9), InfeasibleProblemError, "takes 7.0 s; the budget is 6.9 s"),
        (
            lambda: problem_of(LegMoves(box, Pace(1, 1), Swath(9, "seen", np.ones(3)), (9.0, 9.0))),
            InvalidProblemError,
            "a swath over 3 cells came; the grid has 100",
        ),
        (
            lambda: problem_of(moves(pace=Pace(10.0, 1.0, 8.0, (8.0, 1.0)))),
            InvalidProblemError,
            "a wind of 8.06226 m/s came, and at most 8 m/s through the air",
        ),
    ],
)
def test_what_cannot_be_flown_is_refused_in_words(make, kind, told):
    with pytest.raises(kind, match=told):
        make()


def test_an_end_in_another_part_of_the_airspace_is_infeasible():
    parts = Airspace(shapely.union_all([shapely.box(0, 0, 30, 90), shapely.box(50, 0, 90, 90)]))
    with pytest.raises(InfeasibleProblemError, match="searcher 0: no way from"):
        problem_of(moves(end=(70.0, 10.0), space=parts))


@pytest.mark.parametrize(
    ("places", "told"),
    [
        ([], "no places"),
        ([(20, 10), (10, 10)], r"starts at \(20.00 m east, 10.00 m north\); its home is at \(10.00 m east"),
        ([(10, 10), (20, 10)], r"ends at \(20.00 m east, 10.00 m north\); it must land at \(10.00 m east"),
        ([(10, 10), (20, 20), (95, 20), (10, 10)], r"leg 2, from \(20.00 m east, 20.00 m north\) to \(95.00 m"),
        ([(10, 10), (90, 10), (90, 90), (10, 10)], r"takes 27\.3 s; the budget is 20 s"),
    ],
)
def test_an_illegal_plan_is_refused_with_searcher_leg_and_reason(places, told):
    problem = problem_of(moves(), 20.0)
    with pytest.raises(IllegalPlanError, match="searcher 0: the plan is not legal: .*" + told):
        evaluate(problem, Plan((place_numbers(np.array(places, float).reshape(-1, 2)),)))


def test_a_leg_may_not_cut_through_a_hole():
    space = Airspace(box.free.difference(shapely.box(40, 0, 50, 60)))
    problem = problem_of(moves(space=space), 100.0)
    around = [(10, 10), (40, 60), (50, 60), (80, 10), (50, 60), (40, 60), (10, 10)]
    evaluate(problem, Plan((place_numbers(around),)))
    with pytest.raises(IllegalPlanError, match=r"leg 1, .* enters a no-fly zone"):
        evaluate(problem, Plan((place_numbers([(10, 10), (80, 10), (10, 10)]),)))


# ---------------------------------------------------------------- time, looks and value


def random_plan(rng, problem, most=6):
    """A legal plan: places drawn until they can be flown."""
    routes = []
    for searcher in problem.searchers:
        each = searcher.moves
        west, south, east, north = each.airspace.free.bounds
        for points in range(most, -1, -1):
            inner = np.column_stack([rng.uniform(west, east, points), rng.uniform(south, north, points)])
            ends = [] if each.end is None else [each.end]
            actions = place_numbers(np.concatenate([np.array([each.home]), inner, np.reshape(ends, (-1, 2))]))
            if each.fault(problem.grid, searcher, actions) is None:
                break
        else:
            assume(False)
        routes.append(actions)
    return Plan(tuple(routes))


@settings(max_examples=40)
@given(seed=seeds)
def test_the_seconds_of_a_flight_are_those_of_small_steps(seed):
    rng = np.random.default_rng(seed)
    try:
        problem = leg_world(rng, cells=8)
    except InfeasibleProblemError:
        assume(False)
    points = places_of(random_plan(rng, problem).actions[0])
    each = problem.searcher.moves
    assert each.seconds(points) == pytest.approx(seconds_of(points, each.pace), rel=2e-3, abs=1e-6)


@settings(max_examples=60)
@given(seed=seeds, searchers=st.integers(1, 3))
def test_the_judge_says_what_plain_numpy_says(seed, searchers):
    rng = np.random.default_rng(seed)
    try:
        problem = leg_world(rng, cells=9, searchers=searchers)
    except InfeasibleProblemError:
        assume(False)
    plan = random_plan(rng, problem)
    judged = evaluate(problem, plan)
    effort = np.zeros(problem.grid.n_cells)
    for searcher, actions in zip(problem.searchers, plan.actions, strict=True):
        np.add.at(effort, *searcher.moves.swath.effort(problem.grid, places_of(actions))[:2])
    poc = problem.gains.first / (1 - math.exp(-1))
    assert judged.value == pytest.approx(poc @ -np.expm1(-effort), abs=1e-12)
    assert judged.looks == pytest.approx(effort)
    assert (np.diff(judged.times) > 0).all()
    assert (np.diff(judged.cdp) >= -1e-15).all()
    until = max(each.moves.departs_s + each.budget for each in problem.searchers)
    assert judged.times[-1] <= until + 1e-6
    turned = SearchProblem(problem.grid, problem.gains, problem.searchers[::-1])
    assert evaluate(turned, Plan(plan.actions[::-1])).value == pytest.approx(judged.value, abs=1e-12)
    half = judged.times[len(judged.times) // 2]
    assert judged.cdp_at(half) == pytest.approx(seen_by(problem, plan, half, poc), abs=1e-12)


def seen_by(problem, plan, time, poc):
    """Value of the looks that are over by a time, each when the drone is nearest."""
    effort = np.zeros(problem.grid.n_cells)
    for searcher, actions in zip(problem.searchers, plan.actions, strict=True):
        looks = searcher.moves.looks(problem.grid, searcher, actions)
        now = looks.times <= time
        np.add.at(effort, looks.items[now], looks.worth[now])
    return poc @ -np.expm1(-effort)


@settings(max_examples=30)
@given(seed=seeds)
def test_a_cell_is_looked_at_when_the_drone_is_there(seed):
    rng = np.random.default_rng(seed)
    try:
        problem = leg_world(rng, cells=8)
    except InfeasibleProblemError:
        assume(False)
    plan = random_plan(rng, problem)
    each, searcher = problem.searcher.moves, problem.searcher
    flight, looks = each.flight(plan.actions[0]), each.looks(problem.grid, searcher, plan.actions[0])
    assert flight.duration == pytest.approx(each.seconds(places_of(plan.actions[0])))
    seen = looks.worth > 0
    here = flight.at(looks.times[seen] - each.departs_s)[0]
    far = np.hypot(*(here - problem.grid.centres_m[looks.items[seen]]).T)
    assert (far <= each.swath.radius_m + 1e-3).all()
    assert looks.times[-1] == each.departs_s + flight.duration
    assert looks.worth[-1] == 0.0


def test_a_sortie_looks_from_when_it_departs():
    later = problem_of(moves(departs_s=100.0))
    plan = Plan((place_numbers([(10, 10), (50, 10), (10, 10)]),))
    assert evaluate(later, plan).times == pytest.approx(evaluate(problem_of(moves()), plan).times + 100.0)
    assert evaluate(later, plan).times[-1] == pytest.approx(108.0)


def test_terrain_costs_time_along_legs():
    steep = Pace(10.0, math.inf, climb_mps=1.0, terrain=Terrain(np.tile(np.arange(10) * 5.0, (10, 1)), 10.0))
    each = moves(pace=steep)
    assert each.seconds([(10, 10), (50, 10)]) == pytest.approx(20.0)  # 20 m up
    assert each.seconds([(50, 10), (10, 10)]) == pytest.approx(4.0)


# ---------------------------------------------------------------- gains of effort


@settings(max_examples=60)
@given(seed=seeds, looks=st.integers(0, 8), columns=st.integers(1, 4))
def test_the_total_of_whole_looks_is_the_sum_of_their_gains(seed, looks, columns):
    rng = np.random.default_rng(seed)
    table = np.sort(rng.random((5, columns)), axis=1)[:, ::-1]
    gains = Gains(table, rng.choice([0.0, 0.3, 1.0], 5))
    cells = np.arange(5)
    expected = sum((gains.of(cells, np.full(5, k)) for k in range(looks)), np.zeros(5))
    assert gains.total(cells, np.full(5, float(looks))) == pytest.approx(expected)


@settings(max_examples=60)
@given(seed=seeds)
def test_the_total_of_a_table_of_one_column_rises_ever_more_slowly(seed):
    rng = np.random.default_rng(seed)
    gains = Gains(rng.random((1, 1)), rng.random(1))
    total = gains.total(np.zeros(400, int), np.arange(400) / 50)
    assert total[0] == 0.0
    assert (np.diff(total) >= 0).all()
    assert (np.diff(total, 2) <= 1e-12).all()


@given(poc=st.floats(0.0, 1.0), effort=st.floats(0.0, 50.0))
def test_effort_detects_exponentially(poc, effort):
    total = effort_gains([poc]).total(np.array([0]), np.array([effort]))
    assert total == pytest.approx(poc * -math.expm1(-effort), abs=1e-14)
