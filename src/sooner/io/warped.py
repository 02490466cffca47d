"""Rasters of any projection, brought to the cells of another grid: in degrees, turned, oblong, coarse or fine."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.io.georeference import Georeference, ground_m
from sooner.io.rasters import MAX_CELLS
from sooner.io.reading import opened

__all__ = [
    "WITHIN",
    "Warped",
    "extent",
    "is_within",
    "largest",
    "mass_on",
    "mean_on",
    "sampled_on",
    "square_and_upright",
]

Floats = NDArray[np.float64]

NODES = 48  # along each side of a grid, where its places are worked out; between them by cubic splines
WITHIN = {"SOONER_MASS": "within the search area"}
"""What a GeoTIFF of probability says of itself whose cells on the border hold only what lies within."""
_EXPECTED = "expected a GeoTIFF with one band, a projection and its place in it"


@dataclass(frozen=True, eq=False)
class Warped:
    """What a raster says of the cells of a grid.

    Parameters
    ----------
    values : (H, W) float       NaN where the raster says nothing
    outside : float             share of a raster's mass that lies beyond the grid; 0 where it is no mass
    """

    values: Floats
    outside: float = 0.0


@dataclass(frozen=True, eq=False)
class _Source:
    """An open raster: `at` takes columns and rows of corners to map coordinates."""

    path: Path
    file: Any
    crs: str
    at: Any

    @property
    def shape(self) -> tuple[int, int]:
        return self.file.height, self.file.width

    def read(self, rows: slice, cols: slice) -> Floats:
        """(h, w) float: a window, NaN where there is no data."""
        if (rows.stop - rows.start) * (cols.stop - cols.start) > MAX_CELLS:
            came = f"{rows.stop - rows.start:,} x {cols.stop - cols.start:,} cells over the search area came"
            told = f"expected at most {MAX_CELLS:,}: coarsen the raster"
            raise DataFormatError(Fault(str(self.path), "", came, told))
        window = ((rows.start, rows.stop), (cols.start, cols.stop))
        band = self.file.read(1, masked=True, window=window)
        values = np.array(np.ma.getdata(band), np.float64)
        values[np.ma.getmaskarray(band)] = np.nan
        return values


@contextmanager
def _source(path: Path) -> Iterator[_Source]:
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    if path.suffix.lower() not in (".tif", ".tiff"):
        came = f"the suffix {path.suffix!r} came, and rasters without a place on the globe cannot be laid over an area"
        raise DataFormatError(Fault(str(path), "", came, _EXPECTED))
    with opened(path):
        pass
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            warnings.simplefilter("ignore", PendingDeprecationWarning)  # within rasterio: it multiplies matrices with *
            with rasterio.open(path, driver="GTiff") as file:
                yield _checked(path, file)
    except RasterioError as error:
        came = f"something that is not a readable GeoTIFF came ({error})"[:200]
        raise DataFormatError(Fault(str(path), "", came, _EXPECTED)) from None


def _checked(path: Path, file: Any) -> _Source:
    def refuse(came: str, expected: str = _EXPECTED) -> DataFormatError:
        return DataFormatError(Fault(str(path), "", came, expected))

    if file.count != 1:
        raise refuse(f"{file.count} bands came")
    if np.dtype(file.dtypes[0]).kind not in "biuf":
        raise refuse(f"values of type {file.dtypes[0]} came")
    if file.crs is None:
        raise refuse("a raster without a coordinate reference system came", "expected one that says its projection")
    at = file.transform
    if at.is_identity or not np.isfinite(list(at)[:6]).all() or at.determinant == 0:
        raise refuse("a raster without a place in its projection came")
    if not (file.crs.is_projected or file.crs.is_geographic):
        raise refuse(f"a projection that is none came ({file.crs.to_string()})"[:200])
    return _Source(path, file, file.crs.to_wkt(), at)


def is_within(path: Path) -> bool:
    """Whether a raster says that its mass lies within the search area already, as a debrief's does: `WITHIN`."""
    with _source(path) as source:
        tags: dict[str, str] = source.file.tags()
    return all(tags.get(key) == value for key, value in WITHIN.items())


