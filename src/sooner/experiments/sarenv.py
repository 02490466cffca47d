"""SAREnv's scenarios and its measure of paths, and what the paths truly sweep.

K. A. R. Groentved, A. Jarabo-Penas, S. Reid, E. G. A. Rolland, M. Watson, A. Richards, S. Bullock, A. L. Christensen,
"SAREnv: An Open-Source Dataset and Benchmark Tool for Informed Wilderness Search and Rescue Using UAVs", Drones 9
(2025), 628. Maps: (c) OpenStreetMap contributors, ODbL 1.0.

The drone sees a disc and misses nothing in it. SAREnv sums the heat of cells whose centre was in view, so that lanes
over centres of cells count for a swath of three cells (90 m) and lanes over their edges for two (60 m), where the disc
is 66.3 m across. `Scores.swept` is the heat inside the union of discs, with a cell's heat spread evenly over the cell.

Places are metres east and north of the south-west cell's centre, as `Grid.centres_m` has them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.io.arrays import read_arrays
from sooner.io.reading import bytes_of

if TYPE_CHECKING:
    from shapely import Geometry

__all__ = ["Sarenv", "Scores", "load_sarenv", "scores", "swept_bound", "swept_shares"]

Way = NDArray[np.float64]  # (n, 2) metres

SAMPLE_M = 15.0  # between points of a resampled path, at most
DISCOUNT = 0.999  # of a metre flown
CORNERS = 32  # of a quarter circle; the area of a disc comes out short by 4e-4 of itself
MOST_BYTES = 10_000_000
EXPECTED = "expected a scenario of SAREnv"


@dataclass(frozen=True, eq=False)
class Sarenv:
    """One scenario at one size.

    Parameters
    ----------
    name : str               as in the file
    heat : (H, W) float      share of the whole map's probability per cell, row 0 north; does not sum to one
    cell_m : float           side of a cell
    radius_m : float         of the disc in view
    centre : (float, float)  metres, where every drone starts
    victims : (V, 2) float   metres, drawn from `heat`
    crs : str                of `south_west`
    south_west : (2,) float  of the frame's origin: the centre of the south-west cell
    baselines : rows         SAREnv's own planners on this scenario, as its evaluator scored them
    """

    name: str
    heat: NDArray[np.float64]
    cell_m: float
    radius_m: float
    centre: tuple[float, float]
    victims: NDArray[np.float64]
    crs: str = ""
    south_west: tuple[float, float] = (0.0, 0.0)
    baselines: tuple[Mapping[str, Any], ...] = ()


@dataclass(frozen=True)
class Scores:
    """What paths are worth: SAREnv's measures, and the heat that they truly sweep.

    Parameters
    ----------
    likelihood : float        heat of the cells whose centre was within the radius of a resampled point
    time_discounted : float   sum over points of the heat in view times 0.999 a metre flown; seen cells count again
    victims_percent : float   of victims in the union of discs
    area_km2 : float          of the union of discs
    length_km : float         of all paths together
    swept : float             heat in the union of discs
    """

    likelihood: float
    time_discounted: float
    victims_percent: float
    area_km2: float
    length_km: float
    swept: float


def load_sarenv(folder: Path, name: str, size: str = "medium") -> Sarenv:
    """Read `name`.json and `name`.npz, whose rows count from the south.

    Raises
    ------
    DataFormatError    if a file or one of its keys is missing or makes no sense
    """
    file = folder / f"{name}.json"
    told = _told(file)
    heat, victims = _arrays(folder / f"{name}.npz", size)
    expected = "expected bounds_xy of the crop, center_xy, detection_radius_m and crs"
    try:
        bounds = [float(edge) for edge in told["crop"][size]["bounds_xy"]]
        middle = [float(part) for part in told["center_xy"]]
        radius_m, crs = float(told["detection_radius_m"]), str(told["crs"])
    except (KeyError, TypeError, ValueError) as error:
        raise DataFormatError(Fault(file.name, "", f"a part is missing or no number: {error}", expected)) from None
    sound = len(bounds) == 4 and len(middle) == 2 and np.isfinite([*bounds, *middle, radius_m]).all()
    if not (sound and bounds[0] < bounds[2] and radius_m > 0):
        raise DataFormatError(Fault(file.name, "", f"{bounds}, {middle} and {radius_m} m came", expected))
    cell_m = (bounds[2] - bounds[0]) / heat.shape[1]
    origin = (bounds[0] + cell_m / 2, bounds[1] + cell_m / 2)
    return Sarenv(
        str(told.get("name", name)),
        np.ascontiguousarray(heat[::-1], float),
        cell_m,
        radius_m,
        (middle[0] - origin[0], middle[1] - origin[1]),
        victims - origin,
        crs,
        origin,
        tuple(told.get(f"baselines_{size}", ())),
    )


def _told(path: Path) -> dict[str, Any]:
    data = bytes_of(path, MOST_BYTES, "10 MB", EXPECTED)
    try:
        told = json.loads(data)
    except ValueError as error:
        raise DataFormatError(Fault(path.name, "", f"it is no JSON: {error}", EXPECTED)) from None
    if not isinstance(told, dict):
        raise DataFormatError(Fault(path.name, "", f"a {type(told).__name__} came", "expected an object of JSON"))
    return told


def _arrays(path: Path, size: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    sizes = ("small", "medium", "large")
    possible = [f"{kind}_{each}" for kind in ("heatmap", "victims_xy") for each in sizes]
    read = read_arrays(path, [f"heatmap_{size}", f"victims_xy_{size}"], possible, EXPECTED)
    heat, victims = read[f"heatmap_{size}"], read[f"victims_xy_{size}"]
    if heat.ndim != 2 or not (np.isfinite(heat).all() and (heat >= 0).all() and heat.sum() > 0):
        raise DataFormatError(
            Fault(path.name, f"heatmap_{size}", f"shape {heat.shape}", "expected (H, W), finite, none below 0")
        )
    if victims.ndim != 2 or victims.shape[1] != 2:
        raise DataFormatError(
            Fault(path.name, f"victims_xy_{size}", f"shape {victims.shape}", "expected (V, 2) metres")
        )
    return heat, victims


def scores(scenario: Sarenv, ways: Sequence[Way]) -> Scores:
    """Score one way for each drone, in the order in which SAREnv's discount counts them.

    Examples
    --------
    >>> ground = Sarenv("flat", np.full((9, 9), 0.01), 30.0, 33.137, (120.0, 120.0), np.array([[120.0, 140.0]]))
    >>> east = scores(ground, [np.array([[60.0, 120.0], [180.0, 120.0]])])  # over centres: 3 x 5 cells and both ends
    >>> round(east.likelihood, 2), round(east.swept, 3), east.victims_percent
    (0.17, 0.127, 100.0)
    """
    ways = [_way(way) for way in ways]
    union = _union(ways, scenario.radius_m)
    likelihood, discounted = _by_centres(scenario, ways)
    swept = float((swept_shares(scenario, ways, union) * scenario.heat).sum())
    return Scores(
        likelihood,
        discounted,
        _found_percent(scenario, union),
        union.area / 1e6,
        sum(map(_length, ways)) / 1000,
        swept,
    )


def _way(way: Way) -> Way:
    way = np.asarray(way, float)
    if way.ndim != 2 or way.shape[1] != 2 or len(way) < 2 or not np.isfinite(way).all():
        raise InvalidProblemError(f"a way of shape {way.shape} came; expected (n, 2) finite metres, n at least 2")
    return way


def _length(way: Way) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def _by_centres(scenario: Sarenv, ways: Sequence[Way]) -> tuple[float, float]:
    """The likelihood score and the time-discounted score."""
    seen = np.zeros(scenario.heat.shape, bool)
    discounted = flown = 0.0
    for way in ways:
        points, along = _resampled(way)
        row, col, visible = _in_view(scenario, points)
        seen[row[visible], col[visible]] = True
        heat = np.where(visible, scenario.heat[row, col], 0.0).sum(axis=1)
        discounted += float((heat * DISCOUNT ** (flown + along)).sum())
        flown += _length(way)
    return float(scenario.heat[seen].sum()), discounted


def _resampled(way: Way) -> tuple[Way, NDArray[np.float64]]:
    """Points at equal distances, the ends among them, and how far along the way each lies."""
    passed = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    along = np.linspace(0.0, passed[-1], int(np.ceil(passed[-1] / SAMPLE_M)) + 1)
    return np.column_stack([np.interp(along, passed, way[:, axis]) for axis in (0, 1)]), along


def _in_view(scenario: Sarenv, points: Way) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """(n, m) rows and columns of the cells around each point, and whether their centre is within the radius."""
    height, width = scenario.heat.shape
    reach = int(np.ceil(scenario.radius_m / scenario.cell_m)) + 1
    north, east = (steps.ravel() for steps in np.mgrid[-reach : reach + 1, -reach : reach + 1])
    nearest = np.rint(points / scenario.cell_m).astype(np.int64)
    cols, ups = nearest[:, :1] + east, nearest[:, 1:] + north
    away = np.hypot(cols * scenario.cell_m - points[:, :1], ups * scenario.cell_m - points[:, 1:])
    visible = (away <= scenario.radius_m) & (cols >= 0) & (cols < width) & (ups >= 0) & (ups < height)
    return np.clip(height - 1 - ups, 0, height - 1), np.clip(cols, 0, width - 1), visible


def _union(ways: Sequence[Way], radius_m: float) -> Geometry:
    """All that comes into view: a stadium for each leg."""
    import shapely

    legs = [shapely.linestrings(np.stack([way[:-1], way[1:]], axis=1)) for way in ways]
    return shapely.union_all(shapely.buffer(np.concatenate(legs), radius_m, quad_segs=CORNERS))


def swept_shares(scenario: Sarenv, ways: Sequence[Way], union: Geometry | None = None) -> NDArray[np.float64]:
    """(H, W) share of each cell's area that comes into view, row 0 north; exact but for the corners of circles."""
    import shapely

    if union is None:
        union = _union([_way(way) for way in ways], scenario.radius_m)
    height, width = scenario.heat.shape
    side = scenario.cell_m
    west = (np.arange(width) - 0.5) * side
    shares = np.zeros((height, width))
    for row in range(height):
        south = (height - 1 - row - 0.5) * side
        strip = shapely.intersection(union, shapely.box(west[0], south, west[-1] + side, south + side))
        if not strip.is_empty:
            cells = shapely.box(west, south, west + side, south + side)
            shares[row] = shapely.area(shapely.intersection(strip, cells)) / side**2
    return shares


