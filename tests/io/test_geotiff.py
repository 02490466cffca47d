"""Maps that are written are read back as they were, by us and by GDAL."""

import numpy as np
import pytest

from sooner.io import read_raster
from sooner.io.georeference import Georeference
from sooner.io.geotiff import geotiff

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
VALUES = np.random.default_rng(0).random((7, 5)) ** 8


@pytest.mark.parametrize(("crs", "side", "cell_m"), [("EPSG:32632", 24.0, 24.0), ("EPSG:2263", 80.0, 80 * 1200 / 3937)])
def test_what_is_written_is_read_back(tmp_path, crs, side, cell_m):
    ground = Georeference(crs, (500_000.0, 5_100_000.0), side, cell_m)
    (tmp_path / "map.tif").write_bytes(geotiff(VALUES, ground))
    raster = read_raster(tmp_path / "map.tif")
    np.testing.assert_allclose(raster.values, VALUES, rtol=1e-7)
    found = Georeference.of(raster)
    assert (found.crs, found.corner, found.side) == (crs, ground.corner, pytest.approx(side))
    assert found.cell_m == pytest.approx(cell_m)


def test_gdal_tells_what_the_numbers_are(tmp_path):
    import rasterio

    ground = Georeference("EPSG:32632", (500_000.0, 5_100_000.0), 24.0, 24.0)
    (tmp_path / "map.tif").write_bytes(geotiff(VALUES, ground, "POD", {"MISSION": "<ridge> & more"}))
    with rasterio.open(tmp_path / "map.tif") as source:
        assert source.descriptions == ("POD",)
        assert source.tags()["MISSION"] == "<ridge> & more"
        np.testing.assert_allclose(source.read(1), VALUES, rtol=1e-7)


def test_the_same_numbers_are_the_same_file():
    ground = Georeference("EPSG:32632", (500_000.0, 5_100_000.0), 24.0, 24.0)
    assert geotiff(VALUES, ground, "POD") == geotiff(VALUES.copy(), ground, "POD")
