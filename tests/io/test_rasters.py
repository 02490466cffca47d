import os

import numpy as np
import pytest

from sooner.errors import DataFormatError
from sooner.io import MAX_CELLS, raster_csv, read_raster

pytestmark = pytest.mark.filterwarnings("ignore:Use `@` matmul:PendingDeprecationWarning")  # rasterio's own


def refusal(path, **kwargs) -> str:
    with pytest.raises(DataFormatError) as raised:
        read_raster(path, **kwargs)
    assert all(fault.file == str(path) for fault in raised.value.faults)
    return str(raised.value)


def geotiff(path, values, *, crs="EPSG:32632", transform=None, **profile):
    import rasterio
    from rasterio.transform import from_origin

    values = np.atleast_3d(values.T).T if values.ndim == 2 else values
    settings = {"driver": "GTiff", "height": values.shape[1], "width": values.shape[2], "count": values.shape[0]}
    georeference = {"crs": crs, "transform": transform or from_origin(500_000, 5_100_000, 20, 20)} if crs else {}
    with rasterio.open(path, "w", dtype=values.dtype, **settings, **georeference, **profile) as target:
        target.write(values)
    return path


def test_csv_is_read_north_first(tmp_path):
    path = tmp_path / "map.csv"
    path.write_bytes(b"\xef\xbb\xbf1, 2.5\r\n3e2,-4\r\n\r\n")
    np.testing.assert_array_equal(read_raster(path).values, [[1, 2.5], [300, -4]])


def test_what_is_written_as_csv_is_read_back(tmp_path):
    values = np.round(np.random.default_rng(0).random((5, 7)) * 100, 6)
    (tmp_path / "map.csv").write_bytes(raster_csv(values))
    np.testing.assert_array_equal(read_raster(tmp_path / "map.csv").values, values)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.uint8, np.int64, bool])
@pytest.mark.parametrize("order", ["C", "F"])
def test_npy_of_numbers_is_read(tmp_path, dtype, order):
    values = np.asarray(np.arange(6).reshape(2, 3) % 2, dtype, order=order)
    np.save(tmp_path / "map.npy", values)
    np.testing.assert_array_equal(read_raster(tmp_path / "map.npy").values, values)


def test_npy_with_pickles_is_refused_unopened(tmp_path):
    class Bomb:
        def __reduce__(self):
            return os.abort, ()

    np.save(tmp_path / "map.npy", np.array([[Bomb()]], dtype=object), allow_pickle=True)
    assert "type object" in refusal(tmp_path / "map.npy")


@pytest.mark.parametrize(
    "values", [np.zeros(3), np.zeros((2, 2, 2)), np.zeros((0, 3)), np.float64(1), np.array([["a"]])]
)
def test_npy_that_is_no_raster_is_refused(tmp_path, values):
    np.save(tmp_path / "map.npy", values)
    refusal(tmp_path / "map.npy")


@pytest.mark.parametrize("content", [b"", b"\x93NUMPY", b"\x93NUMPY\x01\x00\x10\x00{'descr': '<f8'  ", b"hello"])
def test_npy_of_garbage_is_refused(tmp_path, content):
    (tmp_path / "map.npy").write_bytes(content)
    assert "not a .npy file" in refusal(tmp_path / "map.npy")


def test_npy_cut_short_is_refused(tmp_path):
    np.save(tmp_path / "map.npy", np.zeros((50, 50)))
    content = (tmp_path / "map.npy").read_bytes()
    (tmp_path / "map.npy").write_bytes(content[:-8])
    assert "ends before" in refusal(tmp_path / "map.npy")


def huge_npy(path, rows, cols):
    """A file that says it holds rows x cols, and is as long, but takes no room on the disk."""
    with path.open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (rows, cols)})
        file.truncate(file.tell() + rows * cols * 8)


def test_a_raster_of_1e8_cells_is_refused_before_it_is_loaded(tmp_path):
    huge_npy(tmp_path / "map.npy", 10_000, 10_000)
    told = refusal(tmp_path / "map.npy")
    assert "10,000 x 10,000 cells" in told
    assert "20.0 GB" in told
    assert "SOONER_MAX_CELLS" in told


def test_a_geotiff_of_1e8_cells_is_refused_before_it_is_loaded(tmp_path):
    import rasterio

    path = tmp_path / "map.tif"
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        height=10_000,
        width=10_000,
        count=1,
        dtype="uint8",
        sparse_ok=True,
        tiled=True,
        crs="EPSG:32632",
        transform=rasterio.transform.from_origin(0, 0, 20, 20),
    ):
        pass
    assert "10,000 x 10,000 cells" in refusal(path)


@pytest.mark.parametrize("line", [b"0,0,0,0\n", b"0,0,0,0,"])
def test_a_csv_of_too_many_cells_is_refused_while_counting(tmp_path, line):
    (tmp_path / "map.csv").write_bytes(line * 30)
    assert "more than 100 cells" in refusal(tmp_path / "map.csv", max_cells=100)


