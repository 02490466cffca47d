import numpy as np
import pytest
import rasterio
import shapely
from rasterio import Affine
from rasterio.warp import transform

from sooner.errors import DataFormatError
from sooner.io.local_frame import LocalFrame
from sooner.io.warped import extent, mass_on, mean_on, sampled_on

FRAME = LocalFrame.around(shapely.box(11.20, 46.10, 11.21, 46.11), 60.0)
pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")


def tiff(path, values, at, crs="EPSG:4326", **more):
    values = np.asarray(values)
    profile = {"driver": "GTiff", "height": values.shape[0], "width": values.shape[1], "count": 1}
    with rasterio.open(path, "w", **profile, dtype=values.dtype, crs=crs, transform=at, **more) as file:
        file.write(values, 1)
    return path


# source grids over the area: in degrees, turned, oblong, finer, coarser, in feet
def utm(side, turn=0.0, oblong=1.0, crs="EPSG:32632"):
    (x,), (y,) = transform("EPSG:4326", crs, [11.205], [46.105])
    turn = np.radians(turn)
    a, b, d, e = side * np.cos(turn), side * oblong * np.sin(turn), side * np.sin(turn), -side * oblong * np.cos(turn)
    return Affine(a, b, x - 16 * (a + b), d, e, y - 16 * (d + e)), crs


def moved(at, cols, rows):
    return at.a * cols + at.b * rows + at.c, at.d * cols + at.e * rows + at.f


SOURCES = {
    "degrees": (Affine(0.0005, 0, 11.197, 0, -0.0004, 46.112), "EPSG:4326"),
    "south first": (Affine(0.0005, 0, 11.197, 0, 0.0004, 46.098), "EPSG:4326"),
    "turned": utm(45.0, 30.0),
    "oblong": utm(30.0, oblong=1.7),
    "coarse": utm(250.0),
    "fine": utm(9.0),
    "another projection": utm(60.0, crs="EPSG:3035"),
    "feet": utm(150.0, crs="EPSG:2263"),
}


def brute_mass(values, at, crs):
    """Shapely's intersection of every source cell, moved corner by corner, with every target cell."""
    height, width = values.shape
    rows, cols = np.indices((height + 1, width + 1))
    lon, lat = transform(crs, "EPSG:4326", *moved(at, cols.ravel(), rows.ravel()))
    corners = FRAME.metres(np.column_stack([lat, lon])).reshape(height + 1, width + 1, 2)
    around = np.stack([corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]], axis=2)
    cells = shapely.polygons(around.reshape(-1, 4, 2))
    total, tree = np.zeros(FRAME.shape), shapely.STRtree(cells)
    for row, col in np.ndindex(FRAME.shape):
        x, y = col * 60.0, (FRAME.shape[0] - 1 - row) * 60.0
        target = shapely.box(x - 30, y - 30, x + 30, y + 30)
        near = tree.query(target)
        common = shapely.area(shapely.intersection(cells[near], target))
        total[row, col] = (values.ravel()[near] * common / shapely.area(cells[near])).sum()
    return total


@pytest.mark.parametrize("name", [name for name in SOURCES if name != "feet"])
def test_mass_goes_where_its_ground_lies(tmp_path, name):
    at, crs = SOURCES[name]
    values = np.random.default_rng(5).random((32, 32))
    path = tiff(tmp_path / "poc.tif", values, at, crs)
    found, expected = mass_on(path, FRAME.ground, FRAME.shape), brute_mass(values, at, crs)
    assert np.abs(found.values - expected).max() < 2e-6
    assert found.outside == pytest.approx(1 - expected.sum() / values.sum(), abs=1e-6)


def test_mass_that_lies_within_stays_to_the_last_bit(tmp_path):
    at, crs = utm(12.0, 17.0)
    values = np.random.default_rng(6).random((32, 32))
    found = mass_on(tiff(tmp_path / "poc.tif", values, at, crs), FRAME.ground, FRAME.shape)
    assert found.values.sum() == pytest.approx(values.sum(), rel=1e-12)
    assert found.outside < 1e-12


@pytest.mark.parametrize("name", ["degrees", "turned", "fine", "coarse"])
def test_means_of_something_even_are_even_and_within_its_range(tmp_path, name):
    at, crs = SOURCES[name]
    even = mean_on(tiff(tmp_path / "even.tif", np.full((32, 32), 0.7), at, crs), FRAME.ground, FRAME.shape).values
    assert np.nanmax(np.abs(even - 0.7)) < 1e-12
    values = np.random.default_rng(5).random((32, 32))
    found = mean_on(tiff(tmp_path / "any.tif", values, at, crs), FRAME.ground, FRAME.shape).values
    assert values.min() <= np.nanmin(found)
    assert np.nanmax(found) <= values.max()


