import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.belief.rings import disc_areas, ring_poc
from sooner.errors import InvalidProblemError
from sooner.grid import Grid

RINGS, SHARES = [300.0, 900.0, 2000.0], [0.25, 0.5, 0.95]


@given(st.floats(-60, 90), st.floats(-60, 90), st.floats(0.5, 200))
@settings(max_examples=60, deadline=None)
def test_areas_are_those_of_a_disc_of_many_corners(east, north, radius):
    disc = shapely.Point(east, north).buffer(radius, quad_segs=2000)
    found = disc_areas((3, 4), 10.0, (east, north), radius)
    for row, col in np.ndindex(3, 4):
        x, y = col * 10.0, (2 - row) * 10.0
        expected = disc.intersection(shapely.box(x - 5, y - 5, x + 5, y + 5)).area
        assert found[row, col] == pytest.approx(expected, abs=2e-6 * radius * 10)


def test_every_ring_holds_its_share():
    grid = Grid((201, 201), cell_m=25.0)
    centre = (2512.0, 2480.0)
    poc = ring_poc(grid, centre, RINGS, SHARES)
    assert poc.sum() == pytest.approx(0.95, abs=1e-12)
    away = np.linalg.norm(grid.centres_m - centre, axis=1).reshape(grid.shape)
    for radius, share in zip(RINGS, SHARES, strict=True):
        well_within, about = poc[away < radius - 18].sum(), poc[away < radius + 18].sum()
        assert well_within <= share + 1e-12 <= about + 2e-12


def test_mass_is_even_by_area_within_a_ring():
    grid = Grid((201, 201), cell_m=25.0)
    poc = ring_poc(grid, (2500.0, 2500.0), RINGS, SHARES)
    away = np.linalg.norm(grid.centres_m - 2500.0, axis=1).reshape(grid.shape)
    inside = poc[(away > 320) & (away < 880)]
    assert inside == pytest.approx(np.full(inside.shape, 0.25 * 625.0 / (np.pi * (900**2 - 300**2))), rel=1e-9)


def test_what_lies_beyond_the_grid_is_outside():
    whole = ring_poc(Grid((100, 100), cell_m=50.0), (2475.0, 2475.0), RINGS, SHARES)
    half = ring_poc(Grid((100, 50), cell_m=50.0), (2475.0, 2475.0), RINGS, SHARES)
    assert half == pytest.approx(whole[:, :50])
    assert ring_poc(Grid((4, 4), cell_m=1.0), (9000.0, 0.0), RINGS, SHARES).sum() == 0.0


@pytest.mark.parametrize(
    ("rings", "shares"),
    [
        ([], []),
        ([300.0], [0.5, 0.9]),
        ([300.0, 200.0], [0.5, 0.9]),
        ([0.0], [0.5]),
        ([np.nan], [0.5]),
        ([1e7], [0.5]),
        ([300.0], [0.0]),
        ([300.0, 400.0], [0.5, 0.5]),
        ([300.0], [1.01]),
        ([300.0], [np.inf]),
    ],
)
def test_tables_that_do_not_grow_are_refused(rings, shares):
    with pytest.raises(InvalidProblemError):
        ring_poc(Grid((3, 3)), (0.0, 0.0), rings, shares)


def test_hexagons_and_centres_that_are_none_are_refused():
    with pytest.raises(InvalidProblemError, match="square cells"):
        ring_poc(Grid((3, 3), "hex"), (0.0, 0.0), [1.0], [0.5])
    with pytest.raises(InvalidProblemError, match="centre"):
        ring_poc(Grid((3, 3)), (np.nan, 0.0), [1.0], [0.5])
