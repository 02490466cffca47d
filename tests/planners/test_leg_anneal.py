"""Annealed sorties: the kernels' sums against sums from scratch, legal by the judge, and the planner's contract."""

import copy
import os
import re

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sooner.errors import InfeasibleProblemError, InvalidProblemError
from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace
from sooner.planners import _leg_kernels as kernels
from sooner.planners import max_ticks, solve
from sooner.planners.leg_anneal import LegAnneal
from sooner.planners.leg_ground import LegGround, Routes, leg_searchers
from sooner.planners.leg_seeds import lane_routes
from sooner.planners.planner import follow
from sooner.problem import Objective, Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, places_of
from sooner.sensors.swath import Swath
from tests.grounds import fly_area, leg_world, seconds_of, turns
from tests.grounds import ground as random_ground

uncompiled = os.environ.get("NUMBA_DISABLE_JIT") == "1"
compiled_only = pytest.mark.skipif(uncompiled, reason="walks over a lattice take long uncompiled")
STEPS, CELLS, EXAMPLES = (30, 5, 3) if uncompiled else (1500, 16, 25)
seeds = st.integers(0, 2**32 - 1)
KINDS = ("shift", "lane", "insert", "remove", "swap", "reverse", "move", "tails", "mixed")


def world(seed, searchers=1, ends=None, holes=True, budget_s=300.0):
    """A random search along legs; skipped where it cannot be posed."""
    rng = np.random.default_rng(seed)
    try:
        space = Airspace(random_ground(rng).free) if holes else None
        assume(space is None or space.inner.area > 1e4)
        return leg_world(rng, CELLS, searchers, budget_s, space=space, ends=ends)
    except (InfeasibleProblemError, InvalidProblemError) as error:
        assume("way" not in str(error) and "without" not in str(error))
        raise


def annealed(ground, level, routes, kind, temperature, rounds, seed):
    """The routes after some rounds of changes of one kind, or of all."""
    state = Routes(ground, routes, level)
    weights = np.cumsum(np.ones(8) if kind == "mixed" else np.eye(8)[KINDS.index(kind)])
    words = np.random.default_rng(seed).integers(1, 2**32, 2)
    for _ in range(rounds):
        state.value, state.best_value = kernels.anneal(
            *(state.points, state.counts, state.seconds, state.effort, state.value),
            *(state.best_points, state.best_counts, state.best_value),
            *(ground.budgets, ground.ends, level.pays, STEPS, temperature, 1e-5, 60.0, weights, words),
            *(level.poc, level.ground, level.sight, ground.paces, ground.walls),
        )
    return state


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=EXAMPLES)
@given(seed=seeds, searchers=st.integers(1, 3), hot=st.booleans(), holes=st.booleans())
def test_after_any_changes_all_sums_are_those_from_scratch(kind, seed, searchers, hot, holes):
    problem = world(seed, searchers, holes=holes)
    ground = LegGround(problem)
    assume(len(ground.fine.pays))
    start = [ground.least(number) for number in range(searchers)]
    if kind not in ("insert", "mixed"):
        start = annealed(ground, ground.fine, start, "insert", 1e-3, 1, seed).best
    state = annealed(ground, ground.fine, start, kind, 1e-2 if hot else 1e-5, 2, seed)
    kept = copy.deepcopy((state.value, state.seconds, state.effort))
    assert kept[0] == pytest.approx(state.load(), abs=1e-9)
    assert kept[1] == pytest.approx(state.seconds, abs=1e-6)
    assert kept[2] == pytest.approx(state.effort, abs=1e-6)
    assert (state.seconds <= ground.budgets + 1e-6).all()
    judged = evaluate(problem, ground.plan(state.best))
    assert judged.value == pytest.approx(state.best_value, abs=1e-9)
    now = evaluate(problem, ground.plan([each[:n] for each, n in zip(state.points, state.counts, strict=True)]))
    assert now.value == pytest.approx(state.value, abs=1e-9)


@settings(max_examples=EXAMPLES)
@given(seed=seeds)
def test_the_coarse_level_holds_the_same_mass_over_the_same_ground(seed):
    problem = world(seed, holes=False)
    ground = LegGround(problem)
    fine, coarse = ground.fine, ground.coarse
    assert coarse.poc.sum() == pytest.approx(fine.poc.sum())
    assert middle(coarse) == pytest.approx(middle(fine), abs=coarse.ground[0] / 2)


def middle(level):
    """(2,) float: mean place of the mass."""
    cell_m, height, width, east, north = level.ground
    rows, cols = np.divmod(np.arange(height * width), width)
    places = np.column_stack([east + cols * cell_m, north + (height - 1 - rows) * cell_m])
    return level.poc @ places / level.poc.sum()


# ---------------------------------------------------------------- the contract, over legs


def check(problem, planner, ticks):
    """Moves legal, endurance kept, value equals evaluate, values never fall, same seed same plan, safe to close."""
    assert planner.handles(problem) is None
    before = copy.deepcopy((problem.gains.table, problem.gains.ratio))
    generator, best = planner.plans(problem, np.random.default_rng(3)), -np.inf
    advance = follow(generator)
    for tick in range(ticks):
        following = advance(tick / ticks)
        if following is None:
            break
        incumbent = following
        assert incumbent.value == evaluate(problem, incumbent.plan).value  # raises where it is not legal
        assert incumbent.value >= best
        best = incumbent.value
    generator.close()
    for actions, searcher in zip(incumbent.plan.actions, problem.searchers, strict=True):
        points, each = places_of(actions), searcher.moves
        assert seconds_of(points[turns(points)], each.pace, 1.0) <= searcher.budget * 1.01 + 0.1
    first, again = (solve(problem, planner, max_ticks(3), seed=5).best for _ in range(2))
    assert first.plan == again.plan
    assert np.array_equal(before[0], problem.gains.table)
    return incumbent