def square_and_upright(path: Path) -> bool:
    """Whether a raster's cells can be a grid as they are: a projection in metres or feet, square cells, north up."""
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    with opened(path):
        pass
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with rasterio.open(path, driver="GTiff") as file:
                at, crs = file.transform, file.crs
    except RasterioError:
        return True  # told where it is read
    if crs is None or at.is_identity:
        return True
    oblong = abs(at.a - abs(at.e)) > 1e-3 * abs(at.a)
    return bool(crs.is_projected and not at.b and not at.d and at.a > 0 and not oblong)


def extent(path: Path) -> tuple[tuple[float, float, float, float], float, str]:
    """Where a raster lies: west, south, east, north in degrees; metres of a cell's side; and its projection.

    Raises
    ------
    DataFormatError         unreadable, without projection, or beyond what it reaches
    """
    with _source(path) as source:
        height, width = source.shape
        turns = np.linspace(0.0, 1.0, 9)
        x, y = np.meshgrid(turns * width, turns * height)
        lat, lon = _world(source, x.ravel(), y.ravel()).T
        if not (np.abs(lat) < 89.9).all() or np.ptp(lon) > 180.0:
            came = f"latitudes {lat.min():g} to {lat.max():g}, longitudes {lon.min():g} to {lon.max():g} came"
            raise DataFormatError(Fault(str(path), "", came, "expected one off the poles and the date line"))
        middle = np.array([width, height]) / 2 + [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
        there = _world(source, *middle.T)
        across, down = ground_m(there[[0, 1]])[0], ground_m(there[[0, 2]])[0]
        name = source.file.crs.to_string()
        return (lon.min(), lat.min(), lon.max(), lat.max()), float(np.sqrt(across * down)), name


def _world(source: _Source, cols: Floats, rows: Floats) -> Floats:
    """(n, 2) float: latitude and longitude of columns and rows of corners."""
    x, y = _map(source.at, cols, rows)
    ground = Georeference(source.crs, (0.0, 0.0), 1.0, 1.0)
    try:
        return ground.places(np.column_stack([-y - 0.5, x - 0.5]))
    except InvalidProblemError as error:
        raise DataFormatError(Fault(str(source.path), "", str(error)[:200], _EXPECTED)) from None


def _map(at: Any, cols: Floats, rows: Floats) -> tuple[Floats, Floats]:
    return at.a * cols + at.b * rows + at.c, at.d * cols + at.e * rows + at.f


# ---------------------------------------------------------------- what lies where


def _seen(source: _Source, ground: Georeference, shape: tuple[int, int], rows: Floats, cols: Floats) -> Floats:
    """(2, len(rows), len(cols)) float: columns and rows of the source's corners, at corners of the target's cells.

    Places are worked out on a coarse lattice, and between by bicubic splines: projections are smooth.
    """
    lattice_rows = np.unique(np.linspace(0.0, shape[0], NODES))
    lattice_cols = np.unique(np.linspace(0.0, shape[1], NODES))
    r, c = np.meshgrid(lattice_rows, lattice_cols, indexing="ij")
    west, top = ground.corner
    x, y = _between(ground.crs, source.crs, west + c.ravel() * ground.side, top - r.ravel() * ground.side)
    back = ~source.at
    found = np.stack(_map(back, x, y)).reshape(2, *r.shape)
    return np.stack([_splined(lattice_rows, lattice_cols, each, rows, cols) for each in found])


def _corners(source: _Source, ground: Georeference, rows: slice, cols: slice) -> Floats:
    """(2, h + 1, w + 1) float: columns and rows of the target's corners, at corners of a window of the source."""
    lattice_rows = np.unique(np.linspace(rows.start, rows.stop, NODES))
    lattice_cols = np.unique(np.linspace(cols.start, cols.stop, NODES))
    r, c = np.meshgrid(lattice_rows, lattice_cols, indexing="ij")
    x, y = _between(source.crs, ground.crs, *_map(source.at, c.ravel(), r.ravel()))
    west, top = ground.corner
    found = np.stack([(x - west) / ground.side, (top - y) / ground.side]).reshape(2, *r.shape)
    wanted = np.arange(rows.start, rows.stop + 1.0), np.arange(cols.start, cols.stop + 1.0)
    return np.stack([_splined(lattice_rows, lattice_cols, each, *wanted) for each in found])


def _splined(lattice_rows: Floats, lattice_cols: Floats, known: Floats, rows: Floats, cols: Floats) -> Floats:
    from scipy.interpolate import RectBivariateSpline

    return np.asarray(RectBivariateSpline(lattice_rows, lattice_cols, known, kx=3, ky=3, s=0)(rows, cols))


def _between(before: str, after: str, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    if before == after:
        return x, y
    places = Georeference(before, (0.0, 0.0), 1.0, 1.0).places(np.column_stack([-y - 0.5, x - 0.5]))
    rows, cols = Georeference(after, (0.0, 0.0), 1.0, 1.0).cells(places).T
    return cols + 0.5, -(rows + 0.5)


def _window(source: _Source, ground: Georeference, shape: tuple[int, int]) -> tuple[slice, slice] | None:
    """The source's rows and columns that lie over the target, and two more each way; None where none does."""
    rows, cols = np.linspace(0.0, shape[0], 2 * NODES), np.linspace(0.0, shape[1], 2 * NODES)
    at_cols, at_rows = _seen(source, ground, shape, rows, cols)
    slices = []
    for found, count in zip((at_rows, at_cols), source.shape, strict=True):
        first, last = int(np.floor(found.min())) - 2, int(np.ceil(found.max())) + 2
        if last - 2 <= 0 or first + 2 >= count:
            return None
        slices.append(slice(max(first, 0), min(last, count)))
    return slices[0], slices[1]


@contextmanager
def _over(path: Path, ground: Georeference, shape: tuple[int, int]) -> Iterator[tuple[_Source, slice, slice]]:
    with _source(path) as source:
        try:
            window = _window(source, ground, shape)
        except InvalidProblemError as error:
            raise DataFormatError(Fault(str(path), "", str(error)[:300], _EXPECTED)) from None
        if window is None:
            expected = "expected one that covers the search area"
            raise DataFormatError(Fault(str(path), "", "a raster that lies elsewhere came", expected))
        yield source, *window


# ---------------------------------------------------------------- the three ways


def mass_on(path: Path, ground: Georeference, shape: tuple[int, int]) -> Warped:
    """A raster of mass (weights, POC) on the cells of a grid: each cell's mass goes where its ground lies.

    m_j = sum_i w_i |i and j| / |i|,   |i and j| the area that source cell i and target cell j have in common

    so that what lies on the grid totals what the raster has there.

    Parameters
    ----------
    path : Path                 a GeoTIFF of any projection
    ground : Georeference       of the grid
    shape : (int, int)          its rows and columns

    Returns
    -------
    Warped                      mass, 0 where the raster says nothing, and the share of it that lies elsewhere

    Raises
    ------
    DataFormatError             unreadable, no projection, elsewhere, negative or infinite weights, or all zero
    """
    with _over(path, ground, shape) as (source, rows, cols):
        total = _total(source)
        totals, _ = _spread(source, ground, shape, rows, cols)
    return Warped(totals, max(0.0, 1.0 - float(totals.sum()) / total))


def mean_on(path: Path, ground: Georeference, shape: tuple[int, int], whether: bool = False) -> Warped:
    """A raster of something even within a cell (difficulty, glimpse) on a grid: its mean over each cell's ground.

    Parameters
    ----------
    whether : bool          of whether the raster is not zero: the share of each cell where it is not

    Returns
    -------
    Warped                  NaN where the raster says nothing
    """
    with _over(path, ground, shape) as (source, rows, cols):
        weighted, areas = _spread(source, ground, shape, rows, cols, by_area=True, whether=whether)
    with np.errstate(invalid="ignore", divide="ignore"):
        return Warped(np.where(areas > 1e-9, weighted / areas, np.nan))


def _spread(
    source: _Source,
    ground: Georeference,
    shape: tuple[int, int],
    rows: slice,
    cols: slice,
    by_area: bool = False,
    whether: bool = False,
) -> tuple[Floats, Floats]:
    from sooner.io._warp_kernels import spread

    values = source.read(rows, cols)
    x, y = _corners(source, ground, rows, cols)
    if whether:
        values = np.where(np.isnan(values), np.nan, values != 0)
    if by_area:
        values = values * _areas(x, y)
    totals, areas = np.zeros(shape), np.zeros(shape)
    spread(np.ascontiguousarray(x), np.ascontiguousarray(y), values, *shape, totals, areas)
    return totals, areas


def _areas(x: Floats, y: Floats) -> Floats:
    """(h, w) float: of four-cornered cells, by their diagonals."""
    one = (x[1:, 1:] - x[:-1, :-1]) * (y[1:, :-1] - y[:-1, 1:])
    other = (x[1:, :-1] - x[:-1, 1:]) * (y[1:, 1:] - y[:-1, :-1])
    return np.asarray(np.abs(one - other) / 2.0)


def _strips(source: _Source) -> Iterator[Floats]:
    """A raster from north to south, some rows at a time."""
    height, width = source.shape
    at_once = max(1, 4_000_000 // width)
    for first in range(0, height, at_once):
        yield source.read(slice(first, min(first + at_once, height)), slice(0, width))


def largest(path: Path) -> float:
    """The largest number of a raster, wherever it lies; 0 where it holds none."""
    with _source(path) as source:
        return float(max((np.nanmax(values) for values in _strips(source) if np.isfinite(values).any()), default=0.0))


def _total(source: _Source) -> float:
    """All mass of a raster."""
    total = 0.0
    for values in _strips(source):
        if np.isinf(values).any() or (values < 0).any():
            came, expected = "a weight that is negative or infinite came", "expected finite numbers of at least 0"
            raise DataFormatError(Fault(str(source.path), "", came, expected))
        total += float(np.nansum(values))
    if not total > 0:
        expected = "expected some cell where the person may be"
        raise DataFormatError(Fault(str(source.path), "", "every weight is zero", expected))
    return total


def sampled_on(path: Path, ground: Georeference, shape: tuple[int, int], smooth: bool = False) -> Warped:
    """A raster at the centres of a grid's cells: of the cell there (classes), or between four centres (elevation).

    Parameters
    ----------
    smooth : bool           bilinear between the centres of the source's cells, where all four say something

    Returns
    -------
    Warped                  NaN where the raster says nothing
    """
    with _over(path, ground, shape) as (source, rows, cols):
        values = source.read(rows, cols)
        at_cols, at_rows = _seen(source, ground, shape, np.arange(0.5, shape[0]), np.arange(0.5, shape[1]))
    at_cols, at_rows = at_cols - cols.start, at_rows - rows.start
    if not smooth:
        row, col = np.floor(at_rows).astype(int), np.floor(at_cols).astype(int)
        inside = (row >= 0) & (row < values.shape[0]) & (col >= 0) & (col < values.shape[1])
        clipped = values[row.clip(0, values.shape[0] - 1), col.clip(0, values.shape[1] - 1)]
        return Warped(np.where(inside, clipped, np.nan))
    return Warped(_bilinear(values, at_rows - 0.5, at_cols - 0.5))


def _bilinear(values: Floats, rows: Floats, cols: Floats) -> Floats:
    """Between centres; half a cell beyond the outer ones as these."""
    height, width = values.shape
    inside = (rows >= -0.5) & (rows <= height - 0.5) & (cols >= -0.5) & (cols <= width - 0.5)
    rows, cols = rows.clip(0, height - 1), cols.clip(0, width - 1)
    row, col = np.minimum(rows.astype(int), max(height - 2, 0)), np.minimum(cols.astype(int), max(width - 2, 0))
    down, right = rows - row, cols - col
    below, beside = np.minimum(row + 1, height - 1), np.minimum(col + 1, width - 1)
    upper = values[row, col] * (1 - right) + values[row, beside] * right
    lower = values[below, col] * (1 - right) + values[below, beside] * right
    return np.where(inside, upper * (1 - down) + lower * down, np.nan)
