"""Rasters: a number per cell from .csv, .npy or GeoTIFF, refused with a reason where they cannot be used.

Sizes are checked before anything is loaded. What the numbers mean (weights, difficulty, obstacles) is the caller's.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import DataFormatError, Fault
from sooner.io.reading import lines_of, opened

__all__ = ["MAX_CELLS", "Raster", "raster_csv", "read_raster"]

MAX_CELLS = 20_000_000  # unless SOONER_MAX_CELLS says otherwise
BYTES_PER_CELL = 200  # what planning takes at its peak: layers, gains, neighbours, distances
_CHUNK = 1 << 20
_SUFFIXES = "a raster named .csv, .npy, .tif or .tiff"


@dataclass(frozen=True, eq=False)
class Raster:
    """Numbers over cells, row 0 north.

    Parameters
    ----------
    values : (H, W) float          may hold NaN where the file does; the caller decides
    missing : (H, W) bool          cells that a GeoTIFF marks as "no data"; None where there are none
    cell_m : float or None         metres between neighbouring cells, where the file is georeferenced
    corner : (float, float) or None  map coordinates of the north-west corner, where the file is georeferenced
    crs : str                      its coordinate reference system, "" where there is none
    """

    values: NDArray[np.float64]
    missing: NDArray[np.bool_] | None = None
    cell_m: float | None = None
    corner: tuple[float, float] | None = None
    crs: str = ""


def read_raster(path: Path, max_cells: int | None = None) -> Raster:
    """Read a raster by its suffix.

    Parameters
    ----------
    path : Path
    max_cells : int or None     largest raster that is loaded; None: `MAX_CELLS`, or what the environment variable
                                SOONER_MAX_CELLS says, and never more than the memory at hand can hold

    Raises
    ------
    DataFormatError             missing, unreadable, too large, ragged, or not a table of numbers
    """
    readers: dict[str, Callable[[Path, int], Raster]] = {
        ".csv": _read_csv,
        ".npy": _read_npy,
        ".tif": _read_geotiff,
        ".tiff": _read_geotiff,
    }
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise _refusal(path, "", f"the suffix {path.suffix!r} came", f"expected {_SUFFIXES}")
    with opened(path):
        pass
    return reader(path, _limit(path) if max_cells is None else max_cells)


def raster_csv(values: ArrayLike, decimals: int = 6) -> bytes:
    """A raster as CSV: one line per row, north first, and no needless digits.

    >>> raster_csv([[0.5, 1.0], [0.0, 2.25]])
    b'0.5,1\\n0,2.25\\n'
    """
    rows = np.round(np.asarray(values, np.float64), decimals)
    lines = (",".join(f"{value:.{decimals}f}".rstrip("0").rstrip(".") for value in row) for row in rows)
    return ("\n".join(lines) + "\n").encode()


def _refusal(path: Path, key: str, came: str, expected: str) -> DataFormatError:
    return DataFormatError(Fault(str(path), key, came, expected))


# ---------------------------------------------------------------- size


def _limit(path: Path) -> int:
    said = os.environ.get("SOONER_MAX_CELLS", "")
    if said and not (said.isascii() and said.isdigit() and int(said) > 0):
        raise _refusal(
            path, "", f"the environment variable SOONER_MAX_CELLS is {said!r}", "expected a whole number of at least 1"
        )
    return min(int(said) if said else MAX_CELLS, _memory() // BYTES_PER_CELL)


def _memory() -> int:
    """Bytes that are free to use, as far as the system tells."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable"))
    except (OSError, ValueError, IndexError, StopIteration):
        return 8 << 30


def _check_size(path: Path, cells: int, max_cells: int, shape: str = "") -> None:
    if cells <= max_cells:
        return
    came = f"a raster of {shape or f'more than {max_cells:,} cells'} came"
    need = f", which take about {cells * BYTES_PER_CELL / 1e9:.1f} GB to plan on" if shape else ""
    raise _refusal(
        path,
        "",
        came + need,
        f"expected at most {max_cells:,} cells here: coarsen the raster, cut it to the search area, "
        "or raise SOONER_MAX_CELLS on a machine with the memory",
    )


# ---------------------------------------------------------------- CSV


def _read_csv(path: Path, max_cells: int) -> Raster:
    with opened(path) as file:
        separators = 0
        while chunk := file.read(_CHUNK):
            separators += chunk.count(b",") + chunk.count(b"\n")
            _check_size(path, separators, max_cells)
        file.seek(0)
        data = file.read()
    lines = lines_of(path, data, "expected numbers separated by commas, one line per row")
    rows, faults = [], _Faults(path)
    width = lines[0][1].count(",") + 1
    for number, line in lines:
        fields = line.split(",")
        if len(fields) != width:
            faults.add(
                "ragged",
                f"line {number}",
                f"{len(fields)} values came",
                f"expected {width}, as in line {lines[0][0]}",
            )
            continue
        try:
            rows.append(np.array(fields, np.float64))
        except ValueError:
            column = next(c for c, field in enumerate(fields, start=1) if not _is_number(field))
            faults.add(
                "text", f"line {number}, value {column}", f"{_short(fields[column - 1])} came", "expected a number"
            )
    faults.raise_any()
    return Raster(np.array(rows))


