"""A lost hiker as a command post has it: layers on the globe, two drones, two batteries each; hills are made up."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.io.georeference import Georeference
from sooner.io.geotiff import geotiff
from sooner.scenarios.terrain import hill, smooth_noise

__all__ = ["LostHiker", "lost_hiker"]

Floats = NDArray[np.float64]

CELLS, SIDE_M = 220, 20.0  # of the rasters
WIDE_M = CELLS * SIDE_M
GROUND = Georeference("EPSG:32632", (709_000.0, 5_137_400.0), SIDE_M, SIDE_M)
MEADOW, FOREST, SCREE, WATER = 1, 2, 3, 4
CORNERS = 48  # of the search area
DECIMALS = 7  # of degrees: a centimetre


@dataclass(frozen=True, eq=False)
class LostHiker:
    """What the command post has drawn; places in metres east and north of the rasters' south-west corner.

    Parameters
    ----------
    title : str
    outline, lake, flight_area, village : (n, 2) float   corners
    launch, last_seen, mast : (2,) float
    mast_m : float              nothing flies so near to the mast
    heights : (H, W) float      metres above the sea
    cover : (H, W) int          class of ground
    wind_mps, wind_from : int   metres a second, degrees
    """

    title: str
    outline: Floats
    lake: Floats
    flight_area: Floats
    village: Floats
    launch: Floats
    last_seen: Floats
    mast: Floats
    mast_m: float
    heights: Floats
    cover: NDArray[np.int64]
    wind_mps: int
    wind_from: int

    def files(self) -> dict[str, bytes]:
        """A mission file and its layers, by name; what `sooner scenario` writes."""
        area = [
            _feature("search area", "Polygon", [_ring(self.outline), _ring(self.lake)]),
            _feature("flight area", "Polygon", [_ring(self.flight_area)]),
            _feature("car park", "Point", _lon_lat(self.launch)[0]),
            _feature("last seen", "Point", _lon_lat(self.last_seen)[0]),
        ]
        return {
            "mission.toml": self._mission().encode(),
            "area.geojson": _geojson(area),
            "village.geojson": _geojson([_feature("village", "Polygon", [_ring(self.village)])]),
            "elevation.tif": geotiff(self.heights, GROUND, "metres above the sea, made up"),
            "land_cover.tif": geotiff(self.cover, GROUND, "1 meadow, 2 forest, 3 scree, 4 water; made up"),
            "copter.toml": _VEHICLE.encode(),
        }

    def _mission(self) -> str:
        lon, lat = _lon_lat(self.mast)[0]
        return f"""\
name = "{self.title}"

[area]
polygon = {{ file = "area.geojson", title = "search area" }}       # with a hole: the lake
flight_area = {{ file = "area.geojson", title = "flight area" }}   # with the car park beside the search area
no_fly = ["village.geojson", {{ lat = {lat}, lon = {lon}, radius_m = {self.mast_m:g} }}]   # the circle: a mast
margin_m = 15
elevation = "elevation.tif"
land_cover = "land_cover.tif"
cell_m = 25.0

[area.last_known]            # the person was seen here; in made-up cases like it, found within so far
place = "last seen"
rings_m = [200, 450, 800, 1400]
quantiles = [0.25, 0.5, 0.75, 0.95]

[sensor]
radius_m = 40                # to each side
land_cover = {{ {MEADOW} = 0.9, {FOREST} = 0.45, {SCREE} = 0.75, else = 0.9 }}   # P(detect in one pass, if there)

[[searcher]]
start = "car park"
end = "car park"
moves = "legs"
vehicle = "copter.toml"
batteries = 2
altitude_m = 60              # above the ground

[[searcher]]
start = "car park"
end = "car park"
moves = "legs"
vehicle = "copter.toml"
batteries = 2
altitude_m = 80

