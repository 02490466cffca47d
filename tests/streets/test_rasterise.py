from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.grid import Grid, rows_and_cols
from sooner.streets.rasterise import rasterised

GRID = Grid((10, 12), "square8", 5.0)


def way(*points):
    """In cells east and north of the south-west cell's centre."""
    return np.array(points, float) * GRID.cell_m


def cells_of(graph):
    """{(column, row from the south)} of the nodes."""
    rows, cols = np.divmod(graph.cells, GRID.shape[1])
    return set(zip(cols.tolist(), (GRID.shape[0] - 1 - rows).tolist(), strict=True))


def test_a_straight_street_is_a_chain_of_nodes_at_the_middle_of_what_it_runs_in_each_cell():
    graph = rasterised([way((2, 3), (8, 3))], GRID)
    assert cells_of(graph) == {(col, 3) for col in range(2, 9)}
    assert graph.edges.tolist() == [[k, k + 1] for k in range(6)]
    assert np.allclose(graph.positions_m[:, 1], 15.0)
    assert np.allclose(graph.positions_m[1:-1, 0], 5.0 * np.arange(3, 8))
    assert np.isclose(graph.positions_m[0, 0], 11.25)  # from the centre of cell 2 to its eastern edge


def test_an_exact_diagonal_joins_cells_corner_to_corner():
    graph = rasterised([way((1, 1), (8, 8))], GRID)
    assert cells_of(graph) == {(k, k) for k in range(1, 9)}
    assert graph.n_edges == 7


def test_a_clipped_cell_is_passed_over_where_its_neighbours_touch():
    """Just below the diagonal, the cell to the south-east of each corner is clipped for 0.14 of a cell."""
    graph = rasterised([way((1.1, 1), (8.1, 8))], GRID)
    assert cells_of(graph) == {(k, k) for k in range(1, 9)}
    whole = rasterised([way((1.1, 1), (8.1, 8))], GRID, clip=0.0)
    assert cells_of(whole) == cells_of(graph) | {(k + 1, k) for k in range(1, 8)}
    assert whole.n_edges == 14


def test_a_street_off_the_grid_is_cut_and_its_parts_are_not_joined():
    graph = rasterised([way((-3, 2), (5, 2), (5, -9), (9, -9), (9, 6))], GRID, least_nodes=1)
    assert cells_of(graph) == {(col, 2) for col in range(6)} | {(5, 0), (5, 1)} | {(9, row) for row in range(7)}
    assert np.unique(graph.components).size == 2


def test_a_long_way_off_is_no_more_work():
    graph = rasterised([way((-1e9, 2), (1e9, 2))], GRID)
    assert cells_of(graph) == {(col, 2) for col in range(12)}


def test_streets_that_cross_share_the_node_of_their_cell():
    graph = rasterised([way((1, 4), (9, 4)), way((5, 1), (5, 8))], GRID)
    assert np.unique(graph.components).tolist() == [0]
    assert graph.degrees.max() == 4
    assert graph.n_nodes == 9 + 8 - 1


def test_a_ring_is_closed():
    graph = rasterised([way((2, 2), (6, 2), (6, 6), (2, 6), (2, 2))], GRID)
    assert graph.n_nodes == graph.n_edges == 16
    assert (graph.degrees == 2).all()


def test_parts_of_few_nodes_are_dropped():
    ways = [way((1, 1), (8, 1)), way((1, 8), (4, 8))]
    assert np.unique(rasterised(ways, GRID, least_nodes=4).components).size == 2
    assert np.unique(rasterised(ways, GRID, least_nodes=5).components).size == 1


@pytest.mark.parametrize("ways", [[], [way((20, 20), (30, 20))], [way((2, 2), (4, 2))], [way((2, 2), (2, 2))]])
def test_no_street_is_refused(ways):
    with pytest.raises(InvalidProblemError, match="no street"):
        rasterised(ways, GRID)


@pytest.mark.parametrize("bad", [np.zeros((3, 3)), np.array([[0.0, np.nan], [1.0, 1.0]]), np.zeros(4)])
def test_a_way_that_is_none_is_refused(bad):
    with pytest.raises(InvalidProblemError, match="expected \\(k, 2\\) finite metres"):
        rasterised([bad], GRID)


@given(st.integers(0, 2**32 - 1))
def test_every_sample_of_a_way_lies_in_a_cell_with_a_node_or_one_it_clips(seed):
    """Against a walk in steps of a hundredth of a cell."""
    rng = np.random.default_rng(seed)
    points = way(*(rng.random((4, 2)) * [13, 11] - 0.9))
    try:
        graph = rasterised([points], GRID, clip=0.0, least_nodes=1)
    except InvalidProblemError:
        return
    share = np.linspace(0, 1, 3000)[:, None]
    walked = np.concatenate([a + (b - a) * share for a, b in pairwise(points)])
    at = np.rint(rows_and_cols(GRID, walked)).astype(int)
    clear = (abs(rows_and_cols(GRID, walked) - at) < 0.499).all(axis=1)  # not on a line between cells
    inside = (at >= 0).all(axis=1) & (at < GRID.shape).all(axis=1) & clear
    seen = np.unique(at[inside] @ [GRID.shape[1], 1])
    assert np.isin(seen, graph.cells).all()
    assert len(graph.cells) - len(seen) <= 2  # clipped between two samples
