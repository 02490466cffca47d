"""Problems for hill climbers, larger than those that can be enumerated, and what every plan must keep."""

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from sooner.errors import InfeasibleProblemError
from sooner.grid import Grid
from sooner.planners import solve
from sooner.problem import CellMoves, Gains, Reach, Searcher, SearchProblem, evaluate


@st.composite
def hilly_problems(draw) -> SearchProblem:
    """Maps of up to 11 x 11 cells with hills, plateaus, empty ground and walls; any way to fly."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = draw(st.integers(1, 11)), draw(st.integers(1, 11))
    obstacles = rng.random(shape) < 0.2 if draw(st.booleans()) else None
    grid = Grid(shape, draw(st.sampled_from(["square4", "square8", "hex"])), obstacles=obstacles)
    cells = np.flatnonzero(grid.passable)
    assume(cells.size)
    start, end = (grid.cell(int(c)) for c in rng.choice(cells, 2))
    kind = draw(st.sampled_from(["copter", "fixed_wing"]))
    near = [grid.cell(int(c)) for c in grid.neighbours[grid.index(start)] if c >= 0]
    came_from = near[0] if kind == "fixed_wing" and near and draw(st.booleans()) else None
    looks = draw(st.sampled_from([1, 3]))
    table = np.sort(rng.integers(0, draw(st.sampled_from([2, 5, 1000])), (grid.n_cells, looks)) / 1000.0)[:, ::-1]
    gains = Gains(table / max(table.sum(), 1.0), rng.choice([0.0, 0.5, 1 / 3], grid.n_cells))
    budget = draw(st.integers(1, 60))
    try:
        searcher = Searcher(start, budget, end if draw(st.booleans()) else None, CellMoves(kind), came_from)
        problem = SearchProblem(grid, gains, (searcher,))
        Reach(grid, searcher).check()
    except InfeasibleProblemError:
        assume(False)
    return problem


def check_contract(planner, problem, seed=3):
    """Legal plans of all T steps, worth what they say, never worse, the same for the same seed; returns the last."""
    before = problem.gains.table.copy()
    incumbents = list(planner.plans(problem, np.random.default_rng(seed)))
    assert incumbents
    for incumbent in incumbents:
        assert incumbent.value == evaluate(problem, incumbent.plan).value
        assert len(incumbent.plan.actions[0]) == problem.searcher.budget + 1
    values = [incumbent.value for incumbent in incumbents]
    assert values == sorted(values)
    again = solve(problem, planner, seed=seed)
    assert again.best.plan == incumbents[-1].plan
    assert np.array_equal(problem.gains.table, before)
    return incumbents[-1]


def two_hills(shape=(21, 31), at=((10, 5), (10, 25)), connectivity="square4", spread=6.0, obstacles=None) -> tuple:
    """(grid, gains): Gaussian hills, every look certain."""
    rows, cols = np.indices(shape)
    height = sum(np.exp(-((rows - r) ** 2 + (cols - c) ** 2) / spread) for r, c in at)
    height = np.where(height > 1e-6, height, 0.0)
    return Grid(shape, connectivity, obstacles=obstacles), Gains.independent(
        height / height.sum(), np.ones(height.shape)
    )