[wind]
speed_mps = {self.wind_mps}
from_deg = {self.wind_from}
"""


_VEHICLE = """\
# Numbers that are round, made up and of no aircraft: put your own in their place.
name = "Example copter"
speed_mps = 12.0
accel_mps2 = 2.0
airspeed_mps = 17.0
climb_mps = 4.0
descent_mps = 3.0
endurance_s = 1500
reserve = 0.2                # never planned with
swap_s = 180                 # on the ground from one battery to the next
takeoff_s = 10
landing_mps = 0.5
landing_below_m = 10.0
"""


def lost_hiker(seed: int = 0) -> LostHiker:
    """Some four square kilometres of hills around a lake; a village and a mast that nothing flies over.

    >>> hiker = lost_hiker()
    >>> len(hiker.files()["mission.toml"]) > 1000, int(hiker.heights.max() - hiker.heights.min()) > 100
    (True, True)
    """
    rng = np.random.default_rng(seed)
    turn = rng.uniform(0.0, 2.0 * np.pi)  # where the car park is, seen from the middle
    middle = np.array([WIDE_M / 2, WIDE_M / 2])
    at = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    reach = _reach(rng, at, turn)
    way_in = 420.0 * np.exp(-((_apart(at, turn) / 0.22) ** 2))

    def place(angle: float, share: float, beyond_m: float = 0.0) -> Floats:
        nearest = int(np.argmin(_apart(at, turn + angle)))
        return np.asarray(middle + _towards(turn + angle) * (share * reach[nearest] + beyond_m))

    launch, last_seen = place(0.0, 1.0, 300.0), place(0.8, 0.5)
    village, mast = place(3.7, 0.85), place(5.2, 0.6)
    heights = _heights(rng)
    outline = middle + _towards(at) * reach[:, None]
    lake = _lake(rng, heights, middle, outline, np.array([last_seen, village, mast]))
    water = _within(lake)
    heights[water] = heights[water].min()
    return LostHiker(
        "Lost hiker",
        outline,
        lake,
        middle + _towards(at) * (reach + 70.0 + way_in)[:, None],
        village + _turned(np.array([[-180.0, -130.0], [200.0, -150.0], [170.0, 140.0], [-190.0, 120.0]]), turn),
        launch,
        last_seen,
        mast,
        120.0,
        np.round(heights, 1),
        _cover(rng, heights, water),
        int(rng.integers(3, 7)),
        int(rng.integers(0, 36)) * 10,
    )


# ---------------------------------------------------------------- ground


def _reach(rng: Generator, at: Floats, turn: float) -> Floats:
    """(n,) float: how far the search area reaches in each direction, with a bay opposite the last place."""
    waves = sum(rng.uniform(0.04, 0.1) * np.cos(k * at + rng.uniform(0.0, 2.0 * np.pi)) for k in (2, 3, 5))
    bay = 1.0 - 0.5 * np.exp(-((_apart(at, turn + 2.3) / 0.35) ** 2))
    return np.asarray(1250.0 * (1.0 + waves) * bay)


def _heights(rng: Generator) -> Floats:
    ridge = hill((CELLS, CELLS), (rng.uniform(40, 180), rng.uniform(40, 180)), (25.0, 90.0), rng.uniform(0.0, np.pi))
    return np.asarray(1150.0 + 55.0 * smooth_noise((CELLS, CELLS), rng, (32.0, 12.0, 5.0)) + 170.0 * ridge)


def _lake(rng: Generator, heights: Floats, middle: Floats, outline: Floats, others: Floats) -> Floats:
    """(n, 2) float: a shore around the lowest ground near the middle that is far from other places and the border."""
    centres = _centres()

    def beyond(places: Floats, metres: float) -> NDArray[np.bool_]:
        return np.asarray(np.hypot(*(centres[:, None] - places[None]).T).min(axis=0) > metres)

    allowed = ~beyond(middle[None], 650.0) & beyond(others, 400.0) & beyond(outline, 240.0) & _within(outline).ravel()
    lowest = centres[np.argmin(np.where(allowed, heights.ravel(), np.inf))]
    at = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    shore = 150.0 * (1.0 + 0.2 * np.cos(2 * at + rng.uniform(0, 6)) + 0.1 * np.cos(3 * at + rng.uniform(0, 6)))
    return np.asarray(lowest + _towards(at) * shore[:, None])


def _cover(rng: Generator, heights: Floats, water: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(H, W) int: forest in patches, scree where it is high, water in the lake."""
    found = np.where(smooth_noise(heights.shape, rng, (14.0, 5.0)) > 0.1, FOREST, MEADOW)
    found = np.where(heights > np.quantile(heights, 0.85), SCREE, found)
    return np.where(water, WATER, found).astype(np.int64)


def _within(ring: Floats) -> NDArray[np.bool_]:
    """(H, W) bool: cells whose centre lies in a ring, by how often a ray to the east crosses it."""
    (x, y), inside = _centres().T, np.zeros(CELLS * CELLS, bool)
    for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return inside.reshape(CELLS, CELLS)


def _centres() -> Floats:
    """(H W, 2) float: the middles of the rasters' cells."""
    rows, cols = np.indices((CELLS, CELLS))
    return np.column_stack([(cols.ravel() + 0.5) * SIDE_M, WIDE_M - (rows.ravel() + 0.5) * SIDE_M])


def _apart(at: Floats, angle: float) -> Floats:
    """Radians between directions, at most half a turn."""
    return np.asarray(np.abs((at - angle + np.pi) % (2.0 * np.pi) - np.pi))


def _towards(at: Floats | float) -> Floats:
    return np.stack([np.cos(at), np.sin(at)], axis=-1)


def _turned(points: Floats, angle: float) -> Floats:
    return np.asarray(points @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]))


# ---------------------------------------------------------------- files


def _lon_lat(places: Floats) -> list[list[float]]:
    east, north = np.reshape(places, (-1, 2)).T / SIDE_M
    found = GROUND.places(np.column_stack([CELLS - north - 0.5, east - 0.5]))
    return [[round(float(lon), DECIMALS), round(float(lat), DECIMALS)] for lat, lon in found]


def _ring(corners: Floats) -> list[list[float]]:
    found = _lon_lat(corners)
    return [*found, found[0]]


def _feature(title: str, kind: str, coordinates: list[Any]) -> dict[str, Any]:
    properties = {"class": "Marker" if kind == "Point" else "Shape", "title": title}
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def _geojson(features: list[dict[str, Any]]) -> bytes:
    return (json.dumps({"type": "FeatureCollection", "features": features}, indent=1) + "\n").encode()
