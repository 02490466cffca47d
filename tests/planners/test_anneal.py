"""The annealer against enumeration, against the judge, and against itself; its kernels against plain Python."""

import numpy as np
import pytest
from hypothesis import given, settings

from sooner.grid import Grid
from sooner.planners import _anneal_kernels as kernels
from sooner.planners import max_ticks, never, solve
from sooner.planners._random_kernels import draw
from sooner.planners.anneal import Anneal, _coarse_walk, _Ground, _Walk
from sooner.planners.planner import follow
from sooner.planners.rounds import Rounds
from sooner.problem import CellMoves, Gains, Reach, Searcher, SearchProblem, evaluate
from tests.oracles.walks import optimum, total, walks
from tests.strategies import problems

CONNECTIVITIES = ["square4", "square8", "hex"]
COPTER, WING = CellMoves("copter"), CellMoves("fixed_wing")


def hills(shape: tuple[int, int], seed: int, looks: int = 1) -> Gains:
    """Smooth random hills, glimpses of 1/3, 2/3 and 1."""
    rng = np.random.default_rng(seed)
    rows, cols = np.indices(shape)
    weights = sum(
        np.exp(-((rows - rng.uniform(0, shape[0])) ** 2 + (cols - rng.uniform(0, shape[1])) ** 2) / 18.0)
        for _ in range(6)
    )
    glimpse = rng.choice([1 / 3, 2 / 3, 1.0], shape[0] * shape[1])
    gains = Gains.independent(weights / weights.sum(), glimpse)
    cells = np.arange(gains.n_cells)
    return Gains(gains.of(cells[:, None], np.arange(looks)), gains.ratio)


def boulders(shape: tuple[int, int], seed: int) -> np.ndarray:
    """A fifth of the cells cannot be entered; the corner [0, 0] and all around it can."""
    blocked = np.random.default_rng(seed).random(shape) < 0.2
    blocked[:3, :3] = False
    return blocked


def search(
    shape: tuple[int, int],
    steps: int,
    connectivity: str = "square4",
    moves: CellMoves = COPTER,
    end: tuple[int, int] | None = None,
    obstacles: np.ndarray | None = None,
    seed: int = 0,
    looks: int = 1,
) -> SearchProblem:
    grid = Grid(shape, connectivity, obstacles=obstacles)  # type: ignore[arg-type]
    return SearchProblem(grid, hills(shape, seed, looks), (Searcher((0, 0), steps, end, moves),))


# -- against enumeration


@settings(max_examples=40)
@given(problem=problems())
def test_it_finds_the_optimum_of_every_problem_small_enough_to_enumerate(problem: SearchProblem) -> None:
    found = solve(problem, Anneal(starts=4, threads=1), max_ticks(40)).best
    assert found.value == pytest.approx(optimum(problem), abs=1e-12)


@pytest.mark.parametrize("connectivity", CONNECTIVITIES)
@pytest.mark.parametrize("moves", [COPTER, WING], ids=lambda moves: moves.kind)
@pytest.mark.parametrize("end", [None, (0, 0), (1, 3)])
def test_it_finds_the_optimum_on_a_hill_of_twelve_cells(
    connectivity: str, moves: CellMoves, end: tuple[int, int] | None
) -> None:
    problem = search((3, 4), 8 if connectivity == "square4" else 6, connectivity, moves, end, looks=2, seed=5)
    assert solve(problem, Anneal(starts=4, threads=1), max_ticks(40)).best.value == pytest.approx(
        optimum(problem), abs=1e-12
    )


def test_a_fixed_wing_in_a_dead_end_flies_the_only_way_there_is() -> None:
    blocked = np.ones((5, 5), bool)
    blocked[2, :] = blocked[:3, 4] = False  # a corridor that bends once: seven steps and no more
    grid = Grid((5, 5), obstacles=blocked)
    problem = SearchProblem(grid, hills((5, 5), 1), (Searcher((2, 0), 6, None, WING),))
    (only,) = walks(problem)
    assert list(solve(problem, Anneal(), max_ticks(3)).best.plan.actions[0]) == only