def test_the_limit_can_be_moved_by_the_environment(tmp_path, monkeypatch):
    np.save(tmp_path / "map.npy", np.ones((10, 10)))
    monkeypatch.setenv("SOONER_MAX_CELLS", "99")
    assert "at most 99 cells" in refusal(tmp_path / "map.npy")
    monkeypatch.setenv("SOONER_MAX_CELLS", "many")
    assert "'many'" in refusal(tmp_path / "map.npy")
    monkeypatch.delenv("SOONER_MAX_CELLS")
    assert MAX_CELLS == 20_000_000
    assert read_raster(tmp_path / "map.npy").values.sum() == 100


@pytest.mark.parametrize("suffix", [".csv", ".npy", ".tif"])
def test_what_cannot_be_opened_is_refused(tmp_path, suffix):
    assert "no such file" in refusal(tmp_path / f"none{suffix}")
    (tmp_path / f"folder{suffix}").mkdir()
    assert "a folder came" in refusal(tmp_path / f"folder{suffix}")
    os.mkfifo(tmp_path / f"pipe{suffix}")
    assert "not an ordinary file" in refusal(tmp_path / f"pipe{suffix}")
    assert "cannot be read" in refusal(tmp_path / f"nul\0{suffix}")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission_is_refused(tmp_path):
    (tmp_path / "map.csv").write_text("1\n")
    (tmp_path / "map.csv").chmod(0)
    assert "cannot be read" in refusal(tmp_path / "map.csv")


def test_geotiff_is_read_with_its_cell_size_and_place(tmp_path):
    values = np.arange(6, dtype=np.float32).reshape(2, 3)
    raster = read_raster(geotiff(tmp_path / "map.tif", values))
    np.testing.assert_array_equal(raster.values, values)
    assert (raster.cell_m, raster.corner, raster.crs) == (20.0, (500_000.0, 5_100_000.0), "EPSG:32632")


def test_geotiff_stored_south_first_is_turned_north_up(tmp_path):
    from rasterio.transform import Affine

    values = np.arange(6, dtype=np.float32).reshape(2, 3)
    path = geotiff(tmp_path / "map.tif", values, transform=Affine(20, 0, 500_000, 0, 20, 5_099_960))
    raster = read_raster(path)
    np.testing.assert_array_equal(raster.values, values[::-1])
    assert raster.corner == (500_000.0, 5_100_000.0)


def test_geotiff_in_feet_is_told_in_metres(tmp_path):
    raster = read_raster(geotiff(tmp_path / "map.tif", np.ones((2, 2), np.float32), crs="EPSG:2263"))
    assert raster.cell_m == pytest.approx(20 * 0.3048006)


def test_geotiff_marks_no_data(tmp_path):
    values = np.array([[1, -9999], [2, 3]], np.float32)
    raster = read_raster(geotiff(tmp_path / "map.tif", values, nodata=-9999))
    np.testing.assert_array_equal(raster.missing, [[False, True], [False, False]])


def test_geotiff_without_georeference_is_read(tmp_path):
    with pytest.warns(UserWarning, match="no geotransform"):
        path = geotiff(tmp_path / "map.tif", np.ones((2, 2), np.uint8), crs=None)
    assert read_raster(path).cell_m is None


def test_geotiff_in_degrees_is_refused(tmp_path):
    assert "degrees" in refusal(geotiff(tmp_path / "map.tif", np.ones((2, 2), np.uint8), crs="EPSG:4326"))


def test_geotiff_of_several_bands_is_refused(tmp_path):
    assert "3 bands" in refusal(geotiff(tmp_path / "map.tif", np.ones((3, 2, 2), np.uint8)))


def test_geotiff_of_oblong_or_turned_cells_is_refused(tmp_path):
    from rasterio.transform import Affine, from_origin

    ones = np.ones((2, 2), np.uint8)
    assert "20 x 30" in refusal(geotiff(tmp_path / "a.tif", ones, transform=from_origin(0, 0, 20, 30)))
    assert "rotated" in refusal(geotiff(tmp_path / "b.tif", ones, transform=Affine(20, 5, 0, 5, -20, 0)))


@pytest.mark.parametrize("content", [b"", b"II*\0", b"hello" * 100, bytes(range(256))])
def test_geotiff_of_garbage_is_refused(tmp_path, content):
    (tmp_path / "map.tif").write_bytes(content)
    assert "not a readable GeoTIFF" in refusal(tmp_path / "map.tif")


def test_geotiff_cut_short_is_refused(tmp_path):
    path = geotiff(tmp_path / "map.tif", np.ones((300, 300), np.float64))
    path.write_bytes(path.read_bytes()[:5000])
    refusal(path)
