"""Regions: what they promise of labels and neighbours, worked out cell by cell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter, label

from sooner.decomposition.regions import Pieces, Regions
from sooner.errors import InvalidProblemError
from sooner.grid import Grid


def natural(seed: int, shape: tuple[int, int] = (30, 45), share: float = 0.66, smooth: float = 2.0) -> np.ndarray:
    """(H, W) bool: free ground under smooth noise, not always in one part."""
    noise = gaussian_filter(np.random.default_rng(seed).normal(size=shape), smooth)
    return noise <= np.quantile(noise, share)


def grid_of(free, cell_m: float = 2.2) -> Grid:
    free = np.asarray(free, bool)
    return Grid(free.shape, "square8", cell_m, ~free)


def parts_of_graph(regions: Regions) -> int:
    group = list(range(regions.n_regions))
    for one, other in regions.adjacency:
        group = [group[one] if g == group[other] else g for g in group]
    return len(set(group))


def patchwork(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Free ground, and labels on some of it: connected blobs of any shape, as chunks or Voronoi cells may be."""
    rng = np.random.default_rng(seed)
    free = natural(seed, (12, 16), 0.8, 1.0)
    blobs = np.where(free, rng.integers(0, 3, (4, 4)).repeat(3, 0).repeat(4, 1), -1)
    labels, count = np.full(free.shape, -1, np.int32), 0
    for value in (0, 1):
        found, n = label(blobs == value)
        labels[found > 0] = found[found > 0] - 1 + count
        count += n
    return free, labels


@given(st.integers(0, 2**32 - 1))
def test_adjacent_are_those_that_share_a_side_or_a_part_of_ground_in_no_region(seed):
    free, labels = patchwork(seed)
    if labels.max() < 0:
        return
    unlabelled, _ = label(free & (labels < 0))
    expected, around = set(), {}
    for row, col in np.argwhere(free):
        for r, c in ((row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1)):
            if not (0 <= r < free.shape[0] and 0 <= c < free.shape[1] and free[r, c]) or labels[row, col] < 0:
                continue
            if labels[r, c] < 0:
                around.setdefault(unlabelled[r, c], set()).add(labels[row, col])
            expected.add((labels[row, col], labels[r, c]))
    expected |= {(a, b) for group in around.values() for a in group for b in group}
    found = Regions.from_labels(grid_of(free), labels)
    assert [tuple(pair) for pair in found.adjacency] == sorted((a, b) for a, b in expected if 0 <= a < b)
    with_regions = len(np.unique(label(free)[0][labels >= 0]))
    assert parts_of_graph(found) == with_regions


@given(st.integers(0, 2**32 - 1))
def test_pieces_paint_the_map_that_they_were_cut_from(seed):
    labels = np.random.default_rng(seed).integers(-1, 3, (7, 5)).astype(np.int32)
    pieces = Pieces.of(labels)
    assert np.array_equal(pieces.painted(pieces.label), labels)
    assert np.array_equal(pieces.column, np.sort(pieces.column))


@given(st.integers(0, 2**32 - 1))
def test_cells_sizes_and_centres_are_those_of_the_labels(seed):
    free, labels = patchwork(seed)
    if labels.max() < 0:
        return
    regions = Regions.from_labels(grid_of(free), labels)
    for region in range(regions.n_regions):
        cells = np.flatnonzero(labels == region)
        assert np.array_equal(regions.cells(region), cells)
        assert regions.sizes[region] == cells.size
        places = np.argwhere(labels == region)
        apart = np.hypot(*(places - places.mean(axis=0)).T)
        assert apart[cells == regions.centres[region]] == pytest.approx(apart.min())


def test_ground_between_that_belongs_to_no_region_joins_all_around_it_in_pairs():
    labels = np.array([[0, -1, 1], [-1, -1, -1], [2, -1, 3]], np.int32)
    assert Regions.from_labels(Grid((3, 3)), labels).adjacency.tolist() == [
        [0, 1],
        [0, 2],
        [0, 3],
        [1, 2],
        [1, 3],
        [2, 3],
    ]


def test_a_corner_joins_nothing():
    labels = np.array([[0, -1], [-1, 1]], np.int32)
    assert len(Regions.from_labels(Grid((2, 2), obstacles=labels < 0), labels).adjacency) == 0


@pytest.mark.parametrize(
    ("labels", "adjacency", "said"),
    [
        ([[0, -1, 0]], [], "region 0 came in 2 parts"),
        ([[0, -1], [-1, 0]], [], "region 0 came in 2 parts"),
        ([[0, 2]], [], "no cell has label 1"),
        ([[-1, -1]], [], "without any region"),
        ([[0, -2]], [], "below -1"),
        ([[0, 1]], [[1, 0]], "the lower first"),
        ([[0, 1]], [[0, 0]], "the lower first"),
        ([[0, 1]], [[0, 2]], "numbers below 2"),
        ([[0, 1]], [[0, 1], [0, 1]], "each once"),
        ([0, 1], [], "expected \\(H, W\\)"),
        ([[0.0, 1.0]], [], "whole numbers"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(labels, adjacency, said):
    with pytest.raises(InvalidProblemError, match=said):
        Regions(np.array(labels), np.array(adjacency, np.int64).reshape(-1, 2))


def test_regions_of_another_map_or_on_obstacles_or_of_hexagons_are_refused():
    labels = np.zeros((2, 2), np.int32)
    with pytest.raises(InvalidProblemError, match="the grid has"):
        Regions.from_labels(Grid((2, 3)), labels)
    with pytest.raises(InvalidProblemError, match=r"obstacle \[0, 1\] has label 0"):
        Regions.from_labels(Grid((2, 2), obstacles=np.array([[False, True], [False, False]])), labels)
    with pytest.raises(InvalidProblemError, match="hexagonal"):
        Regions.from_labels(Grid((2, 2), "hex"), labels)
    with pytest.raises(InvalidProblemError, match="region 1 came"):
        Regions.from_labels(Grid((2, 2)), labels).cells(1)
