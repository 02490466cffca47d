import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.io.vectors import cover


def brute(polygon, shape, cell_m):
    """Shapely's own intersection with every cell."""
    shares = np.empty(shape)
    for row, col in np.ndindex(shape):
        east, north = col * cell_m, (shape[0] - 1 - row) * cell_m
        cell = shapely.box(east - cell_m / 2, north - cell_m / 2, east + cell_m / 2, north + cell_m / 2)
        shares[row, col] = polygon.intersection(cell).area / cell_m**2
    return shares


def star(seed: int, corners: int, around: tuple[float, float], reach: float):
    rng = np.random.default_rng(seed)
    turns = np.sort(rng.uniform(0, 2 * np.pi, corners))
    away = rng.uniform(0.2, 1.0, corners) * reach
    return shapely.Polygon(np.column_stack([np.cos(turns), np.sin(turns)]) * away[:, None] + around).buffer(0)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(3, 30),
    st.tuples(st.floats(-50, 120), st.floats(-50, 120)),
    st.floats(1, 200),
    st.sampled_from([7.0, 10.0, 23.0]),
)
@settings(max_examples=60, deadline=None)
def test_coverage_is_the_area_in_common_with_every_cell(seed, corners, around, reach, cell_m):
    shape = (6, 8)
    outer = star(seed, corners, around, reach)
    polygon = outer - star(seed + 1, corners, around, reach / 3)
    assert np.abs(cover(polygon, shape, cell_m) - brute(polygon, shape, cell_m)).max() < 1e-8


def test_a_polygon_within_the_grid_keeps_its_area():
    polygon = star(7, 200, (500.0, 500.0), 400.0)
    assert cover(polygon, (200, 200), 5.0).sum() * 25.0 == pytest.approx(polygon.area, rel=1e-12)


def test_no_polygon_covers_nothing():
    assert not cover(shapely.Polygon(), (2, 3), 1.0).any()


def test_cells_wholly_within_are_covered_by_exactly_one():
    shares = cover(shapely.box(-5, -5, 95, 95), (10, 10), 10.0)
    assert (shares == 1.0).all()