def _found_percent(scenario: Sarenv, union: Geometry) -> float:
    import shapely

    if len(scenario.victims) == 0:
        return 0.0
    shapely.prepare(union)
    return 100.0 * float(shapely.covers(union, shapely.points(scenario.victims)).mean())


def swept_bound(scenario: Sarenv, length_m: float, starts: int = 1) -> float:
    """Heat that no ways of this length sweep, all together, from so many starting points.

    A disc of radius r that moves on by dl adds no more than 2 r dl to what it has covered: what is new lies ahead of
    its leading half circle. So ways of total length L from m starting points cover an area of at most
    A = m pi r^2 + 2 r L; ways that start in one place share that first disc. Of all sets of area A none holds more
    than the densest cells that fill it, the last of them in part (the bathtub principle).

    Examples
    --------
    >>> ground = Sarenv("two", np.array([[0.1, 0.4]]), 100.0, 10.0, (0.0, 0.0), np.zeros((0, 2)))
    >>> round(swept_bound(ground, 500.0 - 5 * np.pi), 3), round(swept_bound(ground, 9000.0), 3)
    (0.4, 0.5)
    """
    area = starts * np.pi * scenario.radius_m**2 + 2 * scenario.radius_m * length_m
    densest = np.sort(scenario.heat, axis=None)[::-1]
    filled = np.clip(area / scenario.cell_m**2 - np.arange(densest.size), 0.0, 1.0)
    return float(densest @ filled)
