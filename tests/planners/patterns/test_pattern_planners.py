"""Patterns as planners along legs: cut to sorties that go on where the last one ended; legal, and in time."""

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace, Terrain
from sooner.planners import max_ticks, solve
from sooner.planners.leg_ground import LegGround
from sooner.planners.patterns import Contour, CreepingLine, ExpandingSquare, NoGap, ParallelTrack, Sector
from sooner.planners.patterns.searched import connected
from sooner.planners.patterns.sorties import shared_out
from sooner.planners.registry import PLANNERS, make_planner
from sooner.problem import Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, places_of
from sooner.sensors.swath import Swath
from tests.grounds import ground, leg_world
from tests.planners.contract import check_contract

NAMES = ("parallel-track", "creeping-line", "expanding-square", "sector", "contour", "no-gap")
seeds = st.integers(0, 2**32 - 1)
all_ticks = max_ticks(10**6)


def field(budgets, *, poc=None, swath=None, space=None, cells=40, home=(200.0, 200.0), pace=None, end=True):
    """A square of 400 m with a home in the middle, perfect discs of 25 m, 10 m/s without time for turns."""
    grid = Grid((cells, cells), cell_m=400.0 / cells)
    space = space or Airspace.of_cells(np.ones(grid.shape, bool), grid.cell_m)
    poc = np.full(grid.n_cells, 1.0 / grid.n_cells) if poc is None else poc
    moves = [
        LegMoves(space, pace or Pace(10.0, math.inf), swath or Swath.seen(grid, 25.0), home, home if end else None, k)
        for k in range(len(budgets))
    ]
    if swath is None:
        shared = moves[0].swath
        moves = [LegMoves(space, each.pace, shared, home, each.end, each.departs_s) for each in moves]
    team = tuple(Searcher((0, 0), budget, moves=each) for budget, each in zip(budgets, moves, strict=True))
    return SearchProblem(grid, effort_gains(poc), team)


def best(problem, planner):
    return solve(problem, planner, all_ticks, seed=1).best


def routes(incumbent):
    return [places_of(actions) for actions in incumbent.plan.actions]


def length(points):
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


# ---------------------------------------------------------------- every pattern on any ground


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=3, deadline=None)
@given(seed=seeds, searchers=st.integers(1, 3), budget=st.floats(20, 500))
def test_every_pattern_keeps_the_contract_and_every_leg_stays_in_the_ground(name, seed, searchers, budget):
    rng = np.random.default_rng(seed)
    drawn = ground(rng)
    try:
        problem = leg_world(rng, 12, searchers, budget, space=Airspace(drawn.free))
    except (InvalidProblemError, AssertionError):
        assume(False)
    planner = make_planner(name)
    assume(planner.handles(problem) is None)
    check_contract(problem, planner, most=1.0)
    for route in routes(best(problem, planner)):
        assert drawn.allows(route)


# ---------------------------------------------------------------- cut to sorties


def test_a_sortie_goes_on_exactly_where_the_last_one_turned_home():
    problem = field([85.0, 75.0, 80.0])
    ground_of = LegGround(problem)
    (searched,) = connected(ground_of)
    track = np.array([(0.0, 0.0), (390.0, 0.0), (390.0, 50.0), (0.0, 50.0), (0.0, 100.0), (390.0, 100.0)])
    flown = shared_out(ground_of, (track,), searched.numbers)
    legs = [shapely.LineString(flown[number][1:-1]) for number in range(3)]
    for before, after in pairwise(legs):
        assert before.coords[-1] == after.coords[0]
    assert sum(leg.length for leg in legs) <= length(track)
    assert shapely.union_all(legs).difference(shapely.LineString(track).buffer(0.02)).is_empty
    for number in range(3):
        seconds = problem.searchers[number].moves.seconds(flown[number])
        assert problem.searchers[number].budget - 0.1 <= seconds <= problem.searchers[number].budget


def test_where_the_pattern_is_shorter_than_all_sorties_they_land_early():
    problem = field([100.0, 100.0, 100.0])
    ground_of = LegGround(problem)
    flown = shared_out(ground_of, (np.array([(200.0, 300.0), (250.0, 300.0)]),), (0, 1, 2))
    assert length(flown[0]) == pytest.approx(100 + 50 + np.hypot(50, 100), abs=0.1)
    assert np.array_equal(flown[1], ground_of.least(1))
    assert np.array_equal(flown[2], ground_of.least(2))


def test_what_is_out_of_reach_is_left_out_and_the_sortie_goes_on_behind_it():
    problem = field([20.0])  # 100 m there and 100 m back
    ground_of = LegGround(problem)
    track = np.array([(20.0, 20.0), (20.0, 200.0), (200.0, 240.0), (200.0, 260.0)])
    flown = shared_out(ground_of, (track,), (0,))
    assert np.abs(flown[0] - (200.0, 240.0)).sum(axis=1).min() < 0.02


def test_sorties_of_one_part_of_the_airspace_leave_the_others_their_own():
    space = Airspace(shapely.union_all([shapely.box(0, 0, 180, 390), shapely.box(220, 0, 390, 390)]))
    grid = Grid((40, 40), cell_m=10.0)
    sees, pace = Swath.seen(grid, 25.0), Pace(10.0, math.inf)
    team = tuple(
        Searcher((0, 0), 600.0, moves=LegMoves(space, pace, sees, home, home)) for home in ((90.0, 50.0), (300.0, 50.0))
    )
    problem = SearchProblem(grid, effort_gains(np.full(1600, 1 / 1600)), team)
    west, east = routes(best(problem, ParallelTrack()))
    assert west[:, 0].max() < 180
    assert east[:, 0].min() > 220
    assert min(len(west), len(east)) > 5


