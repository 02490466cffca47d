"""Hypothesis strategies: grids, gains, searchers, problems small enough to enumerate."""

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from sooner.errors import InfeasibleProblemError
from sooner.grid import Grid
from sooner.problem import CellMoves, Gains, Objective, Reach, Searcher, SearchProblem


@st.composite
def grids(draw, most_cells: int = 9) -> Grid:
    rows = draw(st.integers(1, 3))
    cols = draw(st.integers(1, max(1, most_cells // rows)))
    connectivity = draw(st.sampled_from(["square4", "square8", "hex"]))
    obstacles = None
    if draw(st.booleans()):
        bits = draw(st.lists(st.booleans(), min_size=rows * cols, max_size=rows * cols))
        obstacles = np.array(bits).reshape(rows, cols) & (np.arange(rows * cols).reshape(rows, cols) % 2 == 1)
    return Grid((rows, cols), connectivity, obstacles=obstacles)


@st.composite
def gain_tables(draw, n_cells: int) -> Gains:
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    looks = draw(st.integers(1, 4))
    kind = draw(st.sampled_from(["independent", "table", "flat", "sparse"]))
    if kind == "flat":
        return Gains(np.full((n_cells, looks), 1.0 / n_cells / looks), np.zeros(n_cells))
    if kind == "independent":
        weights = rng.random(n_cells) ** 3
        return Gains.independent(weights / weights.sum(), rng.choice([0.0, 1 / 3, 2 / 3, 1.0], n_cells))
    table = np.sort(rng.random((n_cells, looks)), axis=1)[:, ::-1] / (n_cells * looks)
    if kind == "sparse":
        table *= rng.random((n_cells, 1)) < 0.4
    return Gains(table, rng.choice([0.0, 0.25, 0.5], n_cells) if draw(st.booleans()) else np.zeros(n_cells))


@st.composite
def problems(draw, most_steps: int = 6, target: bool = False) -> SearchProblem:
    """Any small problem over cells for which at least one legal flight of T steps exists."""
    grid = draw(grids())
    cells = [grid.cell(int(i)) for i in np.flatnonzero(grid.passable)]
    assume(cells)
    start = draw(st.sampled_from(cells))
    end = draw(st.sampled_from(cells)) if draw(st.booleans()) else None
    kind = draw(st.sampled_from(["copter", "fixed_wing"]))
    near = [grid.cell(int(c)) for c in grid.neighbours[grid.index(start)] if c >= 0]
    came_from = draw(st.sampled_from(near)) if kind == "fixed_wing" and near and draw(st.booleans()) else None
    budget = draw(st.integers(1, most_steps))
    searcher = Searcher(start, budget, end, CellMoves(kind), came_from)  # type: ignore[arg-type]
    objective = Objective(target=draw(st.sampled_from([0.05, 0.2, 0.5]))) if target else Objective()
    try:
        problem = SearchProblem(grid, draw(gain_tables(grid.n_cells)), (searcher,), objective)
        Reach(grid, searcher).check()
    except InfeasibleProblemError:
        assume(False)
    return problem
