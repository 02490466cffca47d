"""Coverage paths: on free ground, along every line, within sight of every cell; distances worked out leg by leg."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.decomposition import SWEEP_ORDERS, Regions, boustrophedon, coverage_path, coverage_paths, plow_lines
from sooner.errors import InvalidProblemError
from sooner.grid import Grid, line_is_clear, rows_and_cols
from sooner.motion.kinematics import Dynamics
from sooner.scenarios.natural import natural_environment
from tests.decomposition.test_regions import grid_of, natural, patchwork


def seen(points, path, radius):
    """(n,) bool: points within a radius of a polyline."""
    near = np.hypot(*(points - path[0]).T) <= radius + 1e-9
    for a, b in pairwise(path):
        along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        near |= np.hypot(*(points - a - along[:, None] * (b - a)).T) <= radius + 1e-9
    return near


def length(path):
    return np.hypot(*np.diff(path, axis=0).T).sum()


def one_region(free, cell_m=1.0):
    grid = grid_of(free, cell_m)
    return grid, Regions.from_labels(grid, np.where(free, 0, -1).astype(np.int32))


def check_path(grid, regions, region, path):
    places = rows_and_cols(grid, path)
    assert np.allclose(places, np.rint(places))
    assert np.allclose(path[[0, -1]], grid.centres_m[regions.centres[region]])
    assert all(line_is_clear(grid, a, b) and not np.array_equal(a, b) for a, b in pairwise(path))


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2.2, 8.8, 17.6]), st.sampled_from([0.0, 4.4]))
def test_paths_over_boustrophedon_regions_are_clear_and_with_a_radius_see_every_cell(seed, spacing, inset):
    grid = grid_of(natural(seed))
    regions = boustrophedon(grid, at_width=45, min_cells=20)
    for region in range(min(regions.n_regions, 3)):
        for path in coverage_paths(grid, regions, region, spacing, inset, radius_m=8.8):
            check_path(grid, regions, region, path)
        assert seen(grid.centres_m[regions.cells(region)], path, 8.8).all()


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1), st.sampled_from(SWEEP_ORDERS))
def test_paths_over_regions_of_any_shape_are_clear_and_fly_every_interval_of_every_line(seed, order):
    free, labels = patchwork(seed)
    if labels.max() < 0:
        return
    grid = grid_of(free)
    regions = Regions.from_labels(grid, labels)
    for region in range(regions.n_regions):
        path = coverage_path(grid, regions, region, 2.2, order)
        check_path(grid, regions, region, path)
        assert seen(grid.centres_m[regions.cells(region)], path, 0).all()


@given(st.integers(0, 2**32 - 1), st.sampled_from([2.2, 5.0, 8.8, 17.6]))
def test_lines_reach_the_border_and_lie_no_further_apart_than_the_spacing(seed, spacing):
    grid = grid_of(natural(seed))
    regions = boustrophedon(grid, at_width=45)
    for region in range(regions.n_regions):
        lines = plow_lines(grid, regions, region, spacing)
        columns = [line[0][0][1] for line in lines]
        cols = regions.box(region)[1]
        assert np.all(np.diff(columns) >= 1)
        assert np.all(np.diff(columns) * 2.2 <= max(spacing, 2.2) + 2.2)  # rounded to columns
        assert columns[0] - cols.start <= spacing / 4.4 + 1
        assert cols.stop - columns[-1] <= spacing / 4.4 + 2
        for line in lines:
            ((north, col), (south, _)) = line[0]
            assert [north, south] == np.flatnonzero(regions.labels[:, col] == region)[[0, -1]].tolist()


def test_the_preset_of_the_paper_sees_nearly_all_and_takes_as_long_as_the_paper_says():
    """[Kuhlman2017, sec. 7.2]: T_max = 9980 +- 750 s, twice the time of all searches; v = a = 2 fits it."""
    drone, times = Dynamics(2.0, 2.0), []
    for number in range(1, 6):
        grid = natural_environment("low", number).grid
        regions = boustrophedon(grid)
        searches = [
            min(coverage_paths(grid, regions, region, 8.8), key=drone.seconds) for region in range(regions.n_regions)
        ]
        times.append(2 * sum(map(drone.seconds, searches)))
        cells = [grid.centres_m[regions.cells(region)] for region in range(regions.n_regions)]
        assert np.concatenate([seen(c, path, 8.8) for c, path in zip(cells, searches, strict=True)]).mean() > 0.995
    assert np.mean(times) == pytest.approx(9980, abs=750)


def test_a_rectangle_is_plowed_as_the_ox_does_from_each_corner():
    grid, regions = one_region(np.ones((5, 9)))
    turns = {"west": [1, 4, 7], "east": [7, 4, 1]}
    for order, path in zip(SWEEP_ORDERS, coverage_paths(grid, regions, 0, 3.0), strict=True):
        side, end = order.split()
        first, last = (4, 0) if end == "north" else (0, 4)
        a, b, c = turns[side]
        assert path[1:-1].tolist() == [[a, first], [a, last], [b, last], [b, first], [c, first], [c, last]]


def test_an_inset_ends_lines_early_and_short_lines_in_their_middle():
    free = np.ones((9, 2), bool)
    free[3:, 1] = False
    grid, regions = one_region(free)
    assert plow_lines(grid, regions, 0, 1.0, inset_m=2.0) == [[((2, 0), (6, 0))], [((1, 1), (1, 1))]]


def test_a_line_that_leaves_the_region_and_comes_back_is_flown_in_intervals_nearest_end_first():
    free = np.ones((9, 5), bool)
    free[3:6, :4] = False  # a C that opens to the west
    grid, regions = one_region(free)
    assert plow_lines(grid, regions, 0, 5.0) == [[((0, 2), (2, 2)), ((6, 2), (8, 2))]]
    path = coverage_path(grid, regions, 0, 5.0, "west south")
    check_path(grid, regions, 0, path)
    assert seen(np.array([[2.0, n] for n in (8, 7, 6, 2, 1, 0)]), path, 0).all()


def test_a_radius_adds_lines_where_the_border_is_ragged_and_only_there():
    free = np.ones((30, 9), bool)
    free[:20, [0, 1, 3, 4, 5, 6, 7, 8]] = False  # a spike at column 2, to the west of the middle line
    grid, regions = one_region(free)
    assert [line[0][0][1] for line in plow_lines(grid, regions, 0, 9.0)] == [4]
    assert [line[0][0][1] for line in plow_lines(grid, regions, 0, 9.0, radius_m=5.0)] == [2, 4]
    assert plow_lines(grid, regions, 0, 9.0, radius_m=21.0) == plow_lines(grid, regions, 0, 9.0)


def test_a_path_has_no_stop_at_which_it_flies_straight_on():
    grid, regions = one_region(np.ones((41, 9)))
    path = coverage_path(grid, regions, 0, 9.0)
    assert path.tolist() == [[4, 20], [4, 40], [4, 0], [4, 20]]
    assert length(path) == 80


@pytest.mark.parametrize(
    ("shape", "waypoints"),
    [
        ((1, 1), [[0, 0]]),
        ((1, 9), [[4, 0], [1, 0], [7, 0], [4, 0]]),
        ((9, 1), [[0, 4], [0, 8], [0, 0], [0, 4]]),
    ],
    ids=["one cell", "corridor east", "corridor north"],
)
def test_the_smallest_regions_are_flown_along_their_middle(shape, waypoints):
    grid, regions = one_region(np.ones(shape))
    assert coverage_path(grid, regions, 0, 3.0).tolist() == waypoints


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"spacing_m": 0}, "spacing of 0 m"),
        ({"inset_m": -1.0}, "inset of -1.0 m"),
        ({"inset_m": 5.0, "radius_m": 4.0}, "not below the inset"),
        ({"order": "north west"}, "expected one of 'west north'"),
        ({"region": 1}, "region 1 came"),
        ({"grid": Grid((3, 3))}, "the grid has"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(wrong, said):
    grid, regions = one_region(np.ones((2, 2)))
    asked = {"grid": grid, "regions": regions, "region": 0, "spacing_m": 8.8} | wrong
    with pytest.raises(InvalidProblemError, match=said):
        coverage_path(**asked)
