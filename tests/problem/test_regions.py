"""Moves over regions, atoms, and the problem that ground makes of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.decomposition.boustrophedon import boustrophedon
from sooner.decomposition.regions import Regions
from sooner.errors import IllegalPlanError, InfeasibleProblemError, InvalidProblemError
from sooner.grid import Grid
from sooner.motion.kinematics import Dynamics
from sooner.motion.trajectory import integrated
from sooner.problem import Gains, Plan, evaluate
from sooner.problem.atoms import Footprints, atom_gains, atoms_of
from sooner.problem.region_problem import PRESET_A, Sweep, region_problem, two_searches_s
from sooner.sensors.footprint import cell_passes
from tests.planners.region_worlds import COLUMNS, cell_gains, region_world


def ground() -> Grid:
    rock = np.zeros((24, 40), bool)
    rock[8:16, 14:26] = True
    return Grid(rock.shape, "square8", 2.2, rock)


def posed(start=(4, 4), budget=900.0, end=None, sweep=PRESET_A, grid=None):
    grid = grid or ground()
    rng = np.random.default_rng(0)
    gains = cell_gains(grid, rng)
    regions = boustrophedon(grid, min_cells=20, min_columns=2, at_width=40)
    return region_problem(grid, regions, sweep, gains, [start], budget, [end]), gains


def a_walk(problem, steps=9, seed=0):
    """A legal walk of at most so many actions."""
    moves, rng = problem.searcher.moves, np.random.default_rng(seed)
    here, walk, left = moves.first, [], problem.searcher.budget - moves.leg_s
    for _ in range(steps):
        ways = [(here, here), *moves.graph.ways[here]]
        ways = [way for way in ways if moves.graph.seconds[way[0]] + moves.to_last[way[1]] <= left]
        if not ways:
            break
        action, here = ways[rng.integers(len(ways))]
        left -= moves.graph.seconds[action]
        walk.append(action)
    while moves.last not in (-1, here):
        action, here = min(moves.graph.ways[here], key=lambda way: moves.graph.seconds[way[0]] + moves.to_last[way[1]])
        walk.append(action)
    return Plan.of(walk)


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000), legs=st.booleans())
def test_atoms_are_worth_what_their_cells_are_worth_one_by_one(seed, legs):
    problem = region_world(seed, 4, 60.0, legs=legs)
    gains = cell_gains(problem.grid, np.random.default_rng(seed + 1))
    rows = atom_gains(problem.searcher.moves.atoms, lambda asked: gains.of(asked[:, None], np.arange(COLUMNS)))
    problem = problem.__class__(problem.grid, rows, problem.searchers)
    plan = a_walk(problem, seed=seed)
    looks = problem.searcher.moves.cell_looks(problem.grid, plan.actions[0])
    cells = np.repeat(np.arange(problem.grid.n_cells), looks)
    before = np.concatenate([np.arange(count) for count in looks]) if cells.size else cells
    assert evaluate(problem, plan).value == pytest.approx(gains.of(cells, before).sum(), rel=1e-12)


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000))
def test_cells_are_of_one_atom_just_where_the_same_actions_look_at_them(seed):
    rng = np.random.default_rng(seed)
    covers = [np.repeat(np.arange(30), rng.choice(3, 30, p=[0.5, 0.35, 0.15])) for _ in range(5)]
    starts = np.concatenate([[0], np.cumsum([len(cover) for cover in covers])])
    cells = np.concatenate(covers).astype(np.int32)
    zero = np.zeros(len(cells), np.float32)
    atoms = atoms_of(Footprints(starts, cells, zero, zero), 30)
    sets = [tuple((cover == cell).sum() for cover in covers) for cell in range(30)]
    for one in range(30):
        for other in range(30):
            same = atoms.of_cell[one] == atoms.of_cell[other]
            assert same == (sets[one] == sets[other])
    assert atoms.sizes.sum() == sum(any(each) for each in sets)


def test_what_an_atom_pays_never_rises_and_is_clamped_beyond_its_table():
    problem = region_world(2)
    assert (np.diff(problem.gains.table, axis=1) <= 0).all()
    assert problem.gains.of(np.array([0]), np.array([10_000]))[0] == 0.0


@pytest.mark.parametrize(
    "sweep", [PRESET_A, Sweep(taut=True), Sweep(round_turns=True)], ids=["preset A", "taut", "rounded"]
)
def test_actions_integrated_in_small_steps_end_where_and_when_they_say(sweep):
    moves = posed(start=(2, 3), sweep=sweep)[0].searcher.moves
    for action, path in enumerate(moves.graph.paths):
        flight = sweep.flight(path)
        assert moves.graph.seconds[action] == flight.duration
        flown = integrated(flight, dt=0.01)
        assert max(flown.end_m, flown.end_mps) < 1e-3 * max(flight.length_m, 1.0)
        assert flown.top_mps < 2.0 + 1e-4
        assert flown.top_mps2 < 2.0 + 1e-4


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), spacing_m=st.sampled_from([8.8, 17.6]))
def test_no_plan_is_credited_with_more_passes_than_its_flight_makes(seed, spacing_m):
    problem, _ = posed(start=(2, 3), end=(20, 36), sweep=Sweep(spacing_m=spacing_m))
    moves, plan = problem.searcher.moves, a_walk(problem, 12, seed).actions[0]
    credited = moves.cell_looks(problem.grid, plan)
    cells = cell_passes(problem.grid, moves.path(plan), 8.8)[0]
    made = np.bincount(cells, minlength=problem.grid.n_cells)
    never_out = np.zeros(problem.grid.n_cells, np.int64)
    for action in plan.tolist():
        if action < moves.graph.n_regions:
            path = moves.graph.paths[action]
            seen, began, ended = cell_passes(problem.grid, path, 8.8)
            whole = (began <= 1e-6) & (ended >= np.hypot(*np.diff(path, axis=0).T).sum() - 1e-6)
            never_out += np.bincount(seen[whole], minlength=problem.grid.n_cells)
    assert (credited <= made + never_out).all()
    assert credited.sum() > 0.6 * made.sum()


def test_a_finer_cut_is_credited_for_what_is_flown_not_for_the_number_of_regions():
    grid = Grid((30, 60), "square8", 2.2)
    whole = Regions.from_labels(grid, np.zeros(grid.shape, np.int32))
    halves = Regions.from_labels(grid, np.repeat([[0, 1]], 30, axis=1).repeat(30, axis=0).astype(np.int32))
    gains = Gains(np.ones((grid.n_cells, 40)), np.zeros(grid.n_cells))  # each look pays one
    rates = {}
    for looks in ("passes", "actions"):
        for name, regions in (("whole", whole), ("halves", halves)):
            moves = region_problem(grid, regions, Sweep(looks=looks), gains, [(15, 30)], 1e5).searcher.moves
            searches = np.arange(moves.graph.n_regions)
            credited = sum(len(moves.graph.footprints.of(search)) for search in searches)
            rates[looks, name] = credited / moves.graph.seconds[searches].sum()
    assert rates["passes", "halves"] == pytest.approx(rates["passes", "whole"], rel=0.05)
    assert rates["actions", "halves"] > 1.02 * rates["actions", "whole"]


def test_looks_come_in_the_order_of_time_and_within_the_plan():
    problem, _ = posed(end=(20, 36))
    plan = a_walk(problem, 6)
    looks = problem.searcher.moves.looks(problem.grid, problem.searcher, plan.actions[0])
    assert (np.diff(looks.times) >= 0).all()
    assert looks.times[0] >= 0
    assert looks.times[-1] <= problem.searcher.moves.seconds(plan.actions[0]) <= problem.searcher.budget


def test_the_path_of_a_plan_begins_at_the_start_ends_at_the_end_and_does_not_jump():
    problem, _ = posed(start=(2, 3), end=(20, 36))
    path = problem.searcher.moves.path(a_walk(problem, 6).actions[0])
    centres = problem.grid.centres_m
    assert np.allclose(path[0], centres[problem.grid.index((2, 3))])
    assert np.allclose(path[-1], centres[problem.grid.index((20, 36))])
    lengths = np.hypot(*np.diff(path, axis=0).T)
    assert lengths.max() < 60


def test_the_other_way_round_an_edge_looks_at_the_same_atoms_in_the_opposite_order():
    problem, _ = posed()
    moves = problem.searcher.moves
    edge = moves.graph.n_regions
    ahead, behind = moves.atoms.seconds, moves.atoms.back_s
    entries = slice(moves.atoms.starts[edge], moves.atoms.starts[edge + 1])
    duration = moves.graph.seconds[edge]
    assert (ahead[entries] <= duration + 1e-4).all()
    assert (behind[entries] <= duration + 1e-4).all()
    assert np.corrcoef(ahead[entries], behind[entries])[0, 1] < 0 or len(ahead[entries]) < 2


@pytest.mark.parametrize(
    ("actions", "reason"),
    [
        ([], "it has no actions"),
        ([10_000], "unknown"),
        ([1], "action 0 is search of region 1, which cannot begin in region"),
    ],
)
def test_illegal_plans_are_refused_with_the_action(actions, reason):
    problem = region_world(0)
    assert problem.searcher.moves.first != 1
    with pytest.raises(IllegalPlanError, match=reason):
        evaluate(problem, Plan.of(np.array(actions, np.int64)))


def test_a_plan_that_takes_too_long_is_refused_with_its_seconds():
    problem = region_world(0, budget=10.0)
    first = problem.searcher.moves.first
    with pytest.raises(IllegalPlanError, match=r"it takes .* s; the budget is 10 s"):
        evaluate(problem, Plan.of([first] * 9))


def test_a_budget_too_short_for_any_search_is_refused_with_what_it_takes():
    with pytest.raises(InfeasibleProblemError, match="the quickest action"):
        posed(budget=3.0)


def test_an_end_that_cannot_be_reached_in_time_is_refused_with_the_seconds_of_the_way():
    with pytest.raises(InfeasibleProblemError, match="the way from start to end alone takes"):
        posed(start=(2, 3), end=(20, 36), budget=15.0)


def test_a_start_in_ground_that_no_region_can_be_reached_from_is_refused():
    rock = np.zeros((24, 40), bool)
    rock[:, 5] = True
    grid = Grid(rock.shape, "square8", 2.2, rock)
    regions = boustrophedon(grid, min_cells=150, min_columns=6, at_width=40)
    with pytest.raises(InvalidProblemError, match="no region can be reached"):
        region_problem(grid, regions, PRESET_A, cell_gains(grid, np.random.default_rng(0)), [(3, 2)], 900.0)


def test_starting_away_from_the_centre_costs_a_leg_that_is_looked_along():
    grid = ground()
    centre, _ = posed()
    regions = boustrophedon(grid, min_cells=20, min_columns=2, at_width=40)
    there = grid.cell(int(regions.centres[centre.searcher.moves.first]))
    at_centre, off = posed(start=there)[0].searcher.moves, posed(start=(2, 3))[0].searcher.moves
    assert at_centre.legs == ()
    assert at_centre.leg_s == 0.0
    assert off.leg_s > 0
    assert len(off.atoms.of(off.depart)) > 0


def test_two_searches_of_everything_are_the_papers_time():
    problem, _ = posed()
    moves = problem.searcher.moves
    assert two_searches_s(problem) == pytest.approx(2 * sum(moves.graph.seconds[: moves.graph.n_regions]))


def test_a_finer_map_of_the_same_ground_has_hardly_more_atoms():
    def atoms(factor: int) -> int:
        rock = np.kron(ground().obstacles, np.ones((factor, factor), bool))
        grid = Grid(rock.shape, "square8", 2.2 / factor, rock)
        regions = boustrophedon(grid, min_cells=20, min_columns=2, at_width=40)
        gains = Gains(np.ones((grid.n_cells, 1)), np.zeros(grid.n_cells))
        start = grid.cell(int(regions.centres[0]))
        sweep = Sweep(Dynamics(2.0, 2.0), taut=False)
        return region_problem(grid, regions, sweep, gains, [start], 900.0).gains.n_cells

    assert atoms(3) < 2 * atoms(1)


@pytest.mark.parametrize(("field", "value"), [("radius_m", 0.0), ("spacing_m", float("nan"))])
def test_a_sweep_that_makes_no_sense_is_refused(field, value):
    with pytest.raises(InvalidProblemError, match=field):
        Sweep(**{field: value})
