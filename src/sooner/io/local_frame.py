"""The metric frame of an area: a grid of square cells on a projection that is true where the area lies."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.io.georeference import Georeference
from sooner.io.rasters import MAX_CELLS

__all__ = ["LocalFrame", "centred_on", "projection"]

WIDEST_M = 100_000.0
_STEP = 0.01  # degrees, about a kilometre: longer edges get places between, as straight lines bend in a projection
_MOST_BETWEEN = 20_000


def centred_on(lat: float, lon: float) -> str:
    """A transverse Mercator projection with this place in its middle, where its scale is one.

    Metres of it are too long by x^2 / (2 R^2) at x metres east or west of the middle: 3 parts in 100,000 at 50 km.

    >>> centred_on(46.1234567, 11.2)
    '+proj=tmerc +lat_0=46.123457 +lon_0=11.2 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m'
    """
    return (
        f"+proj=tmerc +lat_0={round(lat, 6):.12g} +lon_0={round(lon, 6):.12g} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m"
    )


def projection(name: str) -> str:
    """A projection by its number with EPSG, checked.

    Raises
    ------
    InvalidProblemError     not EPSG and a number, unknown, or not in metres or feet

    Examples
    --------
    >>> projection("epsg:32632")
    'EPSG:32632'
    """
    from rasterio import Env
    from rasterio.crs import CRS
    from rasterio.errors import CRSError

    expected = "expected one in metres by its number, such as 'EPSG:32632'"
    number = name.upper().removeprefix("EPSG:")
    if not (name.upper().startswith("EPSG:") and number.isascii() and number.isdigit() and len(number) <= 6):
        raise InvalidProblemError(f"{name!r} came; {expected}")
    try:
        with Env():  # which keeps what GDAL says off the terminal
            crs = CRS.from_epsg(int(number))
    except CRSError:
        raise InvalidProblemError(f"{name!r} came, which nobody knows; {expected}") from None
    if not crs.is_projected:
        raise InvalidProblemError(f"{name!r} came, which is measured in degrees; {expected}")
    return f"EPSG:{int(number)}"


@dataclass(frozen=True)
class LocalFrame:
    """A grid on the globe, and metres east and north of its south-west cell's centre.

    Parameters
    ----------
    ground : Georeference       of the grid's cells
    shape : (int, int)          rows and columns

    Examples
    --------
    >>> frame = LocalFrame.around(shapely.box(11.20, 46.10, 11.21, 46.11), cell_m=20.0)
    >>> frame.shape
    (58, 42)
    >>> frame.metres([[46.10, 11.20]]).round(1)
    array([[23.4, 14.2]])
    """

    ground: Georeference
    shape: tuple[int, int]

    @classmethod
    def around(cls, geometry: Any, cell_m: float, border_m: float | None = None, crs: str | None = None) -> LocalFrame:
        """The frame of an area.

        Parameters
        ----------
        geometry : shapely geometry     longitude and latitude
        cell_m : float
        border_m : float or None        ground around the area that the grid holds too; None for one cell
        crs : str or None               as `projection` gives it; None for one centred on the area

        Raises
        ------
        InvalidProblemError     wider than 100 km without a projection of its own, too many cells, or out of the
                                projection's reach
        """
        border_m = cell_m if border_m is None else border_m
        west, south, east, north = geometry.bounds
        own = crs or centred_on((south + north) / 2.0, (west + east) / 2.0)
        unit_m = _unit_m(own)
        moved = _moved(geometry, Georeference(own, (0.0, 0.0), 1.0, unit_m))
        x0, y0, x1, y1 = (float(value) * unit_m for value in moved.bounds)
        if crs is None and max(x1 - x0, y1 - y0) > WIDEST_M:
            came = f"an area of {(x1 - x0) / 1000:.0f} km by {(y1 - y0) / 1000:.0f} km came"
            expected = "expected at most 100 km each way: cut it to what is searched, or give frame = 'EPSG:...'"
            raise InvalidProblemError(f"{came}; {expected}")
        col, row = floor((x0 - border_m) / cell_m), ceil((y1 + border_m) / cell_m)
        cols, rows = ceil((x1 + border_m) / cell_m) - col, row - floor((y0 - border_m) / cell_m)
        if rows * cols > MAX_CELLS:
            least = ((x1 - x0 + 2 * border_m) * (y1 - y0 + 2 * border_m) / MAX_CELLS) ** 0.5
            came = f"{rows:,} x {cols:,} cells of {cell_m:g} m came"
            raise InvalidProblemError(f"{came}; expected at most {MAX_CELLS:,}: cell_m of at least {least:.2g}")
        corner = (col * cell_m / unit_m, row * cell_m / unit_m)
        return cls(Georeference(own, corner, cell_m / unit_m, cell_m), (rows, cols))

    def metres(self, places: ArrayLike) -> NDArray[np.float64]:
        """(n, 2) float: metres east and north of latitudes and longitudes (n, 2)."""
        rows, cols = self.ground.cells(places).T
        return np.column_stack([cols, self.shape[0] - 1 - rows]) * self.ground.cell_m

    def places(self, metres: ArrayLike) -> NDArray[np.float64]:
        """(n, 2) float: latitudes and longitudes of metres east and north (n, 2); undoes `metres`."""
        east, north = np.asarray(metres, np.float64).reshape(-1, 2).T / self.ground.cell_m
        return self.ground.places(np.column_stack([self.shape[0] - 1 - north, east]))

    def moved(self, geometry: Any) -> Any:
        """A geometry in longitude and latitude, in metres east and north; long edges bend as they should."""
        return _moved(geometry, self)

    @property
    def scale_error(self) -> float:
        """The largest share by which a metre of the frame differs from one on the ground."""
        height, width = self.shape
        spots = [(row, col) for row in (0, height // 2, height - 1) for col in (0, width // 2, width - 1)]
        return max(abs(self.ground.scale_at(*spot) - 1.0) for spot in spots)


def _unit_m(crs: str) -> float:
    from rasterio.crs import CRS

    return float(CRS.from_string(crs).linear_units_factor[1])


def _moved(geometry: Any, into: LocalFrame | Georeference) -> Any:
    length = float(geometry.length)
    if length > 0:
        geometry = shapely.segmentize(geometry, max(_STEP, length / _MOST_BETWEEN))

    def metres(places: NDArray[np.float64]) -> NDArray[np.float64]:
        if isinstance(into, LocalFrame):
            return into.metres(places[:, ::-1])
        rows, cols = into.cells(places[:, ::-1]).T
        return np.column_stack([cols + 0.5, -(rows + 0.5)])

    return shapely.transform(geometry, metres)