class _Faults:
    """Faults of one file: the first of each kind in full, then how many more there are."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.kinds: dict[str, list[Fault]] = {}

    def add(self, kind: str, key: str, came: str, expected: str) -> None:
        self.kinds.setdefault(kind, []).append(Fault(str(self.path), key, came, expected))

    def raise_any(self) -> None:
        told = []
        for faults in self.kinds.values():
            first, more = faults[0], len(faults) - 1
            came = f"{first.came}{f' (and {more} more lines are wrong in the same way)' if more else ''}"
            told.append(Fault(first.file, first.key, came, first.expected))
        if told:
            raise DataFormatError(*told)


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _short(text: str, longest: int = 40) -> str:
    text = text.strip()
    return repr(text if len(text) <= longest else text[:longest] + "...")


# ---------------------------------------------------------------- NumPy


def _read_npy(path: Path, max_cells: int) -> Raster:
    expected = "expected a NumPy array of numbers with rows and columns, saved without pickles"
    with opened(path) as file:
        try:
            version = np.lib.format.read_magic(file)
            read_header: Any = np.lib.format.read_array_header_1_0
            if version != (1, 0):
                read_header = np.lib.format.read_array_header_2_0
            shape, _, dtype = read_header(file)
            begins = file.tell()
        except Exception as error:  # numpy parses the header as Python, and raises whatever that does
            came = f"something that is not a .npy file came ({_short(str(error), 80)})"
            raise _refusal(path, "", came, expected) from None
        if dtype.hasobject or dtype.kind not in "biuf":
            raise _refusal(path, "", f"values of type {dtype} came", expected)
        if len(shape) != 2 or 0 in shape:
            raise _refusal(path, "", f"an array of shape {shape} came", expected)
        cells = int(shape[0]) * int(shape[1])
        _check_size(path, cells, max_cells, f"{shape[0]:,} x {shape[1]:,} cells")
        if path.stat().st_size < begins + cells * dtype.itemsize:
            raise _refusal(path, "", "the file ends before its last value", expected)
        file.seek(0)
        try:
            values = np.load(file, allow_pickle=False)
        except (ValueError, EOFError, OSError) as error:
            raise _refusal(path, "", f"it cannot be read ({_short(str(error), 80)})", expected) from None
    return Raster(np.ascontiguousarray(values, np.float64))


# ---------------------------------------------------------------- GeoTIFF


def _read_geotiff(path: Path, max_cells: int) -> Raster:
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            warnings.simplefilter("ignore", PendingDeprecationWarning)  # within rasterio: it multiplies matrices with *
            with rasterio.open(path, driver="GTiff") as source:
                return _geotiff(path, source, max_cells)
    except RasterioError as error:
        came = f"something that is not a readable GeoTIFF came ({_short(str(error), 120)})"
        raise _refusal(path, "", came, "expected a GeoTIFF with one band") from None


def _geotiff(path: Path, source: Any, max_cells: int) -> Raster:
    shape = f"{source.height:,} x {source.width:,} cells"
    _check_size(path, source.height * source.width, max_cells, shape)
    if source.count != 1:
        raise _refusal(path, "", f"{source.count} bands came", "expected one band of numbers")
    if np.dtype(source.dtypes[0]).kind not in "biuf":
        raise _refusal(path, "", f"values of type {source.dtypes[0]} came", "expected one band of numbers")
    band = source.read(1, masked=True)
    values = np.ascontiguousarray(np.ma.getdata(band), np.float64)
    missing = np.ma.getmaskarray(band)
    transform = source.transform
    if source.crs is None or transform.is_identity:
        return Raster(values, missing if missing.any() else None)
    if transform.e > 0:  # stored with the south first
        values, missing = np.ascontiguousarray(values[::-1]), np.ascontiguousarray(missing[::-1])
    cell_m = _metres(path, source)
    north = max(transform.f, transform.f + transform.e * source.height)
    corner = (float(transform.c), float(north))
    return Raster(values, missing if missing.any() else None, cell_m, corner, source.crs.to_string())


def _metres(path: Path, source: Any) -> float:
    transform = source.transform
    if not source.crs.is_projected:
        raise _refusal(
            path,
            "",
            f"cells measured in degrees came ({source.crs.to_string()})",
            "expected a projection in metres, such as UTM: reproject the raster first",
        )
    if transform.b or transform.d or transform.a < 0:
        raise _refusal(path, "", "a rotated or mirrored raster came", "expected rows from north to south")
    if abs(transform.a - abs(transform.e)) > 1e-3 * abs(transform.a):
        raise _refusal(
            path,
            "",
            f"cells of {transform.a:g} x {abs(transform.e):g} came",
            "expected square cells: resample the raster",
        )
    return float(transform.a * source.crs.linear_units_factor[1])
