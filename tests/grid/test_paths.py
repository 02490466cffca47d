import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from sooner.errors import InfeasibleProblemError, InvalidProblemError, UnsupportedProblemError
from sooner.grid import (
    Grid,
    centres_of,
    distances_m,
    geodesic,
    line_is_clear,
    pruned,
    rows_and_cols,
    shortest_path,
    string_pulled,
    turns_rad,
    way,
)


@st.composite
def rocky(draw, most: int = 9) -> Grid:
    """A map of squares with obstacles; cell 0 is free."""
    shape = draw(st.integers(1, most)), draw(st.integers(1, most))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    obstacles = rng.random(shape) < draw(st.sampled_from([0.0, 0.1, 0.3]))
    obstacles[0, 0] = False
    return Grid(shape, "square8", draw(st.sampled_from([1.0, 2.2])), obstacles)


def by_scipy(grid: Grid) -> np.ndarray:
    """(N, N) lengths from a dense table of neighbours, by scipy."""
    cells, slots = np.nonzero(grid.neighbours >= 0)
    others = grid.neighbours[cells, slots]
    apart = np.hypot(*(grid.centres_m[cells] - grid.centres_m[others]).T)
    return dijkstra(csr_array((apart, (cells, others)), shape=(grid.n_cells, grid.n_cells)))


def touches(grid: Grid, a: np.ndarray, b: np.ndarray) -> bool:
    """Brute force: whether the segment meets the closed square of any obstacle, or leaves the map's rectangle."""
    half = grid.cell_m * (0.5 + 1e-9)
    low, high = grid.centres_m.min(axis=0) - half, grid.centres_m.max(axis=0) + half
    if (np.minimum(a, b) < low).any() or (np.maximum(a, b) > high).any():
        return True
    for centre in grid.centres_m[~grid.passable]:
        enter, leave = 0.0, 1.0
        for axis in (0, 1):
            step, near, far = b[axis] - a[axis], centre[axis] - half - a[axis], centre[axis] + half - a[axis]
            if step == 0:
                if near > 0 or far < 0:
                    enter, leave = 1.0, 0.0
            else:
                enter, leave = max(enter, min(near / step, far / step)), min(leave, max(near / step, far / step))
        if enter <= leave:
            return True
    return False


def length(points: np.ndarray) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


@settings(max_examples=40)
@given(grid=rocky())
def test_lengths_are_those_of_scipy_and_paths_have_them(grid: Grid) -> None:
    expected = by_scipy(grid)[0]
    found = distances_m(grid, 0)
    assert found == pytest.approx(np.where(grid.passable, expected, np.inf), rel=1e-12)
    for goal in np.flatnonzero(grid.passable):
        if np.isinf(expected[goal]):
            with pytest.raises(InfeasibleProblemError, match="no way leads"):
                shortest_path(grid, 0, int(goal))
            continue
        path = shortest_path(grid, 0, int(goal))
        assert path[0] == 0
        assert path[-1] == goal
        assert all(b in grid.neighbours[a] for a, b in itertools.pairwise(path))
        assert length(centres_of(grid, path)) == pytest.approx(expected[goal])


@settings(max_examples=30)
@given(grid=rocky(), seed=st.integers(0, 99))
def test_every_cell_belongs_to_its_nearest_source_and_the_first_of_equals(grid: Grid, seed: int) -> None:
    free = np.flatnonzero(grid.passable)
    sources = np.random.default_rng(seed).choice(free, min(3, len(free)), replace=False)
    owner, metres = geodesic(grid, sources)
    table = by_scipy(grid)[sources]
    assert metres[free] == pytest.approx(table.min(axis=0)[free])
    for cell in free:
        near = np.flatnonzero(table[:, cell] <= table[:, cell].min() + 1e-9)
        assert owner[cell] == (near[0] if np.isfinite(metres[cell]) else -1)
    assert (owner[~grid.passable] == -1).all()


def test_a_way_far_around_is_found_though_the_window_begins_small() -> None:
    obstacles = np.zeros((60, 60), bool)
    obstacles[:59, 30] = True
    grid = Grid((60, 60), "square8", obstacles=obstacles)
    path = shortest_path(grid, 29, 31)
    assert length(centres_of(grid, path)) == pytest.approx(distances_m(grid, 29)[31])
    assert 59 * 60 + 30 in path


def test_of_equal_ways_one_with_a_single_turn_is_taken() -> None:
    for goal in (39, 75, 14, 99):
        path = centres_of(Grid((10, 10)), shortest_path(Grid((10, 10)), 0, goal))
        assert len(pruned(path)) <= 3


@settings(max_examples=60)
@given(grid=rocky(5), data=st.data())
def test_a_line_is_clear_where_brute_force_says_so(grid: Grid, data) -> None:
    half_cells = st.tuples(st.integers(-1, 2 * grid.shape[1] - 1), st.integers(-1, 2 * grid.shape[0] - 1))
    anywhere = st.tuples(st.integers(-120, 200 * grid.shape[1]), st.integers(-120, 200 * grid.shape[0]))
    for _ in range(3):
        share = data.draw(st.sampled_from([0.5, 0.00501]))
        a, b = (np.array(data.draw(half_cells if share == 0.5 else anywhere)) * share * grid.cell_m for _ in range(2))
        assert line_is_clear(grid, a, b) == line_is_clear(grid, b, a) == (not touches(grid, a, b))


