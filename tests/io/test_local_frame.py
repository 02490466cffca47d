import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.io.georeference import ground_m
from sooner.io.local_frame import LocalFrame, projection
from sooner.io.vectors import cover


@given(st.floats(-80, 80), st.floats(-179, 178), st.floats(0.005, 0.05))
@settings(max_examples=40, deadline=None)
def test_metres_of_the_frame_are_metres_on_the_ground(lat, lon, size):
    frame = LocalFrame.around(shapely.box(lon, lat, lon + size, lat + size), cell_m=25.0)
    places = [[lat, lon], [lat + size, lon + size / 3]]
    apart = np.linalg.norm(np.diff(frame.metres(places), axis=0))
    assert apart == pytest.approx(ground_m(places)[0], rel=2e-5)
    assert frame.scale_error < 1e-6
    assert np.abs(frame.places(frame.metres(places)) - places).max() < 1e-9


def test_the_grid_holds_the_area_and_its_border():
    area = shapely.box(11.20, 46.10, 11.25, 46.13)
    for border_m in (0.0, 60.0):
        frame = LocalFrame.around(area, 20.0, border_m)
        west, south, east, north = frame.moved(area).bounds
        height, width = frame.shape
        assert min(west, south) >= border_m - 10.0 - 1e-6
        assert width * 20.0 - 10.0 - east >= border_m - 1e-6
        assert height * 20.0 - 10.0 - north >= border_m - 1e-6
    polygon = frame.moved(area)
    assert cover(polygon, frame.shape, 20.0).sum() * 400.0 == pytest.approx(polygon.area, rel=1e-9)


def test_metres_are_those_of_the_grid_s_cells():
    from sooner.grid import Grid

    frame = LocalFrame.around(shapely.box(11.20, 46.10, 11.21, 46.11), 100.0)
    centres = Grid(frame.shape, cell_m=100.0).centres_m
    cells = np.column_stack(np.divmod(np.arange(len(centres)), frame.shape[1]))
    assert np.abs(frame.metres(frame.ground.places(cells)) - centres).max() < 1e-5


def test_long_edges_bend_as_they_do_on_the_globe():
    lat, edge = 46.0, shapely.box(11.0, 46.0, 11.6, 46.1)
    frame = LocalFrame.around(edge, 100.0)
    half_way = frame.metres([[lat, 11.3]])[0]
    assert frame.moved(edge).exterior.distance(shapely.Point(half_way)) < 0.05


def test_a_projection_by_number_is_the_frame_s_own():
    frame = LocalFrame.around(shapely.box(11.20, 46.10, 11.21, 46.11), 20.0, crs=projection("EPSG:32632"))
    assert frame.ground.crs == "EPSG:32632"
    assert frame.ground.corner[0] % 20.0 == 0.0
    assert 1e-5 < frame.scale_error < 1e-3


def test_a_projection_in_feet_has_cells_in_metres():
    frame = LocalFrame.around(shapely.box(-105.3, 40.0, -105.29, 40.01), 10.0, crs=projection("EPSG:2231"))
    assert frame.ground.side == pytest.approx(10.0 / 0.3048, rel=1e-5)
    apart = np.linalg.norm(np.diff(frame.metres([[40.0, -105.3], [40.01, -105.3]]), axis=0))
    assert apart == pytest.approx(1110.0, rel=1e-3)


@pytest.mark.parametrize(
    "name", ["EPSG:4326", "EPSG:1", "EPSG:999999", "http://127.0.0.1/crs", "+proj=merc", "", "EPSG:"]
)
def test_other_projections_are_refused(name):
    with pytest.raises(InvalidProblemError, match="EPSG:32632"):
        projection(name)


def test_too_wide_an_area_and_too_many_cells_are_refused():
    with pytest.raises(InvalidProblemError, match="100 km"):
        LocalFrame.around(shapely.box(11.0, 46.0, 13.0, 46.1), 100.0)
    with pytest.raises(InvalidProblemError, match=r"cell_m of at least 0\.6"):
        LocalFrame.around(shapely.box(11.0, 46.0, 11.03, 46.03), 0.1)
