"""Street maps as JSON: nodes `[id, x_m, y_m, bx, by]` from the south-west corner, rows counted from the south.

`docs/mission_file.md` tells the format.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import cos, floor, isfinite, radians
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError, printable
from sooner.grid import Grid
from sooner.io.reading import bytes_of, text_of
from sooner.streets import OccupancyGraph
from sooner.streets.occupancy import SLACK

__all__ = ["MOST_STREET_CELLS", "StreetMap", "metres_from", "read_street_map", "street_map_json"]

MOST_STREET_CELLS = 1_000_000
MOST_BYTES = 50_000_000
CELLS_M = (0.001, 1e6)
EARTH_M = 6371008.8  # mean radius
COLUMNS = ["id", "x_m", "y_m", "bx", "by"]
_EXPECTED = "expected an occupancy graph in JSON, with cell_m, shape, nodes and edges"
_MOST_FAULTS = 10


@dataclass(frozen=True, eq=False)
class StreetMap:
    """An occupancy graph, and where it is from.

    Parameters
    ----------
    graph : OccupancyGraph
    name : str
    attribution : str                       who must be named beside it; "" for nobody
    south_west : (float, float) or None     latitude and longitude of the grid's south-west corner
    scale : float                           real metres that one metre of the map stands for
    """

    graph: OccupancyGraph
    name: str = ""
    attribution: str = ""
    south_west: tuple[float, float] | None = None
    scale: float = 1.0

    def cell_at(self, lat: float, lon: float) -> tuple[int, int]:
        """The cell, (row, col), whose ground holds a place; beyond the map, the cell that it would have there.

        Raises
        ------
        InvalidProblemError     if the map does not say where on the globe it lies

        Examples
        --------
        >>> streets = StreetMap(OccupancyGraph.of(Grid((2, 2), "square8", 5.0), [2], []), south_west=(46.0, 11.0))
        >>> streets.cell_at(46.00001, 11.0001)  # a metre to the north, eight to the east
        (1, 1)
        """
        if self.south_west is None:
            raise InvalidProblemError("a latitude and longitude came, and streets without sw_corner_latlon")
        grid = self.graph.grid
        east, north = metres_from(np.array([[lat, lon]]), self.south_west, self.scale)[0]
        return grid.shape[0] - 1 - floor(north / grid.cell_m), floor(east / grid.cell_m)


def metres_from(places: NDArray[np.float64], corner: tuple[float, float], scale: float = 1.0) -> NDArray[np.float64]:
    """(k, 2) metres of the map, east and north of a corner, to places (k, 2) in degrees north and east.

    Equirectangular, good for some kilometres.

    >>> metres_from(np.array([[0.1, -179.9]]), (0.0, 179.9)).round()
    array([[22239., 11120.]])
    """
    lat, lon = places[:, 0] - corner[0], (places[:, 1] - corner[1] + 180.0) % 360.0 - 180.0
    return np.radians(np.column_stack([lon * cos(radians(corner[0])), lat])) * EARTH_M / scale


def read_street_map(path: Path) -> StreetMap:
    """Read a street map.

    Raises
    ------
    DataFormatError       missing, unreadable, not such JSON, or a graph that cannot be: every fault of the nodes and
                          edges, ten at most
    """
    said = _said(path)
    grid = _grid(path, said)
    faults: list[Fault] = []
    nodes = _nodes(path, said, grid, faults)
    edges = _edges(path, said, nodes, faults)
    if faults:
        raise DataFormatError(*faults[:_MOST_FAULTS])
    cells = [grid.index((grid.shape[0] - 1 - by, bx)) for _, _, bx, by in nodes.values()]
    places = np.array([[x, y] for x, y, _, _ in nodes.values()]) - grid.cell_m / 2.0
    try:
        graph = OccupancyGraph.of(grid, cells, edges, places)
    except InvalidProblemError as error:
        came, _, expected = str(error).partition("; ")
        raise DataFormatError(Fault(str(path), "", came, expected or _EXPECTED)) from None
    name, attribution = (printable(str(said.get(key) or "")) for key in ("name", "attribution"))
    return StreetMap(graph, name, attribution, _corner(path, said), _scale(path, said))


def street_map_json(street_map: StreetMap) -> bytes:
    """A street map as JSON that `read_street_map` reads.

    >>> said = json.loads(street_map_json(StreetMap(OccupancyGraph.of(Grid((2, 2), "square8", 5.0), [2], []))))
    >>> said["nodes"]
    [[0, 2.5, 2.5, 0, 0]]
    """
    graph = street_map.graph
    rows, cols = np.divmod(graph.cells, graph.grid.shape[1])
    places = graph.positions_m + graph.grid.cell_m / 2.0
    heights = graph.grid.shape[0] - 1 - rows
    table = zip(range(graph.n_nodes), places.tolist(), cols.tolist(), heights.tolist(), strict=True)
    said: dict[str, Any] = {"name": street_map.name, "attribution": street_map.attribution}
    if street_map.south_west is not None:
        said["sw_corner_latlon"] = list(street_map.south_west)
    said |= {
        "scale_real_metres_per_map_metre": street_map.scale,
        "cell_m": graph.grid.cell_m,
        "shape": list(graph.grid.shape),
        "node_columns": COLUMNS,
        "nodes": [[node, *place, col, height] for node, place, col, height in table],
        "edges": graph.edges.tolist(),
    }
    return (json.dumps(said, allow_nan=False) + "\n").encode()


def _said(path: Path) -> dict[str, Any]:
    text = text_of(path, bytes_of(path, MOST_BYTES, "50 MB", _EXPECTED), _EXPECTED)
    try:
        said = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DataFormatError(Fault(str(path), "", f"it is not JSON ({error})"[:200], _EXPECTED)) from None
    if not isinstance(said, dict):
        raise DataFormatError(Fault(str(path), "", f"{_short(said)} came", _EXPECTED))
    return said


def _grid(path: Path, said: dict[str, Any]) -> Grid:
    cell_m = _positive(path, said, "cell_m")
    if not CELLS_M[0] <= cell_m <= CELLS_M[1]:
        expected = f"expected {CELLS_M[0]:g} to {CELLS_M[1]:g} m"
        raise DataFormatError(Fault(str(path), "cell_m", f"{_short(said['cell_m'])} came", expected))
    shape: Any = said.get("shape")
    if shape is None and said.get("size_m") is None:
        expected = "expected [rows, columns], or size_m where there are as many"
        raise DataFormatError(Fault(str(path), "shape", "nothing came", expected))
    if shape is None:
        across = _positive(path, said, "size_m") / cell_m
        if not (0.5 < across <= MOST_STREET_CELLS and abs(across - round(across)) < 1e-6):
            came, expected = f"{_short(said['size_m'])} came", f"expected metres that are whole cells of {cell_m:g} m"
            raise DataFormatError(Fault(str(path), "size_m", came, expected))
        shape = [round(across)] * 2
    right = isinstance(shape, list) and len(shape) == 2 and all(_is_whole(n) and n > 0 for n in shape)
    if not right or shape[0] * shape[1] > MOST_STREET_CELLS:
        expected = f"expected [rows, columns] of at most {MOST_STREET_CELLS} cells"
        raise DataFormatError(Fault(str(path), "shape", f"{_short(shape)} came", expected))
    return Grid((shape[0], shape[1]), "square8", cell_m)


def _positive(path: Path, said: dict[str, Any], key: str) -> float:
    number = said.get(key)
    if not _is_number(number) or not isinstance(number, int | float) or number <= 0:
        raise DataFormatError(Fault(str(path), key, f"{_short(number)} came", "expected a positive number"))
    return float(number)


def _nodes(
    path: Path, said: dict[str, Any], grid: Grid, faults: list[Fault]
) -> dict[int, tuple[float, float, int, int]]:
    """(x, y, bx, by) of every node, by its id."""
    rows = said.get("nodes")
    if not isinstance(rows, list) or not rows:
        raise DataFormatError(Fault(str(path), "nodes", f"{_short(rows)} came", "expected a list of at least one node"))
    nodes: dict[int, tuple[float, float, int, int]] = {}
    taken: dict[tuple[int, int], int] = {}
    height, width = grid.shape
    for number, row in enumerate(rows):
        key = f"nodes[{number}]"
        if not (isinstance(row, list) and len(row) == 5 and all(map(_is_number, row))) or not all(
            map(_is_whole, (row[0], *row[3:]))
        ):
            faults.append(Fault(str(path), key, f"{_short(row)} came", f"expected numbers {COLUMNS}"))
            continue
        node, x, y, bx, by = row
        if node in nodes:
            faults.append(Fault(str(path), key, f"a second node {node} came", "expected each id once"))
        elif not (0 <= bx < width and 0 <= by < height):
            expected = f"expected columns 0 to {width - 1} and rows 0 to {height - 1}, from the south"
            faults.append(Fault(str(path), key, f"cell bx {bx}, by {by} came", expected))
        elif any(abs(place / grid.cell_m - cell - 0.5) > 0.5 + SLACK for place, cell in ((x, bx), (y, by))):
            west, south = bx * grid.cell_m, by * grid.cell_m
            came = f"x_m {x:g}, y_m {y:g} came, which is not in its cell, bx {bx}, by {by}"
            expected = f"expected x_m {west:g} to {west + grid.cell_m:g}, y_m {south:g} to {south + grid.cell_m:g}"
            faults.append(Fault(str(path), key, came, f"{expected}, from the south-west corner"))
        elif (bx, by) in taken:
            came = f"nodes {taken[bx, by]} and {node} came in one cell, bx {bx}, by {by}"
            faults.append(Fault(str(path), key, came, "a cell holds one node at most"))
        else:
            nodes[node], taken[bx, by] = (float(x), float(y), bx, by), node
    return nodes


def _edges(
    path: Path, said: dict[str, Any], nodes: dict[int, tuple[float, float, int, int]], faults: list[Fault]
) -> list[tuple[int, int]]:
    """Pairs of node numbers, in the order of `nodes`."""
    rows = said.get("edges")
    if not isinstance(rows, list):
        raise DataFormatError(Fault(str(path), "edges", f"{_short(rows)} came", "expected a list of pairs of nodes"))
    number = {node: k for k, node in enumerate(nodes)}
    edges = []
    for k, row in enumerate(rows):
        key = f"edges[{k}]"
        if not (isinstance(row, list) and len(row) == 2 and all(map(_is_whole, row))):
            faults.append(Fault(str(path), key, f"{_short(row)} came", "expected a pair of nodes"))
        elif stray := [node for node in row if node not in nodes]:
            if not faults:  # a node that has a fault of its own is no further fault here
                faults.append(Fault(str(path), key, f"node {_short(stray[0])} came", "expected a node of this file"))
        elif row[0] == row[1]:
            faults.append(Fault(str(path), key, f"an edge from node {row[0]} to itself came", "expected two nodes"))
        elif any(abs(a - b) > 1 for a, b in zip(nodes[row[0]][2:], nodes[row[1]][2:], strict=True)):
            came = f"an edge between nodes {row[0]} and {row[1]} came, whose cells do not touch"
            faults.append(Fault(str(path), key, came, "edges join cells that touch"))
        else:
            edges.append((number[row[0]], number[row[1]]))
    return edges


def _corner(path: Path, said: dict[str, Any]) -> tuple[float, float] | None:
    corner = said.get("sw_corner_latlon")
    if corner is None:
        return None
    pair = isinstance(corner, list) and len(corner) == 2 and all(map(_is_number, corner))
    if not pair or abs(corner[0]) > 90 or abs(corner[1]) > 180:
        expected = "expected [latitude, longitude], from -90 to 90 and from -180 to 180 degrees"
        raise DataFormatError(Fault(str(path), "sw_corner_latlon", f"{_short(corner)} came", expected))
    return float(corner[0]), float(corner[1])


def _scale(path: Path, said: dict[str, Any]) -> float:
    key = "scale_real_metres_per_map_metre"
    return _positive(path, said, key) if key in said else 1.0


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**53


def _is_number(value: object) -> bool:
    return _is_whole(value) or (isinstance(value, float) and isfinite(value))


def _short(value: object) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
