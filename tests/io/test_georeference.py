"""Places on the globe and cells of a raster."""

import numpy as np
import pytest
from rasterio.warp import transform

from sooner.errors import InvalidProblemError
from sooner.io import Raster, read_raster
from sooner.io.georeference import cell_at
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
