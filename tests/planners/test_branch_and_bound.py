"""Branch and bound over regions, against enumeration."""

from dataclasses import replace
from itertools import islice, pairwise
from math import inf, isnan

import numpy as np
import pytest

from sooner.errors import InfeasibleProblemError, InvalidProblemError
from sooner.grid import Grid
from sooner.planners import max_ticks, solve
from sooner.planners.branch_and_bound import BranchAndBound, DepthFirstBranchAndBound
from sooner.planners.depth_first import relaxation
from sooner.problem import Plan, Searcher, SearchProblem, evaluate
from sooner.problem.atoms import Footprints, atom_gains, atoms_of
from sooner.problem.region_ground import RegionGround
from sooner.problem.regions import RegionGraph, RegionMoves
from tests.planners.region_worlds import COLUMNS, best_by_enumeration, cell_gains, region_world

PLANNERS = [BranchAndBound(), DepthFirstBranchAndBound(), BranchAndBound(apart=True, early=True)]


def disjoint_world(seed: int = 0, **how) -> SearchProblem:
    """As `region_world`, but no two actions look at one cell."""
    problem = region_world(seed, **how)
    rng = np.random.default_rng(seed)
    moves = problem.searcher.moves
    count = len(moves.graph.seconds)
    cells = rng.permutation(problem.grid.n_cells).astype(np.int32)
    between = np.sort(rng.choice(np.arange(1, len(cells)), count - 1, replace=False))
    starts = np.concatenate([[0], between, [len(cells)]])
    footprints = Footprints(starts, cells, *np.zeros((2, len(cells)), np.float32))
    graph = replace(moves.graph, footprints=footprints)
    atoms, gains = atoms_of(footprints, problem.grid.n_cells), cell_gains(problem.grid, rng)
    searcher = replace(problem.searcher, moves=replace(moves, graph=graph, atoms=atoms))
    rows = atom_gains(atoms, lambda asked: gains.of(asked[:, None], np.arange(COLUMNS)))
    return SearchProblem(problem.grid, rows, (searcher,))


def last_record(problem, planner, seed=0):
    return list(planner.searched(problem, np.random.default_rng(seed)))[-1]


def check_region_contract(problem: SearchProblem, planner, ticks: int = 6) -> None:
    """Moves legal, time kept, value equals evaluate, never above the optimum, never falling, same seed same plan,
    safe to close early, problem untouched."""
    assert planner.handles(problem) is None
    before = problem.gains.table.copy(), problem.searcher.moves.graph.seconds.copy()
    most, best = best_by_enumeration(problem), -inf
    generator = planner.plans(problem, np.random.default_rng(3))
    for incumbent in islice(generator, ticks):
        assert incumbent.value == evaluate(problem, incumbent.plan).value
        assert best <= incumbent.value <= most + 1e-12
        assert incumbent.bound == inf, "g is no bound"
        best = incumbent.value
    assert best > -inf, "at least one plan"
    generator.close()
    first, again = (solve(problem, planner, max_ticks(3), seed=5).best.plan for _ in range(2))
    assert first == again, "same seed, same plan"
    for old, new in zip(before, (problem.gains.table, problem.searcher.moves.graph.seconds), strict=True):
        assert np.array_equal(old, new), "problem untouched"


@pytest.mark.parametrize("planner", PLANNERS, ids=repr)
@pytest.mark.parametrize("how", [{}, {"legs": True}, {"ends": True}, {"legs": True, "ends": True}], ids=repr)
def test_the_contract_is_kept(planner, how):
    for seed in range(3):
        check_region_contract(region_world(seed, n_regions=3, budget=20.0, **how), planner)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("ends", [False, True])
