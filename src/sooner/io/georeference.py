"""Georeference: where on the globe the cells of a raster lie, and which cell a place on the globe lies in."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError
from sooner.io.rasters import Raster

__all__ = ["Georeference", "cell_at", "ground_m"]

WORLD = "EPSG:4326"  # latitude and longitude as satellites tell them
EQUATOR_M, FLATTENING = 6_378_137.0, 1 / 298.257223563  # the ellipsoid of WGS 84


@dataclass(frozen=True)
class Georeference:
    """Where the cells of a raster lie: rows go south from the corner, columns east, both in the projection.

    Parameters
    ----------
    crs : str                   the projection
    corner : (float, float)     map coordinates, east and north, of the north-west corner
    side : float                of a cell, in the projection's own unit
    cell_m : float              of a cell, in metres of the projection
    """

    crs: str
    corner: tuple[float, float]
    side: float
    cell_m: float

    @classmethod
    def of(cls, raster: Raster) -> Georeference:
        """That of a raster; InvalidProblemError if it has none."""
        if raster.corner is None or not raster.cell_m or not raster.crs:
            raise InvalidProblemError("a latitude and longitude came, and a map without a georeference")
        from rasterio.crs import CRS

        unit_m = float(CRS.from_string(raster.crs).linear_units_factor[1])
        return cls(raster.crs, raster.corner, raster.cell_m / unit_m, raster.cell_m)

    def places(self, cells: ArrayLike) -> NDArray[np.float64]:
        """Latitude and longitude of places on the raster.

        Parameters
        ----------
        cells : (n, 2) float    rows and columns, as fractions; whole at the centres of cells

        Returns
        -------
        (n, 2) float            degrees north and east, of WGS 84

        Raises
        ------
        InvalidProblemError     where the projection does not reach a place

        Examples
        --------
        >>> ground = Georeference("EPSG:32632", (500_000.0, 5_100_000.0), 20.0, 20.0)
        >>> ground.places([[0, 0], [-0.5, -0.5]]).round(6)
        array([[46.053484,  9.000129],
               [46.053574,  9.      ]])
        """
        rows, cols = np.asarray(cells, np.float64).reshape(-1, 2).T
        west, top = self.corner
        lon, lat = self._transformed(self.crs, WORLD, west + (cols + 0.5) * self.side, top - (rows + 0.5) * self.side)
        return np.column_stack([lat, lon])

    def cells(self, places: ArrayLike) -> NDArray[np.float64]:
        """(n, 2) float: rows and columns, as fractions, of latitudes and longitudes (n, 2); undoes `places`."""
        lat, lon = np.asarray(places, np.float64).reshape(-1, 2).T
        east, north = self._transformed(WORLD, self.crs, lon, lat)
        west, top = self.corner
        return np.column_stack([(top - north) / self.side - 0.5, (east - west) / self.side - 0.5])

    def cell_at(self, lat: float, lon: float) -> tuple[int, int]:
        """The cell whose ground holds a place; see the function of that name."""
        row, col = self.cells([[lat, lon]])[0]
        return floor(row + 0.5), floor(col + 0.5)

    def scale_at(self, row: float, col: float) -> float:
        """True metres on the ground for each metre of the projection, at a cell.

        >>> round(Georeference("EPSG:3857", (1_000_000.0, 5_800_000.0), 20.0, 20.0).scale_at(0, 0), 2)
        0.69
        """
        corners = self.places([[row - 0.5, col - 0.5], [row - 0.5, col + 0.5], [row + 0.5, col + 0.5]])
        across_m, down_m = ground_m(corners)
        return float(np.sqrt(across_m * down_m) / self.cell_m)

    def _transformed(
        self, before: str, after: str, east: NDArray[np.float64], north: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        from rasterio.crs import CRS
        from rasterio.warp import transform

        try:
            found = transform(CRS.from_string(before), CRS.from_string(after), east.tolist(), north.tolist())
        except Exception as error:  # GDAL's own errors come as they are, of no class that is public
            raise InvalidProblemError(self._beyond(before, east, north, 0, f" ({error})")) from None
        x, y = np.asarray(found[0], np.float64), np.asarray(found[1], np.float64)
        broken = ~(np.isfinite(x) & np.isfinite(y))
        if broken.any():
            raise InvalidProblemError(self._beyond(before, east, north, int(np.argmax(broken))))
        return x, y

    def _beyond(self, before: str, east: NDArray[Any], north: NDArray[Any], which: int, why: str = "") -> str:
        if before == WORLD:
            return f"[{north[which]}, {east[which]}] came, which {self.crs} does not reach{why}"
        return f"{east[which]:g} east, {north[which]:g} north came, which {self.crs} does not reach{why}"


def cell_at(raster: Raster, lat: float, lon: float) -> tuple[int, int]:
    """The cell, (row, col), whose ground holds a place; beyond the raster, the cell that it would have there.

    Parameters
    ----------
    raster : Raster        with its place on the globe
    lat, lon : float       degrees north and east, of WGS 84

    Raises
    ------
    InvalidProblemError     if the raster has no georeference, or its projection does not reach so far
    """
    return Georeference.of(raster).cell_at(lat, lon)


def ground_m(places: ArrayLike) -> NDArray[np.float64]:
    """(n - 1,) float: metres over ground from each of these latitudes and longitudes (n, 2) to the next.

    d^2 = (M dlat)^2 + (N cos(lat) dlon)^2,   M and N the ellipsoid's radii of curvature half way

    For legs of a flight: to 10 km right to a millimetre at middle latitudes.

    Examples
    --------
    >>> ground_m([[46.0, 9.0], [46.001, 9.0], [46.001, 9.001]]).round(2)
    array([111.15,  77.46])
    """
    lat, lon = np.radians(np.asarray(places, np.float64).reshape(-1, 2)).T
    middle = (lat[1:] + lat[:-1]) / 2
    eccentricity = FLATTENING * (2.0 - FLATTENING)
    bend = 1.0 - eccentricity * np.sin(middle) ** 2
    across = EQUATOR_M / np.sqrt(bend)
    along = across * (1.0 - eccentricity) / bend
    return np.asarray(np.hypot(along * np.diff(lat), across * np.cos(middle) * np.diff(lon)))