def test_a_map_of_one_cell_is_hovered_over() -> None:
    problem = SearchProblem(Grid((1, 1)), Gains.independent([1.0], [0.5]), (Searcher((0, 0), 3),))
    assert solve(problem, Anneal(), max_ticks(3)).best.value == pytest.approx(1 - 0.5**4)


def test_where_nothing_can_be_found_it_ends_with_a_legal_plan() -> None:
    problem = SearchProblem(Grid((3, 3)), Gains(np.zeros((9, 1)), np.zeros(9)), (Searcher((0, 0), 4),))
    best = solve(problem, Anneal(), never()).best
    assert best.value == 0.0
    assert len(best.plan.actions[0]) == 5


# -- against the judge


@pytest.mark.parametrize("connectivity", CONNECTIVITIES)
@pytest.mark.parametrize("moves", [COPTER, WING], ids=lambda moves: moves.kind)
@pytest.mark.parametrize("end", [None, (2, 2), (13, 14)])
@pytest.mark.parametrize("stones", [False, True], ids=["open", "boulders"])
def test_every_plan_is_legal_worth_what_it_says_and_no_worse_than_the_last(
    connectivity: str, moves: CellMoves, end: tuple[int, int] | None, stones: bool
) -> None:
    blocked = boulders((16, 17), 3) if stones else None
    if blocked is not None:
        blocked[11:15, 11:16] = False
        blocked[:, 8] = False
        blocked[1, :] = blocked[12, :] = False
    steps = 60 if end == (2, 2) or end is None else 61
    problem = search((16, 17), steps, connectivity, moves, end, blocked, seed=2)
    planner = Anneal(starts=6, moves=1000)
    advance = follow(planner.plans(problem, np.random.default_rng(0)))
    best = -np.inf
    for tick in range(8):
        incumbent = advance(tick / 8)
        assert incumbent is not None
        assert incumbent.value == evaluate(problem, incumbent.plan).value  # which refuses what is not legal
        assert incumbent.value == pytest.approx(total(problem, list(incumbent.plan.actions[0])), abs=1e-12)
        assert incumbent.value >= best
        assert len(incumbent.plan.actions[0]) == steps + 1
        best = incumbent.value


def test_a_fixed_wing_keeps_the_heading_it_came_with() -> None:
    grid = Grid((3, 6))
    searcher = Searcher((1, 1), 5, None, WING, came_from=(1, 2))
    gains = Gains.independent(np.arange(18) / 153, np.full(18, 0.5))
    best = solve(SearchProblem(grid, gains, (searcher,)), Anneal(starts=4), max_ticks(10)).best
    assert best.plan.actions[0][1] != grid.index((1, 2))


def test_the_same_seed_and_ticks_give_the_same_plan_and_another_seed_another() -> None:
    problem = search((20, 20), 80)
    planner = Anneal(starts=8, moves=1000)
    one, two, other = (solve(problem, planner, max_ticks(8), seed=seed).best for seed in (4, 4, 5))
    assert one == two
    assert one.plan != other.plan


def test_it_goes_on_in_longer_rounds_where_nobody_knows_how_long() -> None:
    problem = search((4, 4), 6)
    advance = follow(Anneal(starts=3, threads=1, moves=50).plans(problem, np.random.default_rng(0)))
    values = [incumbent.value for incumbent in (advance(None) for _ in range(400)) if incumbent is not None]
    assert len(values) == 400
    assert values == sorted(values)


def test_plans_of_other_planners_are_starts_that_it_never_falls_below() -> None:
    problem = search((20, 20), 80)
    given_plan = solve(problem, Anneal(starts=8, moves=1000), max_ticks(8)).best

    class Given:
        def handles(self, problem):
            return None

        def plans(self, problem, rng):
            yield given_plan

    first = next(iter(Anneal(seeds=(Given(),)).plans(problem, np.random.default_rng(1))))
    assert first.value >= given_plan.value


# -- the kernels against plain Python