def test_without_overlaps_patience_finds_the_optimum(seed, ends):
    problem = disjoint_world(seed, n_regions=4, budget=20.0, legs=seed % 2 == 1, ends=ends)
    most = best_by_enumeration(problem)
    for planner in (
        BranchAndBound(alpha=1.0, eta=0.0, iterations=inf),
        BranchAndBound(alpha=0.3, eta=0.0, iterations=inf, early=True),
        BranchAndBound(alpha=1.0, eta=0.0, iterations=inf, apart=True),
        DepthFirstBranchAndBound(iterations=inf),
    ):
        found = last_record(problem, planner)
        assert found.finished
        assert found.success
        assert found.value == pytest.approx(most, rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_with_overlaps_a_g_that_keeps_actions_apart_finds_the_optimum(seed):
    problem = region_world(seed, n_regions=4, budget=18.0, ends=seed % 2 == 1)
    most = best_by_enumeration(problem)
    for planner in (
        BranchAndBound(alpha=0.8, eta=0.0, iterations=inf, apart=True),
        DepthFirstBranchAndBound(iterations=inf, apart=True),
    ):
        assert last_record(problem, planner).value == pytest.approx(most, rel=1e-12)


@pytest.mark.parametrize("eta", [0.02, 0.1, 0.5])
def test_impatience_costs_no_more_than_it_promises(eta):
    for seed in range(4):
        problem = disjoint_world(seed, n_regions=4, budget=18.0)
        found = last_record(problem, BranchAndBound(alpha=0.5, eta=eta, iterations=inf))
        assert found.value * (1 + eta) >= best_by_enumeration(problem) * (1 - 1e-12)


def test_where_footprints_overlap_picking_by_rate_is_no_bound():
    """Why g never becomes an incumbent's bound: searching here pays best, and takes from both of two better ones."""
    cells = np.array([0, 1, 1, 3, 0, 2], np.int32)
    footprints = Footprints(np.array([0, 2, 4, 6]), cells, *np.zeros((2, 6), np.float32))
    paths = (np.zeros((2, 2)),) * 3
    labels = np.array([[0, 1, 0, 1]], np.int32)
    graph = RegionGraph(2, np.array([[0, 1]]), np.ones(3), paths, footprints, labels)
    atoms, paid = atoms_of(footprints, 4), np.array([1.0, 1.0, 0.9, 0.9])
    searcher = Searcher((0, 0), 2.0, moves=RegionMoves(graph, atoms, first=0))
    problem = SearchProblem(Grid((1, 4)), atom_gains(atoms, lambda cells: paid[cells][:, None]), (searcher,))
    assert best_by_enumeration(problem) == pytest.approx(3.8)
    assert relaxation(RegionGround.of(problem))[0] == pytest.approx(2.9)
    assert last_record(problem, BranchAndBound(eta=0.0, apart=True)).value == pytest.approx(3.8)


def test_g_of_the_start_is_the_relaxation_and_apart_never_less():
    from sooner.planners._branch_kernels import _rates, most
    from sooner.planners.branch_and_bound import arrays

    for problem in (region_world(1, n_regions=6, budget=60.0, legs=True), disjoint_world(2, n_regions=6, budget=60.0)):
        ground = RegionGround.of(problem)
        found = []
        for apart in (False, True):
            plain = arrays(ground)
            places, rates = plain[14].copy(), np.empty(ground.n_actions)
            _rates(plain, places, rates)
            picks = np.empty(ground.n_actions, np.int64)
            found.append(most(plain, places, rates, ground.leg_value, ground.limit_s, -inf, apart, picks))
        assert found[0] == pytest.approx(relaxation(ground)[0], rel=1e-12)
        assert found[1] >= found[0] * (1 - 1e-12)


@pytest.mark.parametrize("planner", PLANNERS, ids=repr)
def test_records_tell_of_the_first_solution_and_never_of_a_worse_one(planner):
    problem = region_world(3, n_regions=6, budget=60.0, extra=4)
    records = list(planner.searched(problem, np.random.default_rng(0)))
    solved = [record for record in records if record.success]
    assert solved
    assert solved[0].first_value <= solved[-1].value
    assert len({(record.first_s, record.first_value) for record in solved}) == 1
    for before, after in pairwise(records):
        assert after.value >= before.value
        assert after.iterations > before.iterations
        assert after.solutions >= before.solutions
        assert after.first_s <= after.seconds or not after.success
    last = records[-1]
    assert last.iterations >= last.expanded
    assert last.generated >= last.evaluated >= last.stored - 1
    assert last.iterations == 6000 or last.finished
    assert evaluate(problem, Plan.of(list(solved[-1].walk))).value >= last.value - 1e-9


@pytest.mark.parametrize(
    "planner", [BranchAndBound(iterations=1000), DepthFirstBranchAndBound(iterations=1000)], ids=repr
)
def test_early_solutions_come_no_later_and_are_more(planner):
    found = {True: 0, False: 0}
    for seed in range(4):
        problem, first = region_world(seed, n_regions=6, budget=40.0, extra=4), {}
        for early in found:
            records = list(replace(planner, early=early).searched(problem, np.random.default_rng(0)))
            first[early] = next(record.iterations for record in records if record.success)
            found[early] += records[-1].solutions
        assert first[True] <= first[False]
    assert found[True] > found[False]


def test_before_the_first_solution_there_is_a_plan_but_no_success():
    problem = region_world(3, n_regions=8, budget=90.0, ends=True, legs=True)
    planner = BranchAndBound(iterations=5)
    (record,) = planner.searched(problem, np.random.default_rng(0))
    assert not record.success
    assert isnan(record.first_s)
    assert isnan(record.first_value)
    assert record.value == -inf
    (incumbent,) = planner.plans(problem, np.random.default_rng(0))
    assert incumbent.value == evaluate(problem, incumbent.plan).value > 0


def test_room_grows_with_the_search():
    problem = region_world(0, n_regions=12, budget=90.0, extra=6)
    found = last_record(problem, BranchAndBound(alpha=1.0, eta=0.0, iterations=1500))
    assert found.stored > 2000
    assert found.iterations == 1500


def test_same_actions_in_another_order_are_one_node():
    problem = region_world(0, n_regions=3, budget=20.0)
    found = last_record(problem, DepthFirstBranchAndBound(iterations=inf))
    assert found.evaluated < found.generated


def test_depth_first_walks_differ_by_seed():
    problem = region_world(0, n_regions=8, budget=60.0)
    walks = {last_record(problem, DepthFirstBranchAndBound(iterations=100), seed).walk for seed in range(4)}
    assert len(walks) > 1


def test_what_pays_nothing_is_planned_all_the_same():
    problem = region_world(0, n_regions=3, budget=15.0)
    nothing = replace(problem, gains=replace(problem.gains, table=np.zeros_like(problem.gains.table)))
    for planner in PLANNERS:
        assert solve(nothing, planner).best.value == 0.0


@pytest.mark.parametrize(
    "make",
    [
        lambda: BranchAndBound(alpha=1.5),
        lambda: BranchAndBound(eta=-0.1),
        lambda: BranchAndBound(iterations=1),
        lambda: DepthFirstBranchAndBound(iterations=0),
    ],
)
def test_settings_that_mean_nothing_are_refused(make):
    with pytest.raises(InvalidProblemError, match="came; expected"):
        make()


def test_no_action_that_leaves_time_to_get_home_is_an_error():
    problem = region_world(0, n_regions=2, budget=40.0)
    moves = problem.searcher.moves
    seconds = moves.graph.seconds.copy()
    seconds[:2], seconds[2:] = 50.0, 30.0  # the way there fits, but not the way back
    home = RegionMoves(replace(moves.graph, seconds=seconds), moves.atoms, moves.first, moves.first)
    with pytest.raises(InfeasibleProblemError, match="the quickest action, with the ways to and from it"):
        next(BranchAndBound().plans(replace(problem, searchers=(replace(problem.searcher, moves=home),)), None))
