"""Streets from OpenStreetMap extracts, .osm and .pbf: their roads and paths become an occupancy graph."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.grid import Grid
from sooner.io.occupancy_graphs import MOST_STREET_CELLS, StreetMap, metres_from
from sooner.io.reading import opened
from sooner.streets.rasterise import rasterised

__all__ = ["ATTRIBUTION", "read_openstreetmap"]

ATTRIBUTION = "© OpenStreetMap contributors"
MOST_BYTES = 500_000_000
MOST_WAY_NODES = 5_000_000
# Where nobody walks, nobody can be seen, or nothing is yet.
NO_STREETS = frozenset(
    ["motorway", "motorway_link", "trunk", "trunk_link", "construction", "proposed", "corridor", "elevator", "platform"]
)
_EXPECTED = "expected an OpenStreetMap extract, .osm or .pbf"


@dataclass(frozen=True, eq=False)
class _Road:
    """A way: its number, and (k, 2) latitudes and longitudes of its nodes, NaN where the extract lacks them."""

    number: int
    places: NDArray[np.float64]


def read_openstreetmap(
    path: Path,
    shape: tuple[int, int] | None = None,
    cell_m: float = 5.0,
    south_west: tuple[float, float] | None = None,
    scale: float = 1.0,
    cut: bool = False,
) -> StreetMap:
    """The streets of an extract.

    Every way with a `highway` tag is a street, but for motorways and trunk roads, what is not yet built, areas, and
    what lies below ground. Bridges join what they cross.

    Parameters
    ----------
    path : Path
    shape : (int, int) or None            rows and columns; None for as many as the file's bounds hold
    cell_m : float
    south_west : (float, float) or None   latitude and longitude of the grid's south-west corner; None for the bounds'
    scale : float                         real metres that become one metre of the map
    cut : bool                            end streets where the extract lacks their nodes; else that is a fault

    Raises
    ------
    DataFormatError                       missing, unreadable, too large, no bounds, no roads in the window, nodes
                                          missing, or pyosmium not installed
    InvalidProblemError                   if the window cannot be
    """
    if not (np.isfinite(scale) and scale > 0.0):
        raise InvalidProblemError(f"a scale of {scale} came; expected a positive number")
    roads, bounds = _read(path)
    if not roads:
        raise DataFormatError(Fault(str(path), "", "an extract without roads came", "expected ways tagged highway"))
    corner = _corner(path, south_west, bounds)
    grid = Grid(_shape(path, shape, cell_m * scale, corner, bounds), "square8", cell_m)
    if grid.n_cells > MOST_STREET_CELLS:
        raise InvalidProblemError(f"a window of {grid.n_cells} cells came; expected at most {MOST_STREET_CELLS}")
    placed = [(road, metres_from(road.places, corner, scale) - cell_m / 2.0) for road in roads]
    if not cut:
        _refuse_gaps(path, grid, placed)
    try:
        graph = rasterised((part for _, places in placed for part in _parts(places)), grid)
    except InvalidProblemError as error:
        came, _, expected = str(error).partition("; ")
        raise DataFormatError(Fault(str(path), "", came, expected)) from None
    return StreetMap(graph, path.name.partition(".")[0], ATTRIBUTION, corner, scale)


def _read(path: Path) -> tuple[list[_Road], tuple[float, float, float, float] | None]:
    """Every road, and the bounds (south, west, north, east) that the file tells."""
    with opened(path) as file:
        if file.seek(0, 2) > MOST_BYTES:
            told = "expected an extract of the search area: osmium extract --bbox"
            raise DataFormatError(Fault(str(path), "", "a file of more than 500 MB came", told))
    try:
        import osmium
    except ImportError:
        told = "expected pyosmium: pip install 'sooner[openstreetmap]'"
        raise DataFormatError(
            Fault(str(path), "", "an OpenStreetMap extract came, which is not read here", told)
        ) from None
    try:
        ways = osmium.FileProcessor(str(path)).with_locations().with_filter(osmium.filter.EntityFilter(osmium.osm.WAY))
        roads = _roads(path, ways.with_filter(osmium.filter.KeyFilter("highway")))
        with osmium.io.Reader(str(path), osmium.osm.NOTHING) as reader:
            box = reader.header().box()
    except (RuntimeError, ValueError, OverflowError) as error:
        raise DataFormatError(Fault(str(path), "", f"it cannot be read ({error})"[:300], _EXPECTED)) from None
    if not box.valid():
        return roads, None
    return roads, (box.bottom_left.lat, box.bottom_left.lon, box.top_right.lat, box.top_right.lon)


def _roads(path: Path, ways: Iterable[Any]) -> list[_Road]:
    roads, n_nodes = [], 0
    for way in ways:
        if not _is_street(way.tags):
            continue
        n_nodes += len(way.nodes)
        if n_nodes > MOST_WAY_NODES:
            came, told = f"roads of more than {MOST_WAY_NODES} nodes came", "expected an extract of the search area"
            raise DataFormatError(Fault(str(path), "", came, told))
        places = [(node.lat, node.lon) if node.location.valid() else (np.nan, np.nan) for node in way.nodes]
        roads.append(_Road(way.id, np.array(places).reshape(-1, 2)))
    return roads


def _is_street(tags: Any) -> bool:
    """Whether people can be on it and seen from above."""
    if tags["highway"] in NO_STREETS or tags.get("area") == "yes" or tags.get("indoor") == "yes":
        return False
    below = tags.get("layer", "").startswith("-") or tags.get("location") == "underground"
    return not below and tags.get("tunnel", "no") == "no"


def _corner(
    path: Path, south_west: tuple[float, float] | None, bounds: tuple[float, float, float, float] | None
) -> tuple[float, float]:
    if south_west is not None:
        lat, lon = south_west
        if not (abs(lat) <= 85.0 and abs(lon) <= 180.0):
            raise InvalidProblemError(f"a corner at [{lat}, {lon}] came; expected latitude and longitude in degrees")
        return float(lat), float(lon)
    if bounds is None:
        raise DataFormatError(Fault(str(path), "bounds", "nothing came", "expected bounds, or a south-west corner"))
    return bounds[0], bounds[1]


def _shape(
    path: Path,
    shape: tuple[int, int] | None,
    cell_m: float,
    corner: tuple[float, float],
    bounds: tuple[float, float, float, float] | None,
) -> tuple[int, int]:
    if shape is not None:
        return shape
    if bounds is None:
        raise DataFormatError(Fault(str(path), "bounds", "nothing came", "expected bounds, or a number of cells"))
    east, north = metres_from(np.array([bounds[2:]]), corner, 1.0)[0]
    rows, cols = ceil(north / cell_m - 0.01), ceil(east / cell_m - 0.01)  # bounds are told to a centimetre
    if rows < 1 or cols < 1 or rows * cols > MOST_STREET_CELLS:
        came = f"bounds of {east:.0f} m by {north:.0f} m came"
        told = f"expected an area, of at most {MOST_STREET_CELLS} cells of {cell_m:g} m"
        raise DataFormatError(Fault(str(path), "bounds", came, told))
    return rows, cols


def _parts(places: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """A way cut where its nodes are missing."""
    known = np.isfinite(places).all(axis=1)
    cuts = np.flatnonzero(np.diff(known)) + 1
    return [part for part in np.split(places, cuts) if len(part) > 1 and np.isfinite(part[0, 0])]


def _refuse_gaps(path: Path, grid: Grid, placed: list[tuple[_Road, NDArray[np.float64]]]) -> None:
    """Roads that lead from a node on the grid to one that the extract lacks, or of which it has no node at all."""
    high = np.array([grid.shape[1], grid.shape[0]]) * grid.cell_m - grid.cell_m / 2.0
    torn = []
    for road, places in placed:
        missing = np.isnan(places[:, 0])
        with np.errstate(invalid="ignore"):
            inside: NDArray[np.bool_] = np.all((places >= -grid.cell_m / 2.0) & (places <= high), axis=1)
        beside = (missing[:-1] & inside[1:]) | (missing[1:] & inside[:-1])
        if beside.any() or missing.all():
            torn.append(road.number)
    if torn:
        came = f"{len(torn)} roads came whose nodes are not all in the extract, way {torn[0]} among them"
        told = "expected whole ways (osmium extract --strategy complete_ways), or leave to cut them"
        raise DataFormatError(Fault(str(path), "", came, told))