@pytest.mark.parametrize("name", ["degrees", "south first", "turned", "oblong", "another projection"])
def test_samples_are_of_the_cell_below_each_centre(tmp_path, name):
    at, crs = SOURCES[name]
    classes = np.random.default_rng(5).integers(0, 9, (32, 32)).astype(np.uint8)
    found = sampled_on(tiff(tmp_path / "c.tif", classes, at, crs), FRAME.ground, FRAME.shape).values
    cells = np.column_stack(np.divmod(np.arange(found.size), found.shape[1]))
    lat, lon = FRAME.ground.places(cells).T
    x, y = transform("EPSG:4326", crs, lon, lat)
    cols, rows = moved(~at, np.array(x), np.array(y))
    inside = (rows >= 0) & (cols >= 0) & (rows < 32) & (cols < 32)
    clear = inside & (np.abs(rows - np.rint(rows)) > 1e-5) & (np.abs(cols - np.rint(cols)) > 1e-5)
    assert clear.sum() > 50
    expected = classes[rows[clear].astype(int), cols[clear].astype(int)]
    assert (found.ravel()[clear] == expected).all()
    assert np.isnan(found.ravel()[~inside]).all()


def test_a_plane_stays_a_plane_between_centres(tmp_path):
    at, crs = utm(70.0, 20.0)
    rows, cols = np.indices((32, 32))
    x, y = moved(at, cols + 0.5, rows + 0.5)
    found = sampled_on(tiff(tmp_path / "dem.tif", 0.3 * x - 0.2 * y, at, crs), FRAME.ground, FRAME.shape, smooth=True)
    cells = np.column_stack(np.divmod(np.arange(found.values.size), FRAME.shape[1]))
    lat, lon = FRAME.ground.places(cells).T
    x, y = map(np.array, transform("EPSG:4326", crs, lon, lat))
    assert np.nanmax(np.abs(found.values.ravel() - (0.3 * x - 0.2 * y))) < 1e-4
    assert not np.isnan(found.values).any()


def test_no_data_is_no_mass_and_no_sample(tmp_path):
    at, crs = utm(60.0)
    values = np.ones((32, 32))
    values[:16] = -9999
    path = tiff(tmp_path / "a.tif", values, at, crs, nodata=-9999)
    assert np.isnan(sampled_on(path, FRAME.ground, FRAME.shape, smooth=True).values).any()
    assert mass_on(path, FRAME.ground, FRAME.shape).values.min() == 0.0


def test_only_the_window_over_the_area_is_read(tmp_path):
    path = tmp_path / "country.tif"
    profile = {"driver": "GTiff", "height": 40_000, "width": 40_000, "count": 1, "dtype": "float32"}
    at = Affine(0.0001, 0, 9.0, 0, -0.0001, 48.0)
    with rasterio.open(path, "w", **profile, crs="EPSG:4326", transform=at, tiled=True, sparse_ok=True):
        pass
    assert (sampled_on(path, FRAME.ground, FRAME.shape, smooth=True).values == 0.0).all()


def test_an_extent_is_told_in_degrees_and_metres(tmp_path):
    at, crs = utm(50.0, 45.0)
    (west, south, east, north), cell_m, name = extent(tiff(tmp_path / "a.tif", np.ones((32, 32)), at, crs))
    assert west < 11.2 < 11.21 < east
    assert south < 46.105 < north
    assert cell_m == pytest.approx(50.0, rel=1e-3)
    assert name == crs


BAD = {
    "no projection": ({"crs": None}, "without a coordinate reference system"),
    "elsewhere": ({"at": Affine(0.0005, 0, 21.0, 0, -0.0004, 46.112)}, "elsewhere"),
    "negative": ({"values": np.full((32, 32), -1.0)}, "negative"),
    "zero": ({"values": np.zeros((32, 32))}, "zero"),
    "infinite": ({"values": np.full((32, 32), np.inf)}, "infinite"),
    "complex": ({"values": np.ones((32, 32), np.complex64)}, "complex"),
}


@pytest.mark.parametrize("name", BAD)
@pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
def test_rasters_that_cannot_be_laid_over_the_area_are_refused(tmp_path, name):
    given, words = BAD[name]
    at, crs = SOURCES["degrees"]
    path = tiff(tmp_path / "a.tif", **({"values": np.ones((32, 32)), "at": at, "crs": crs} | given))
    with pytest.raises(DataFormatError, match=words):
        mass_on(path, FRAME.ground, FRAME.shape)


@pytest.mark.parametrize("content", [b"", b"II*\0", b"<VRTDataset/>"])
def test_garbage_is_refused(tmp_path, content):
    (tmp_path / "a.tif").write_bytes(content)
    with pytest.raises(DataFormatError, match=r"a\.tif"):
        mass_on(tmp_path / "a.tif", FRAME.ground, FRAME.shape)
    with pytest.raises(DataFormatError, match="suffix"):
        sampled_on(tmp_path / "a.csv", FRAME.ground, FRAME.shape)