quick = LegAnneal(moves=400, threads=1)


@compiled_only
@settings(max_examples=8)
@given(seed=seeds, searchers=st.sampled_from([1, 3]), ends=st.sampled_from([True, False, None]), holes=st.booleans())
def test_the_planner_keeps_the_contract(seed, searchers, ends, holes):
    check(world(seed, searchers, ends, holes), quick, 12)


@compiled_only
@settings(max_examples=8)
@given(seed=seeds, budget_s=st.floats(0.1, 30.0))
def test_tiny_budgets_are_kept(seed, budget_s):
    try:
        problem = world(seed, 2, True, False, budget_s)
    except InfeasibleProblemError:
        assume(False)
    check(problem, quick, 8)


def at(home, end, space, poc, budget=100.0, pace=None, n=1, radius=40.0):
    """A search over ten by ten cells of 50 m."""
    grid = Grid((10, 10), cell_m=50.0)
    moves = LegMoves(space, pace or Pace(10.0, 2.0), Swath.seen(grid, radius), home, end)
    return SearchProblem(grid, effort_gains(poc), (Searcher((9, 0), budget, moves=moves),) * n)


field = shapely.box(-25, -25, 475, 475)


def test_where_nothing_is_in_reach_it_comes_home_at_once():
    poc = np.zeros((10, 10))
    poc[0, 9] = 1.0
    solution = solve(at((0.0, 0.0), (0.0, 0.0), Airspace(field), poc, budget=30.0), quick)
    assert solution.status.value == "finished"
    assert solution.best.value == 0.0
    assert places_of(solution.best.plan.actions[0]).tolist() == [[0.0, 0.0], [0.0, 0.0]]


@compiled_only
@pytest.mark.parametrize("n", [1, 2])
def test_ground_cut_off_by_a_zone_is_left_alone(n):
    space = Airspace(field.difference(shapely.box(200, -30, 260, 500)))
    poc = np.full((10, 10), 0.01)
    best = check(at((100.0, 100.0), (100.0, 100.0), space, poc, 200.0, n=n), quick, 10)
    assert 0.2 < best.value <= 0.5 + 1e-12


@compiled_only
def test_an_open_end_at_home_may_fly_out():
    poc = np.zeros((10, 10))
    poc[0, 9] = 1.0
    best = check(at((0.0, 0.0), None, Airspace(field), poc, budget=75.0), quick, 12)
    assert best.value == pytest.approx(1.0)


@compiled_only
def test_it_flies_around_what_stands_between():
    space = Airspace(field.difference(shapely.box(200, -30, 260, 400)))
    poc = np.zeros((10, 10))
    poc[9, 9] = 1.0
    best = check(at((0.0, 0.0), (0.0, 0.0), space, poc, 250.0), quick, 10)
    assert best.value == pytest.approx(1.0)


def test_drones_that_fly_at_different_speeds_each_keep_their_budget():
    space, poc = Airspace(field), np.full((10, 10), 0.01)
    fast = at((0.0, 0.0), (0.0, 0.0), space, poc, budget=120.0)
    slow = LegMoves(space, Pace(4.0, 1.0), fast.searcher.moves.swath, (0.0, 0.0), (0.0, 0.0))
    searchers = (*fast.searchers, Searcher((9, 0), 150.0, (9, 0), slow))
    solution = solve(SearchProblem(fast.grid, fast.gains, searchers), quick, stop=max_ticks(40), seed=3)
    flown = [each.moves.seconds(places_of(a)) for each, a in zip(searchers, solution.best.plan.actions, strict=True)]
    assert flown[0] <= 120.0 + 1e-6
    assert flown[1] <= 150.0 + 1e-6
    assert solution.best.value > evaluate(fast, solve(fast, quick, stop=max_ticks(40)).best.plan).value


def test_what_it_does_not_plan_it_refuses_with_a_sentence():
    space, poc = Airspace(field), np.full((10, 10), 0.01)
    one, two = at((0.0, 0.0), None, space, poc), at((0.0, 0.0), None, Airspace(field), poc)
    mixed = SearchProblem(one.grid, one.gains, (*one.searchers, *two.searchers))
    assert leg_searchers(mixed) == "it plans drones that share one airspace and one sensor"
    soon = SearchProblem(one.grid, one.gains, one.searchers, Objective(target=0.1))
    assert leg_searchers(soon) == "it plans for the most by the end, not for a target soonest"
    cells = SearchProblem(one.grid, one.gains, (Searcher((0, 0), 9),))
    assert leg_searchers(cells) == "it plans moves along legs"


@settings(max_examples=EXAMPLES)
@given(seed=seeds, searchers=st.integers(1, 3))
def test_first_routes_are_legal(seed, searchers):
    problem = world(seed, searchers)
    ground = LegGround(problem)
    evaluate(problem, ground.plan(lane_routes(ground, seed % 7 / 2.0, 80.0)))


REFUSALS = (
    r"searcher \d: no way from",
    r"searcher \d: the way home alone takes .* s; the budget is",
    r"searcher \d: a wind of .* and at most 8 m/s through the air",
    r"(home|end) at .* m came, which does not lie in the airspace",
    r"an airspace of .* without ground came",
    r"an airspace without places came",
)


@compiled_only
@settings(max_examples=150)
@given(seed=st.integers(0, 2**32 - 1))
def test_over_random_areas_no_leg_crosses_and_no_sortie_is_late_or_a_refusal_says_why(seed):
    flown = fly_area(seed, LegAnneal(moves=200, threads=1), ticks=3)
    assert flown.broken == ()
    assert not flown.refused or any(re.search(words, flown.refused) for words in REFUSALS)