# ---------------------------------------------------------------- the patterns themselves


def test_an_expanding_square_begins_where_the_poc_peaks_with_legs_of_one_one_two_two_spacings():
    poc = np.full(1600, 1e-6)
    grid = Grid((40, 40), cell_m=10.0)
    peak = grid.index((25, 12))
    poc[peak] = 0.5
    problem = field([70.0], poc=poc)
    assert np.allclose(connected(LegGround(problem))[0].datums(50.0)[0], grid.centres_m[peak])
    route = routes(best(problem, ExpandingSquare(datum=tuple(grid.centres_m[peak]))))[0]
    first = int(np.argmin(np.hypot(*(route - grid.centres_m[peak]).T)))
    steps = np.hypot(*np.diff(route[first:], axis=0).T)
    assert np.allclose(route[first], grid.centres_m[peak], atol=0.02)
    assert np.allclose(steps[:4], [50, 50, 100, 100], atol=0.02)


def test_a_sector_search_passes_its_datum_again_and_again():
    route = routes(best(field([3000.0]), Sector(datum=(200.0, 150.0), radius_m=90.0)))[0]
    passes = np.flatnonzero(np.hypot(*(route - (200.0, 150.0)).T) < 0.02)
    assert len(passes) >= 3
    assert np.allclose(np.hypot(*(route[1:-1] - (200.0, 150.0)).T).max(), 90.0, atol=0.02)


def test_a_parallel_track_of_perfect_discs_misses_next_to_nothing_when_there_is_time_for_all():
    problem = field([2000.0])
    assert best(problem, ParallelTrack()).value > 0.98
    assert best(problem, CreepingLine()).value > 0.98


def test_where_the_person_is_likely_at_one_end_the_search_is_there():
    poc = np.zeros((40, 40))
    poc[:8, :8] = 1 / 64
    for planner in (ParallelTrack(), CreepingLine()):
        assert best(field([100.0], poc=poc.ravel()), planner).value > 0.6


def test_by_sweep_width_wider_spacings_are_tried_than_a_coverage_of_one():
    grid = Grid((40, 40), cell_m=10.0)
    problem = field([400.0], swath=Swath.of_width(grid, 20.0, 30.0))
    (searched,) = connected(LegGround(problem))
    assert np.allclose(searched.spacings(None, 0.0), (20.0, 30.0, 40.0))
    assert searched.spacings(35.0, 0.0) == (35.0,)
    narrow = best(problem, ParallelTrack(spacing_m=20.0)).value
    assert best(problem, ParallelTrack()).value >= narrow


def test_no_gap_leaves_no_cell_unseen_round_a_no_fly_zone():
    hole = shapely.box(130, 130, 180, 170)
    space = Airspace(shapely.box(-5, -5, 395, 395) - hole)
    problem = field([900.0, 900.0], space=space)
    found = best(problem, NoGap())
    assert found.value == pytest.approx(1.0)
    assert (evaluate(problem, found.plan).looks > 0).all()


def test_no_gap_ends_early_where_sorties_are_too_short():
    assert 0.1 < best(field([100.0]), NoGap()).value < 0.9


def test_a_contour_search_needs_elevation():
    problem = field([100.0])
    assert Contour().handles(problem) == "it follows contour lines, and no elevation came"
    heights = np.repeat(np.linspace(100.0, 0.0, 40)[:, None], 40, axis=1)
    sloping = Pace(10.0, math.inf, climb_mps=5.0, descent_mps=5.0, terrain=Terrain(heights, 10.0))
    route = routes(best(field([2000.0], pace=sloping), Contour()))[0]
    flat = np.abs(np.diff(route, axis=0)[1:-1, 1]) < 0.02
    assert np.hypot(*np.diff(route, axis=0)[1:-1][flat].T).sum() > 2500


def test_where_nothing_can_be_found_drones_stay_at_home():
    problem = field([100.0], poc=np.zeros(1600))
    for planner in (ParallelTrack(), ExpandingSquare(), Sector(), NoGap()):
        assert best(problem, planner).value == 0.0


def test_every_pattern_is_registered_and_refuses_cells():
    assert set(NAMES) <= set(PLANNERS)
    cells = SearchProblem(Grid((1, 3)), effort_gains(np.ones(3) / 3), (Searcher((0, 0), 2),))
    for name in NAMES:
        assert PLANNERS[name].moves == ("legs",)
        assert make_planner(name).handles(cells) == "it plans moves along legs"


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ParallelTrack(spacing_m=0.0), "spacing_m = 0.0"),
        (lambda: CreepingLine(overlap=1.0), "overlap = 1.0"),
        (lambda: ExpandingSquare(datum=(math.nan, 0.0)), "datum = "),
        (lambda: Sector(radius_m=-5.0), "radius_m = -5.0"),
        (lambda: Contour(spacing_m=math.inf), "spacing_m = inf"),
        (lambda: NoGap(overlap=-0.1), "overlap = -0.1"),
    ],
)
def test_settings_that_make_no_sense_are_refused(make, said):
    with pytest.raises(InvalidProblemError, match=said):
        make()
