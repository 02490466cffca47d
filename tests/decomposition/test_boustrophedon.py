"""The boustrophedon decomposition, against a sweep written column by column and scipy's labelling."""

from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import label

from sooner.decomposition import boustrophedon
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.scenarios.natural import natural_environments
from tests.decomposition.test_regions import grid_of, natural, parts_of_graph

ALL = {"min_cells": 0, "min_columns": 0, "at_width": 45}


def runs(column):
    """(first, past) of each run of free cells."""
    padded = np.concatenate([[False], column, [False]])
    return [tuple(map(int, run)) for run in np.flatnonzero(padded[1:] != padded[:-1]).reshape(-1, 2)]


def swept(free, overlap):
    """The oracle: labels by a sweep from column to column, greedily by overlap where ground parts or joins."""
    labels, before, count = np.full(free.shape, -1), {}, 0
    for col in range(free.shape[1]):
        here = runs(free[:, col])
        shared = {(b, h): min(b[1], h[1]) - max(b[0], h[0]) for b in before for h in here}
        touch = {pair: n for pair, n in shared.items() if n > 0}
        score = {(b, h): n / max(b[1] - b[0], h[1] - h[0]) for (b, h), n in touch.items()}
        for b, h in touch:
            if sum(p[0] == b for p in touch) == sum(p[1] == h for p in touch) == 1:
                score[b, h] = 2.0
        now = {}
        for b, h in sorted(score, key=score.get, reverse=True):
            if score[b, h] >= overlap and h not in now and before[b] not in now.values():
                now[h] = before[b]
        for h in here:
            if h not in now:
                now[h], count = count, count + 1
            labels[h[0] : h[1], col] = now[h]
        before = now
    return labels


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.51, 0.8, 1.0]), st.sampled_from([0.0, 1.0, 2.0]))
def test_it_is_the_sweep_from_column_to_column(seed, overlap, smooth):
    free = natural(seed, (12, 18), smooth=smooth)
    ours = boustrophedon(grid_of(free), overlap=overlap, **ALL)
    assert np.array_equal(ours.labels, swept(free, overlap))


@given(st.integers(0, 2**32 - 1), st.floats(0.3, 0.95), st.sampled_from([1.5, 2.5, 4.0]))
def test_regions_partition_free_ground_but_for_small_ones_and_stay_connected(seed, share, smooth):
    free = natural(seed, share=share, smooth=smooth)
    everything = boustrophedon(grid_of(free), **ALL)
    regions = boustrophedon(grid_of(free), at_width=45, min_cells=20)
    assert np.array_equal(everything.labels >= 0, free)
    wide = np.array([np.ptp(np.nonzero(everything.labels == r)[1]) + 1 for r in range(everything.n_regions)])
    stays = (everything.sizes >= 20) & (wide >= 3)
    stays[np.argmax(everything.sizes)] = True
    assert np.array_equal(regions.labels >= 0, np.append(stays, False)[everything.labels])
    for region in range(regions.n_regions):
        assert label(regions.labels == region)[1] == 1
        assert all(len(runs(column)) <= 1 for column in (regions.labels == region).T)
    assert parts_of_graph(everything) == label(free)[1]
    assert parts_of_graph(regions) == len(np.unique(label(free)[0][regions.labels >= 0]))


@given(st.integers(0, 2**32 - 1))
def test_small_obstacles_that_the_sweep_ignores_are_holes_in_connected_regions(seed):
    free = natural(seed, share=0.8, smooth=1.0)
    regions = boustrophedon(grid_of(free), min_obstacle=12, **ALL)
    assert np.array_equal(regions.labels >= 0, free)
    assert regions.n_regions >= boustrophedon(grid_of(free), min_obstacle=12, at_width=45).n_regions
    assert parts_of_graph(regions) == label(free)[1]


def test_a_small_obstacle_costs_three_regions_unless_it_is_ignored():
    free = np.ones((20, 45), bool)
    free[8:11, 20:24] = False
    assert boustrophedon(grid_of(free), **ALL).n_regions == 4
    assert boustrophedon(grid_of(free), min_obstacle=12, **ALL).n_regions == 4
    assert boustrophedon(grid_of(free), min_obstacle=13, **ALL).n_regions == 1


def test_what_an_ignored_obstacle_cuts_off_is_a_region_of_its_own():
    free = np.ones((6, 45), bool)
    free[:, 20] = False
    regions = boustrophedon(grid_of(free), min_obstacle=7, **ALL)
    assert (regions.n_regions, regions.sizes.tolist(), len(regions.adjacency)) == (2, [120, 144], 0)


@pytest.mark.parametrize(
    ("kind", "mean", "deviation"), [("low", 13, 4.3), ("med", 28, 5.1), ("high", 37, 5.8), ("vhf", 45, 6.8)]
)
def test_natural_environments_have_as_many_regions_as_in_the_paper(kind, mean, deviation):
    """[Kuhlman2017, sec. 6.2]: mean and standard deviation over 40 environments; ours over fewer."""
    counts = [boustrophedon(ground.grid).n_regions for ground in islice(natural_environments(kind), 10)]
    assert np.mean(counts) == pytest.approx(mean, abs=deviation)


def test_finer_cells_of_the_same_ground_have_the_same_regions():
    free = natural(7, (50, 100), smooth=5.0)
    coarse, fine = boustrophedon(grid_of(free)), boustrophedon(grid_of(np.kron(free, np.ones((4, 4), bool)), 0.55))
    assert np.array_equal(fine.labels, np.kron(coarse.labels, np.ones((4, 4), np.int32)))
    assert np.array_equal(fine.adjacency, coarse.adjacency)


def test_a_straight_edge_that_bends_slowly_stays_one_region_and_a_sudden_gap_parts_it():
    wedge = np.arange(30)[:, None] >= np.arange(60)[None] // 4
    assert boustrophedon(grid_of(wedge), at_width=60).n_regions == 1
    wedge[18:22, 30:] = False
    assert boustrophedon(grid_of(wedge), at_width=60).n_regions == 3


@pytest.mark.parametrize(
    ("free", "n_regions", "cells"),
    [
        (np.ones((1, 1)), 1, 1),
        (np.eye(3), 1, 1),
        (np.ones((1, 50)), 1, 50),
        (np.ones((50, 1)), 1, 50),
        (np.ones((40, 50)), 1, 2000),
        (np.arange(60)[None, :].repeat(20, 0) % 20 != 0, 3, 1140),
    ],
    ids=["one cell", "corners", "corridor east", "corridor north", "all free", "three rooms without doors"],
)
def test_any_free_ground_has_a_region(free, n_regions, cells):
    regions = boustrophedon(grid_of(free), at_width=np.shape(free)[1])
    assert (regions.n_regions, regions.sizes.sum()) == (n_regions, cells)
    assert len(regions.adjacency) == 0


@pytest.mark.parametrize(
    ("grid", "wrong", "said"),
    [
        (grid_of(np.zeros((3, 4))), {}, "at least one free cell"),
        (Grid((3, 4), "hex"), {}, "hexagonal"),
        (Grid((3, 4)), {"overlap": 0.5}, "more than 0.5"),
        (Grid((3, 4)), {"overlap": 1.1}, "at most 1"),
        (Grid((3, 4)), {"min_cells": -1}, "at least 0"),
        (Grid((3, 4)), {"min_columns": np.nan}, "at least 0"),
        (Grid((3, 4)), {"at_width": 0}, "positive"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(grid, wrong, said):
    with pytest.raises(InvalidProblemError, match=said):
        boustrophedon(grid, **wrong)
