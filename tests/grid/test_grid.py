import numpy as np
import pytest
from hypothesis import given

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.problem import Gains, Searcher, SearchProblem
from tests.oracles.walks import adjacent
from tests.strategies import grids


@given(grid=grids())
def test_neighbours_are_the_cells_one_step_away_in_metres(grid: Grid) -> None:
    gains = Gains(np.zeros((grid.n_cells, 1)), np.zeros(grid.n_cells))
    start = grid.cell(int(np.argmax(grid.passable)))
    expected = adjacent(SearchProblem(grid, gains, (Searcher(start, 1),)))
    for cell in range(grid.n_cells):
        found = sorted(int(other) for other in grid.neighbours[cell] if other >= 0)
        assert found == sorted(expected[cell])


@given(grid=grids())
def test_distances_obey_the_triangle_of_one_step(grid: Grid) -> None:
    source = int(np.argmax(grid.passable))
    steps = grid.distances_from(source)
    assert steps[source] == 0
    for cell in range(grid.n_cells):
        around = [steps[other] for other in grid.neighbours[cell] if other >= 0 and steps[other] >= 0]
        if steps[cell] > 0:
            assert steps[cell] == min(around) + 1
        if steps[cell] < 0:
            assert not around


def test_an_open_square_grid_measures_l1_and_an_eight_connected_one_chebyshev() -> None:
    rows, cols = np.divmod(np.arange(35), 7)
    down, right = abs(rows - 2), abs(cols - 3)
    assert np.array_equal(Grid((5, 7)).distances_from(17), down + right)
    assert np.array_equal(Grid((5, 7), "square8").distances_from(17), np.maximum(down, right))


def test_a_diagonal_does_not_cut_the_corner_of_an_obstacle() -> None:
    grid = Grid((2, 2), "square8", obstacles=np.array([[False, True], [False, False]]))
    assert 3 not in grid.neighbours[0]
    assert grid.distances_from(0)[3] == 2


@pytest.mark.parametrize("cell", [(-1, 0), (0, 3), (2, 0)])
def test_a_cell_off_the_map_is_refused(cell: tuple[int, int]) -> None:
    with pytest.raises(InvalidProblemError, match="the map has rows 0 to 1"):
        Grid((2, 3)).index(cell)


@pytest.mark.parametrize(
    "settings",
    [
        {"shape": (0, 3)},
        {"shape": (2**14, 2**14)},
        {"shape": (2, 2), "cell_m": 0.0},
        {"shape": (2, 2), "cell_m": float("nan")},
        {"shape": (2, 2), "connectivity": "triangles"},
        {"shape": (2, 2), "obstacles": np.zeros((3, 2), bool)},
    ],
)
def test_a_grid_that_makes_no_sense_is_refused(settings: dict) -> None:
    with pytest.raises(InvalidProblemError):
        Grid(**settings)
