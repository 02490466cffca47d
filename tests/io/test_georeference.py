"""Places on the globe and cells of a raster."""

import numpy as np
import pytest
from rasterio.transform import from_origin
from rasterio.warp import transform

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.io import Raster, read_raster
from sooner.io.georeference import Georeference, cell_at, ground_m
from tests.io.test_rasters import geotiff

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio


@pytest.mark.parametrize(("crs", "side_m"), [("EPSG:32632", 20.0), ("EPSG:2263", 20.0 * 1200 / 3937)])
def test_the_centre_of_every_cell_lies_in_it(tmp_path, crs, side_m):
    raster = read_raster(geotiff(tmp_path / "map.tif", np.ones((7, 5), np.float32), crs=crs))
    assert raster.cell_m == pytest.approx(side_m)
    for row, col in ((0, 0), (6, 4), (3, 1)):
        for down, right in ((0.5, 0.5), (0.01, 0.99), (0.99, 0.01)):
            east, north = 500_000 + 20 * (col + right), 5_100_000 - 20 * (row + down)
            (lon,), (lat,) = transform(crs, "EPSG:4326", [east], [north])
            assert cell_at(raster, lat, lon) == (row, col)


def test_a_place_beyond_the_map_is_a_cell_beyond_it(tmp_path):
    raster = read_raster(geotiff(tmp_path / "map.tif", np.ones((7, 5), np.float32)))
    (lon,), (lat,) = transform("EPSG:32632", "EPSG:4326", [500_000 - 30.0], [5_100_000 + 10.0])
    assert cell_at(raster, lat, lon) == (-1, -2)


def test_a_map_without_georeference_and_a_place_out_of_its_projection_are_refused(tmp_path):
    with pytest.raises(InvalidProblemError, match="without a georeference"):
        cell_at(Raster(np.ones((2, 2))), 46.0, 9.0)
    far = read_raster(geotiff(tmp_path / "map.tif", np.ones((2, 2), np.uint8), crs="EPSG:32632"))
    with pytest.raises(InvalidProblemError, match="does not reach"):
        cell_at(far, 0.0, 99.0)


# ---------------------------------------------------------------- many places at once


GRIDS = {
    "EPSG:32632": (620_000.0, 5_105_000.0),  # UTM 32 north: the Dolomites
    "EPSG:32759": (370_000.0, 5_200_000.0),  # UTM 59 south: New Zealand's Alps
    "EPSG:27700": (225_000.0, 775_000.0),  # Great Britain: Ben Nevis
    "EPSG:2154": (990_000.0, 6_540_000.0),  # France: Mont Blanc
    "EPSG:3035": (4_400_000.0, 2_600_000.0),  # Europe, of equal area
    "EPSG:5070": (-1_450_000.0, 1_950_000.0),  # the United States, of equal area: Utah
    "EPSG:3857": (1_250_000.0, 5_850_000.0),  # the web's maps
    "EPSG:2263": (985_000.0, 215_000.0),  # New York, in feet
    "EPSG:3413": (-300_000.0, -2_100_000.0),  # Greenland, from the pole
    "EPSG:26712": (470_000.0, 4_480_000.0),  # NAD27, an older datum
}


@pytest.mark.parametrize("crs", GRIDS)
def test_places_come_back_to_where_they_were_to_a_tenth_of_a_metre(crs):
    ground = Georeference(crs, GRIDS[crs], 24.0, 24.0)
    cells = np.random.default_rng(0).uniform(-0.5, 400.0, (500, 2))
    places = ground.places(cells)
    assert (np.abs(places) <= [90.0, 180.0]).all()
    off_m = np.hypot(*(ground.cells(np.round(places, 9)) - cells).T) * ground.cell_m
    assert off_m.max() < 0.1
    for row, col in np.rint(cells[:20]).astype(int).tolist():
        assert ground.cell_at(*ground.places([[row, col]])[0]) == (row, col)


def test_mercators_places_are_those_of_its_formula():
    ground = Georeference("EPSG:3857", (1_250_000.0, 5_850_000.0), 24.0, 24.0)
    radius = 6_378_137.0
    east, north = 1_250_000.0 + 24 * 3.5, 5_850_000.0 - 24 * 7.5
    lat, lon = 2 * np.arctan(np.exp(north / radius)) - np.pi / 2, east / radius
    np.testing.assert_allclose(ground.places([[7, 3]]), np.degrees([[lat, lon]]), atol=1e-9)
    assert ground.scale_at(7, 3) == pytest.approx(np.cos(lat), rel=4e-3)  # of a sphere; the ellipsoid is near


def test_an_old_national_grid_is_told_as_satellites_see_it():
    """The water tower at Caister, by the national grid; its place by the seven parameters, good to some metres."""
    ground = Georeference("EPSG:27700", (651_409.903, 313_177.270), 1.0, 1.0)
    ((lat, lon),) = ground.places([[-0.5, -0.5]])
    assert ground_m([[lat, lon], [52.657979, 1.716052]])[0] < 5.0


@pytest.mark.parametrize("crs", ["EPSG:32632", "EPSG:2154", "EPSG:27700"])
def test_metres_over_ground_are_the_projections_where_it_is_true(crs):
    ground = Georeference(crs, GRIDS[crs], 24.0, 24.0)
    along = ground_m(ground.places([[0, 0], [0, 100], [300, 100]]))
    np.testing.assert_allclose(along, [2400.0, 7200.0], rtol=1e-3)
    assert ground.scale_at(0, 0) == pytest.approx(1.0, abs=1e-3)


def test_a_degree_of_latitude_is_as_long_as_tables_say():
    """At 0, 45 and 89 degrees: 110.574, 111.132 and 111.694 km; of longitude at 0 and 60: 111.320 and 55.800 km."""
    for lat, km in ((0.0, 110.574), (45.0, 111.132), (89.0, 111.694)):
        assert ground_m([[lat - 0.5, 0.0], [lat + 0.5, 0.0]])[0] / 1e3 == pytest.approx(km, abs=2e-3)
    for lat, km in ((0.0, 111.320), (60.0, 55.800)):
        assert ground_m([[lat, 0.0], [lat, 1.0]])[0] / 1e3 == pytest.approx(km, abs=2e-3)


def test_places_that_a_projection_does_not_reach_are_refused():
    ground = Georeference("EPSG:32632", (620_000.0, 5_105_000.0), 24.0, 24.0)
    with pytest.raises(InvalidProblemError, match="does not reach"):
        ground.places([[0, 0], [0, 1e12]])
    with pytest.raises(InvalidProblemError, match="does not reach"):
        ground.cells([[46.0, 9.0], [np.nan, 9.0]])


def test_degrees_are_no_square_cells(tmp_path):
    path = geotiff(tmp_path / "map.tif", np.ones((3, 3), np.uint8), crs="EPSG:4326", transform=from_origin(9, 46, 1, 1))
    with pytest.raises(DataFormatError, match="reproject the raster first"):
        read_raster(path)
