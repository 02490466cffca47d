"""Regions that follow what there is to learn: partitions of the same ground, whatever cuts it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.decomposition import boustrophedon
from sooner.decomposition.aware import gain_classes, regions_for
from sooner.decomposition.chunks import chunked
from sooner.decomposition.regions import joined
from sooner.decomposition.voronoi import voronoi
from sooner.errors import InvalidProblemError
from sooner.grid import Grid


def ground(seed, shape=(30, 40)):
    """A map with blobs of obstacles, all free ground in one piece, and a first look that pays unevenly."""
    from scipy.ndimage import gaussian_filter, label

    rng = np.random.default_rng(seed)
    free = gaussian_filter(rng.random(shape), 2.0) < 0.53
    groups, _ = label(free)
    free = groups == np.bincount(groups.ravel())[1:].argmax() + 1
    gains = np.where(gaussian_filter(rng.random(shape), 4.0) < 0.5, 0.4, 0.05)
    return Grid(shape, "square8", 2.0, ~free), gains


def graph_is_connected(regions):
    return joined(regions.n_regions, *regions.adjacency.T)[0] == 1


@settings(max_examples=25)
@given(
    seed=st.integers(0, 1000),
    chunk=st.sampled_from([8.0, 20.0, np.inf]),
    tall=st.sampled_from([8.0, np.inf]),
    least=st.sampled_from([0.0, 60.0]),
)
def test_chunks_are_the_same_ground_in_connected_regions(seed, chunk, tall, least):
    grid, gains = ground(seed)
    whole = boustrophedon(grid, min_cells=10, min_columns=1, at_width=40)
    cut = chunked(grid, whole, chunk, gain_classes(grid, gains), least, tall)
    assert ((cut.labels >= 0) == (whole.labels >= 0)).all()
    assert graph_is_connected(cut)  # that each region hangs together, Regions itself checks
    if cut.n_regions > 1 and graph_is_connected(whole):
        assert (cut.sizes * 4.0 >= least).all() or whole.n_regions > 1


@settings(max_examples=25)
@given(seed=st.integers(0, 1000), size=st.sampled_from([100.0, 400.0]), classes=st.booleans())
def test_voronoi_regions_are_all_free_ground_in_connected_regions(seed, size, classes):
    grid, gains = ground(seed)
    regions = voronoi(grid, gains, size, gain_classes(grid, gains) if classes else None, min_m2=30.0)
    assert ((regions.labels >= 0).ravel() == grid.passable).all()
    assert graph_is_connected(regions)


def test_voronoi_regions_are_smaller_where_more_is_to_learn():
    gains = np.ones((30, 80))
    gains[:, 40:] = 9.0
    regions = voronoi(Grid((30, 80), "square8"), gains, 60.0, min_m2=0.0)
    rich = np.unique(regions.labels[:, 60:])
    poor = np.unique(regions.labels[:, :20])
    assert regions.sizes[rich].mean() < 0.8 * regions.sizes[poor].mean()


def test_voronoi_does_not_look_through_walls():
    rock = np.zeros((21, 21), bool)
    rock[:-1, 10] = True
    regions = voronoi(Grid((21, 21), "square8", 1.0, rock), np.ones(441), 210.0, min_m2=0.0)
    assert len(np.intersect1d(regions.labels[:10, :10], regions.labels[:10, 11:])) == 0


def test_chunks_are_as_wide_and_as_tall_as_was_asked():
    grid = Grid((20, 60), "square8")
    whole = boustrophedon(grid, min_cells=1, min_columns=1)
    cut = chunked(grid, whole, 15.0, min_m2=0.0, tall_m=10.0)
    assert cut.sizes.tolist() == [150] * 8
    assert len(cut.adjacency) == 10


def test_regions_do_not_reach_over_a_border_of_classes():
    grid, gains = Grid((40, 60), "square8"), np.full((40, 60), 0.4)
    gains[:, 25:] = 0.05
    cut = regions_for(grid, gains, chunk_m=1000.0)
    assert cut.n_regions == 2
    assert (cut.labels[:, :25] == 0).all()


def test_a_sliver_joins_the_neighbour_with_the_longest_border():
    grid = Grid((9, 12), "square8")
    classes = np.zeros((9, 12), int)
    classes[0, 3:9] = 1
    cut = chunked(grid, boustrophedon(grid, min_cells=1, min_columns=1), np.inf, classes, min_m2=10.0)
    assert cut.n_regions == 1


def test_even_gains_are_one_class_and_noise_makes_no_ragged_border():
    grid = Grid((40, 40), "square8")
    assert gain_classes(grid, np.full(1600, 0.3)).max() == 0
    noisy = np.where(np.arange(40) < 20, 1.0, 3.0) + np.random.default_rng(0).normal(0, 0.3, (40, 40))
    classes = gain_classes(grid, noisy.clip(0), levels=2, smooth_m=8.0)
    assert (np.diff(classes, axis=1) != 0).sum() == 40


def test_even_ground_is_cut_only_where_a_region_is_too_large():
    grid = Grid((30, 40), "square8", 10.0)
    assert regions_for(grid, np.ones(1200)).n_regions == 1
    parts = regions_for(grid, np.ones(1200), swept_m2=120_000.0)
    assert parts.sizes.tolist() == [300] * 4


def test_a_large_map_has_larger_chunks_instead_of_ever_more_regions():
    grid = Grid((300, 300), "square8", 10.0)
    assert 50 <= regions_for(grid, np.ones(90_000), most=100, swept_m2=20_000.0).n_regions <= 150
    halves = np.repeat([[1.0, 3.0]], 150, axis=1).repeat(300, axis=0)
    assert 50 <= regions_for(grid, halves, most=100, swept_m2=20_000.0).n_regions <= 150


def test_chunks_of_a_finer_map_are_those_of_the_coarse_one():
    grid, gains = ground(3)
    rock, many = np.kron(~grid.passable.reshape(30, 40), np.ones((3, 3))) > 0, np.kron(gains, np.ones((3, 3)))
    fine = replace(grid, shape=(90, 120), cell_m=2.0 / 3, obstacles=rock)
    plain, finely = (boustrophedon(each, min_cells=10, min_columns=1, at_width=40) for each in (grid, fine))
    coarse = regions_for(grid, gains, plain, chunk_m=16.0, min_m2=100.0)
    finer = regions_for(fine, many, finely, chunk_m=16.0, min_m2=100.0)
    assert abs(finer.n_regions - coarse.n_regions) <= 0.15 * coarse.n_regions + 1


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda g: gain_classes(g, np.ones(3)), "gains of 3 cells came; expected 1200"),
        (lambda g: gain_classes(g, np.ones(1200), levels=0), "0 levels"),
        (lambda g: voronoi(g, np.ones(1200), -1.0), "regions of -1.0 m2"),
        (lambda g: voronoi(g, -np.ones(1200)), "finite and at least 0"),
        (lambda g: voronoi(g, np.ones(1200), classes=np.zeros((2, 2), int)), "classes of shape"),
        (lambda g: voronoi(Grid((3, 3), "hex"), np.ones(9)), "hexagonal"),
        (lambda g: chunked(g, boustrophedon(g, min_cells=1), -1.0), "chunks of -1.0 m"),
        (lambda g: chunked(g, boustrophedon(g, min_cells=1), 9.0, np.zeros((2, 2), int)), "classes of shape"),
    ],
)
def test_what_makes_no_sense_is_refused_with_what_came(call, words):
    with pytest.raises(InvalidProblemError, match=words):
        call(ground(0)[0])
