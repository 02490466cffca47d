"""Vector files for tests, written by GDAL."""

import warnings
from pathlib import Path

import numpy as np
import pyogrio.raw
import shapely

LAT, LON = 46.1, 11.2


def square(lat: float = LAT, lon: float = LON, side: float = 0.01, holes=()):
    return shapely.Polygon(shapely.box(lon, lat, lon + side, lat + side).exterior, [hole.exterior for hole in holes])


def write(path: Path, geometries, crs: str = "EPSG:4326", layer: str | None = None, append=False, **fields) -> Path:
    """Geometries of one kind with text or numbers, by the driver of the suffix."""
    kinds = {each.geom_type for each in geometries}
    data = [np.array(values, dtype=object if isinstance(values[0], str) else None) for values in fields.values()]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pyogrio.raw.write(
            path,
            np.array([shapely.to_wkb(each) for each in geometries], dtype=object),
            data,
            list(fields),
            layer=layer,
            driver="LIBKML" if path.suffix == ".kml" else None,
            crs=crs,
            geometry_type=kinds.pop() if len(kinds) == 1 else "Unknown",
            append=append,
        )
    return path
