"""Reading a vector file by its suffix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.io.reading import bytes_of
from sooner.io.vectors.feature import Drawn, Feature, checked, refusal
from sooner.io.vectors.geojson import geojson
from sooner.io.vectors.geopackage import geopackage
from sooner.io.vectors.gpx import gpx
from sooner.io.vectors.kml import kml, kmz

__all__ = ["SUFFIXES", "read_features"]

SUFFIXES = (".geojson", ".json", ".gpkg", ".kml", ".kmz", ".gpx")
MOST_BYTES = 20_000_000
MOST_BYTES_OF_WKT = 100_000
LONGEST = 0.01  # degrees, a kilometre: longer edges get places between, as straight lines bend in other projections
MOST_BETWEEN = 20_000


def read_features(path: Path, layer: str | None = None) -> tuple[Feature, ...]:
    """Everything drawn in a file.

    Parameters
    ----------
    path : Path             .geojson, .json, .gpkg, .kml, .kmz or .gpx
    layer : str or None     of a GeoPackage, where it has several

    Returns
    -------
    tuple of Feature        in longitude and latitude of WGS 84, at least one

    Raises
    ------
    DataFormatError         missing, unreadable, too large, empty, hostile, no or an unknown projection, or places that
                            no map of ours shows: beyond 89.9 degrees, across the date line, not finite

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "launch.geojson"
    >>> _ = path.write_text('{"type": "Feature", "properties": {"title": "launch"}, '
    ...                     '"geometry": {"type": "Point", "coordinates": [11.2, 46.1]}}')
    >>> read_features(path)[0].geometry
    <POINT (11.2 46.1)>
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise refusal(path, "", f"the suffix {path.suffix!r} came", f"expected one of {', '.join(SUFFIXES)}")
    if suffix == ".gpkg":
        drawn, crs = geopackage(path, layer)
        return checked(path, _on_globe(path, drawn, crs))
    if layer is not None:
        raise refusal(path, "", f"layer {layer!r} was asked for", "expected it left out: only a .gpkg has layers")
    data = bytes_of(path, MOST_BYTES, f"{MOST_BYTES / 1e6:g} MB", "expected a file of the search area")
    if suffix in (".geojson", ".json"):
        return checked(path, _on_globe(path, *geojson(path, data)))
    readers: dict[str, Callable[[], list[Drawn]]] = {
        ".kml": lambda: kml(path, data),
        ".kmz": lambda: kmz(path, data, MOST_BYTES),
        ".gpx": lambda: gpx(path, data),
    }
    return checked(path, readers[suffix]())


def _on_globe(path: Path, drawn: list[Drawn], crs: str) -> list[Drawn]:
    """The same in longitude and latitude."""
    if not crs or not drawn:
        return drawn
    from rasterio import Env
    from rasterio.crs import CRS
    from rasterio.errors import CRSError, RasterioError
    from rasterio.warp import transform

    try:
        with Env():  # which keeps what GDAL says off the terminal
            if crs.startswith("EPSG:"):
                source = CRS.from_epsg(int(crs.removeprefix("EPSG:")))
            else:
                source = CRS.from_wkt(crs[:MOST_BYTES_OF_WKT])
    except (CRSError, ValueError, OverflowError) as error:
        expected = "expected a known one: save the file again in EPSG:4326"
        raise refusal(path, "", f"a projection that cannot be used came ({error})"[:200], expected) from None
    world = CRS.from_epsg(4326)

    def moved(places: NDArray[np.float64]) -> NDArray[np.float64]:
        try:
            lon, lat = transform(source, world, places[:, 0].tolist(), places[:, 1].tolist())
        except (RasterioError, ValueError, OverflowError):
            return np.full_like(places, np.nan)
        except Exception:  # GDAL's own errors come as they are, of no class that is public
            return np.full_like(places, np.nan)
        return np.column_stack([lon, lat])

    geometries = np.array([each.geometry for each in drawn], dtype=object)
    if not source.is_geographic:
        length_m = float(shapely.length(geometries).sum())
        geometries = shapely.segmentize(geometries, max(LONGEST * 100_000.0, length_m / MOST_BETWEEN))
    there = shapely.transform(geometries, moved)
    return [replace(each, geometry=geometry) for each, geometry in zip(drawn, there, strict=True)]