@pytest.mark.parametrize("connectivity", CONNECTIVITIES)
@pytest.mark.parametrize("moves", [COPTER, WING], ids=lambda moves: moves.kind)
@pytest.mark.parametrize("temperature", [0.01, 1.0, 100.0])
def test_the_list_stays_a_walk_and_its_books_stay_true(connectivity: str, moves: CellMoves, temperature: float) -> None:
    problem = search((9, 9), 30, connectivity, moves, looks=2, seed=1)
    ground = _Ground(problem)
    rng = np.random.default_rng(0)
    walk = _Walk(ground, _coarse_walk(ground, rng), rng)
    for _ in range(10):
        walk.anneal(Anneal(), temperature, 300, 0.5)
        cells = _listed(walk)
        assert len(cells) <= ground.limit
        assert problem.searcher.moves.fault(problem.grid, problem.searcher, np.array(cells)) is None
        np.testing.assert_array_equal(walk.looks[:, 0], np.bincount(cells, minlength=81))
        pays = problem.gains.of(np.arange(81), walk.looks[:, 0])
        np.testing.assert_allclose(walk.pays * ground.unit, pays, atol=1e-15)
        assert walk.value * ground.unit == pytest.approx(total(problem, cells), abs=1e-12)


def _listed(walk: _Walk) -> list[int]:
    cells, node, before = [], 0, -1
    while node >= 0:
        cells.append(int(walk.nodes[node, kernels.CELL]))
        assert walk.nodes[node, kernels.BEFORE] == before
        node, before = walk.nodes[node, kernels.NEXT], node
    assert len(cells) == walk.state[kernels.SIZE]
    assert before == walk.state[kernels.TAIL]
    return cells


@pytest.mark.parametrize("connectivity", CONNECTIVITIES)
def test_distances_without_obstacles_are_those_of_the_graph(connectivity: str) -> None:
    ground = _Ground(search((7, 6), 10, connectivity))
    slots = ground.neighbours.shape[1]
    for i in range(42):
        apart = [kernels._apart(ground.where, slots, i, j) for j in range(42)]
        np.testing.assert_array_equal(apart, ground.problem.grid.distances_from(i))


def test_coarse_walks_are_legal_starts() -> None:
    for seed in range(10):
        problem = search((15, 15), 40, "square4", COPTER, (3, 3), boulders((15, 15), 7), seed=seed)
        ground = _Ground(problem)
        walk = _coarse_walk(ground, np.random.default_rng(seed))
        assert problem.searcher.moves.fault(problem.grid, problem.searcher, walk.astype(np.int64)) is None


def test_random_words_are_those_of_plain_integers() -> None:
    words = np.array([12345, 678], np.int64)
    x, w = 12345, 678
    for _ in range(100):
        x ^= (x << 13) & 0xFFFFFFFF
        x ^= x >> 17
        x ^= (x << 5) & 0xFFFFFFFF
        w = (w + 362437) & 0xFFFFFFFF
        assert draw(words) == (x + w) & 0xFFFFFFFF


def test_reach_finds_the_dead_ends_that_keep_a_walk_at_full_length() -> None:
    open_map = search((4, 4), 6, moves=WING)
    corridor = SearchProblem(Grid((1, 5)), hills((1, 5), 0), (Searcher((0, 0), 4, None, WING),))
    assert not _Ground(open_map).strict
    assert _Ground(corridor).strict
    assert Reach(corridor.grid, corridor.searcher).can_go_on(0, -1, 4)


def test_a_long_run_on_a_short_flight_is_cut_into_rounds():
    """One slow cooling may freeze in the wrong place; so a run is as many rounds as fit, all of the same length."""
    rounds, begun = Rounds(longest=400), 0
    share, lengths = 0.0, []
    while share < 1.0:
        rounds, begun = rounds.begun(share), begun + 1
        start = share
        while share < 1.0 and rounds.now(share) < 1.0:
            rounds.tick += 1
            share += 1 / 2000
        lengths.append(share - start)
    assert begun == 5
    assert lengths == pytest.approx([0.2] * 5, abs=0.01)


def test_where_nobody_knows_how_long_it_lasts_each_round_is_twice_as_long():
    rounds, ticks = Rounds(longest=400), []
    for _ in range(3):
        rounds = rounds.begun(None)
        while rounds.now(None) < 1.0:
            rounds.tick += 1
        ticks.append(rounds.tick)
    assert ticks == [64, 128, 256]
