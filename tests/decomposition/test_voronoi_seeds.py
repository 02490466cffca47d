"""Seeds spread one by one against ways from all of them at once."""

import numpy as np
import pytest

from sooner.decomposition._voronoi_kernels import approach
from sooner.grid import Grid
from sooner.grid.paths import geodesic


@pytest.mark.parametrize("seed", range(5))
def test_seeds_one_by_one_come_as_near_as_all_at_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = Grid((23, 31), obstacles=rng.random((23, 31)) < 0.3)
    seeds = rng.choice(np.flatnonzero(grid.passable), 9, replace=False)
    apart, steps = np.full(grid.n_cells, np.inf), np.full((3, grid.n_cells), -1, np.int32)
    waiting, touched = np.empty((3, grid.n_cells), np.int32), np.empty(grid.n_cells, np.int32)
    for one in seeds:
        approach(grid.passable, grid.shape[1], one, apart, *steps, waiting, touched)
    assert apart == pytest.approx(geodesic(grid, seeds)[1])
    assert (steps == -1).all()
