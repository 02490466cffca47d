"""Georeference: which cell of a raster a place on the globe lies in."""

from __future__ import annotations

from math import floor, isfinite

from sooner.errors import InvalidProblemError
from sooner.io.rasters import Raster

__all__ = ["cell_at"]

WORLD = "EPSG:4326"  # latitude and longitude as satellites tell them


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
    if raster.corner is None or not raster.cell_m or not raster.crs:
        raise InvalidProblemError("a latitude and longitude came, and a map without a georeference")
    from rasterio.crs import CRS
    from rasterio.warp import transform

    crs = CRS.from_string(raster.crs)
    side = raster.cell_m / crs.linear_units_factor[1]  # in the projection's own unit
    try:
        (east,), (north,) = transform(CRS.from_string(WORLD), crs, [lon], [lat])
    except Exception as error:  # GDAL's own errors come as they are, of no class that is public
        raise InvalidProblemError(f"[{lat}, {lon}] came, which {raster.crs} does not reach ({error})") from None
    if not (isfinite(east) and isfinite(north)):
        raise InvalidProblemError(f"[{lat}, {lon}] came, which {raster.crs} does not reach")
    west, top = raster.corner
    return floor((top - north) / side), floor((east - west) / side)