def test_a_line_through_an_obstacles_corner_or_along_its_edge_is_not_clear() -> None:
    obstacles = np.zeros((3, 3), bool)
    obstacles[1, 1] = True
    grid = Grid((3, 3), obstacles=obstacles)
    assert not line_is_clear(grid, (0, 1), (1, 2))
    assert not line_is_clear(grid, (0.5, 0), (0.5, 2))
    assert line_is_clear(grid, (0.499, 0), (0.499, 2))
    assert not line_is_clear(grid, (0, 0), (4, 0))


@settings(max_examples=40)
@given(grid=rocky(12))
def test_a_pulled_string_is_clear_never_longer_and_pulled_again_the_same(grid: Grid) -> None:
    reached = np.flatnonzero(np.isfinite(distances_m(grid, 0)))
    goal = int(reached[-1])
    path = centres_of(grid, shortest_path(grid, 0, goal))
    taut = string_pulled(grid, path)
    assert np.array_equal(taut[[0, -1]], path[[0, -1]])
    assert length(taut) <= length(path) + 1e-6
    assert all(line_is_clear(grid, a, b) for a, b in itertools.pairwise(taut))
    assert np.array_equal(string_pulled(grid, taut), taut)
    for k in range(1, len(taut) - 1):
        assert not line_is_clear(grid, taut[k - 1], taut[k + 1])
    short = pruned(path)
    assert length(short) == pytest.approx(length(path))
    assert all(line_is_clear(grid, a, b) for a, b in itertools.pairwise(short))


@settings(max_examples=15)
@given(grid=rocky(6))
def test_a_pulled_string_is_nearly_the_shortest_way_that_cells_which_see_each_other_make(grid: Grid) -> None:
    """Brute force: all pairs of cells that see each other, by scipy. The string may lie on the longer side."""
    free = np.flatnonzero(np.isfinite(distances_m(grid, 0)))
    centres = centres_of(grid, free)
    see = np.array([[line_is_clear(grid, a, b) for b in centres] for a in centres])
    apart = np.hypot(*(centres[:, None] - centres[None]).T).T
    best = dijkstra(csr_array(np.where(see, apart, 0.0)))[0, -1]
    taut = length(string_pulled(grid, centres_of(grid, shortest_path(grid, 0, int(free[-1])))))
    assert best - 1e-6 <= taut <= 1.1 * best + 1e-6


def test_a_string_bends_at_both_corners_of_a_block_though_the_path_did_not() -> None:
    obstacles = np.zeros((12, 13), bool)
    obstacles[4:, 4:9] = True
    grid = Grid((12, 13), obstacles=obstacles)
    high = np.array([[0, 0], [0, 11], [12, 11], [12, 0]], float)
    assert string_pulled(grid, high) == pytest.approx(np.array([[0, 0], [3, 8], [9, 8], [12, 0]]))


def test_a_waypoint_that_comes_twice_does_not_straighten_a_bend_around_an_obstacle() -> None:
    grid = Grid((3, 3), obstacles=np.array([[0, 0, 0], [0, 1, 0], [0, 0, 0]], bool))
    path = np.array([[0, 0], [0, 2], [0, 2], [2, 2]], float)
    assert string_pulled(grid, path).tolist() == [[0, 0], [0, 2], [2, 2]]
    assert string_pulled(grid, path[[1, 1, 1]]).tolist() == [[0, 2]]
    assert string_pulled(grid, path[:1]).tolist() == [[0, 0]]


def test_pruning_keeps_a_waypoint_only_where_the_way_turns_more_than_the_threshold() -> None:
    bend = np.array([[0, 0], [10, 0], [20, 0.5], [30, 10]])
    assert pruned(bend).tolist() == [[0, 0], [20, 0.5], [30, 10]]
    assert pruned(bend, degrees=1.0).tolist() == bend.tolist()
    assert pruned(bend, degrees=60.0).tolist() == [[0, 0], [30, 10]]
    assert pruned(bend[:1]).tolist() == [[0, 0]]
    assert pruned(bend[:2]).tolist() == bend[:2].tolist()
    assert np.degrees(turns_rad(bend))[0] == pytest.approx(2.8624, abs=1e-4)


def test_a_way_is_straight_where_it_can_be() -> None:
    obstacles = np.zeros((5, 9), bool)
    obstacles[1:, 4] = True
    grid = Grid((5, 9), obstacles=obstacles)
    assert way(grid, 0, 8).tolist() == centres_of(grid, [0, 8]).tolist()
    assert way(grid, 7, 7).tolist() == centres_of(grid, [7]).tolist()
    stairs, taut = way(grid, 36, 44), way(grid, 36, 44, taut=True)
    assert len(stairs) > 2
    assert length(taut) < length(stairs)


@given(grid=rocky())
def test_places_and_metres_are_inverse(grid: Grid) -> None:
    cells = np.arange(grid.n_cells)
    assert np.array_equal(centres_of(grid, cells), grid.centres_m)
    rows, cols = np.rint(rows_and_cols(grid, grid.centres_m)).astype(int).T
    assert np.array_equal(rows * grid.shape[1] + cols, cells)


def test_what_makes_no_sense_is_refused() -> None:
    grid = Grid((2, 2), obstacles=np.array([[False, True], [False, False]]))
    with pytest.raises(InvalidProblemError, match=r"cell \[0, 1\] is an obstacle"):
        shortest_path(grid, 0, 1)
    with pytest.raises(InvalidProblemError, match="expected 0 to 3"):
        geodesic(grid, [4])
    with pytest.raises(InvalidProblemError, match="leg 0 of the path"):
        string_pulled(grid, [[0, 1], [1, 0]])
    with pytest.raises(UnsupportedProblemError, match="hexagonal"):
        line_is_clear(Grid((2, 2), "hex"), (0, 0), (1, 0))
