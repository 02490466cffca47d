"""Missions whose area is drawn, for tests."""

import json
from pathlib import Path

import numpy as np
import rasterio
import shapely
from rasterio import Affine

LAT, LON = 46.1, 11.2
METRE_NORTH, METRE_EAST = 1 / 111_154.0, 1 / 77_300.0  # degrees, near enough for drawing


def place(east: float, north: float) -> list[float]:
    """[lon, lat] some metres from the corner."""
    return [LON + east * METRE_EAST, LAT + north * METRE_NORTH]


def box(west: float, south: float, east: float, north: float, *holes):
    """A polygon of GeoJSON, in metres from the corner."""
    rings = [(west, south, east, north), *holes]
    corners = [[(w, s), (e, s), (e, n), (w, n), (w, s)] for w, s, e, n in rings]
    return {"type": "Polygon", "coordinates": [[place(*corner) for corner in ring] for ring in corners]}


def point(east: float, north: float):
    return {"type": "Point", "coordinates": place(east, north)}


def drawn(path: Path, *features) -> Path:
    """(title, geometry, properties...) of each, as CalTopo would export them."""
    said = [
        {"type": "Feature", "geometry": geometry, "properties": {"class": "Shape", "title": title} | dict(more)}
        for title, geometry, *rest in features
        for more in (rest[0] if rest else {},)
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": said}))
    return path


def raster(path: Path, values, step: float = 50.0, west: float = -100.0, north: float = 1100.0, **more) -> Path:
    """A GeoTIFF in degrees whose cells are about `step` metres, from a corner in metres."""
    values = np.asarray(values)
    lon, lat = place(west, north)
    at = Affine(step * METRE_EAST, 0, lon, 0, -step * METRE_NORTH, lat)
    profile = {"driver": "GTiff", "height": values.shape[0], "width": values.shape[1], "count": 1}
    crs = more.pop("crs", "EPSG:4326")
    with rasterio.open(path, "w", **profile, dtype=values.dtype, crs=crs, transform=at, **more) as file:
        file.write(values, 1)
    return path


def polygon_of(geometry):
    return shapely.Polygon(geometry["coordinates"][0], geometry["coordinates"][1:])


def mission(folder: Path, area: str, searcher: str = 'start = "launch"', sensor: str = "", budget: str = "steps = 40"):
    path = folder / "mission.toml"
    path.write_text(f"[area]\n{area}\n[sensor]\n{sensor}\n[[searcher]]\n{searcher}\n[budget]\n{budget}\n")
    return path
