"""Modes on peaks, plateaus and ridges, against their definition worked out cell by cell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.decomposition import modes
from sooner.grid import Grid


def found(surface, connectivity="square4", obstacles=None):
    surface = np.asarray(surface, float)
    grid = Grid(surface.shape, connectivity, obstacles=obstacles)
    return [grid.cell(int(c)) for c in modes(grid, surface.ravel())]


def test_a_peak_is_a_mode():
    assert found([[0, 1, 0], [1, 2, 1], [0, 1, 0]]) == [(1, 1)]


def test_a_plateau_is_one_mode_at_its_middle():
    assert found([[0, 0, 0, 0, 0], [0, 3, 3, 3, 0], [0, 0, 0, 0, 0]]) == [(1, 2)]


def test_a_plateau_with_a_higher_neighbour_is_none():
    assert found([[3, 3, 3, 4]]) == [(0, 3)]


def test_a_ridge_that_rises_has_one_mode_at_its_top():
    assert found([[0, 0, 0, 0], [1, 2, 3, 4], [0, 0, 0, 0]]) == [(1, 3)]


def test_the_diagonal_neighbour_counts_on_squares():
    assert found([[2, 0], [0, 1]]) == [(0, 0)]


def test_equal_cells_that_touch_at_a_corner_are_one_plateau():
    assert found([[2, 0, 0], [0, 2, 0], [0, 0, 2]]) == [(1, 1)]


def test_flat_ground_is_one_mode_and_empty_ground_none():
    assert found(np.ones((3, 5))) == [(1, 2)]
    assert found(np.zeros((3, 5))) == []


def test_the_middle_of_a_ring_stays_off_an_obstacle():
    ring = np.ones((3, 3))
    ring[1, 1] = 0
    assert found(ring, obstacles=ring == 0) != [(1, 1)]


@pytest.mark.parametrize("connectivity", ["square4", "square8", "hex"])
@given(st.integers(0, 2**32 - 1))
def test_every_mode_is_a_plateau_without_a_higher_neighbour(connectivity, seed):
    rng = np.random.default_rng(seed)
    surface = rng.integers(0, 4, (5, 6)).astype(float)
    around = Grid((5, 6), "hex" if connectivity == "hex" else "square8").neighbours
    flat, tops, seen = surface.ravel(), 0, set()
    for cell in range(30):
        if cell in seen or flat[cell] == 0:
            continue
        plateau, rim = {cell}, [cell]
        while rim:
            here = rim.pop()
            for other in around[here]:
                if other >= 0 and flat[other] == flat[cell] and int(other) not in plateau:
                    plateau.add(int(other))
                    rim.append(int(other))
        seen |= plateau
        tops += all(flat[o] <= flat[cell] for c in plateau for o in around[c] if o >= 0)
    assert len(modes(Grid((5, 6), connectivity), flat)) == tops
