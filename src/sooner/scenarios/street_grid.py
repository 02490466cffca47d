"""Streets that nobody has mapped: gridirons, suburbs and parks from a seed, as full of nodes as real ones."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.streets import OccupancyGraph, rasterised

__all__ = ["STREET_KINDS", "street_grid"]

Way = NDArray[np.float64]  # (k, 2) metres

# Nodes a cell of the maps of [Wolek2020]: 349 to 504 in 1600 cells; a little more on both sides.
LEAST_SHARE, MOST_SHARE = 350 / 1600, 520 / 1600
LEAST_EDGES, MOST_EDGES = 0.99, 1.06  # a node; 1.005 to 1.038 on those maps
METRES_A_NODE = 0.92  # of street, in cells, about: a street crosses some cells on a slant
TRIES = 200
STEP = 0.8  # of a cell, between the points of a bent street


def street_grid(
    kind: str = "gridiron", seed: int = 0, shape: tuple[int, int] = (40, 40), cell_m: float = 5.0
) -> OccupancyGraph:
    """Streets of a kind; one seed, one map.

    Parameters
    ----------
    kind : str              "gridiron": blocks at an angle, some streets cut short; "suburb": bent streets off a few
                            through roads, many ending blind; "park": paths that wander and cross, in several parts
    seed : int              at least 0
    shape : (int, int)      rows and columns, at least 20 of each
    cell_m : float          metres

    Returns
    -------
    OccupancyGraph          with 350 to 520 nodes on 40 x 40 cells, and as many to a cell on others

    Raises
    ------
    InvalidProblemError     if there is no such kind, seed or shape

    Examples
    --------
    >>> graph = street_grid("suburb", seed=7)
    >>> graph.grid.shape, 350 <= graph.n_nodes <= 520
    ((40, 40), True)
    """
    if kind not in STREET_KINDS:
        raise InvalidProblemError(f"streets of kind {kind!r} came; expected one of {', '.join(STREET_KINDS)}")
    if seed < 0:
        raise InvalidProblemError(f"seed {seed} came; seeds count from 0")
    if min(shape) < 20:
        raise InvalidProblemError(f"a map of {shape[0]} x {shape[1]} cells came; expected at least 20 x 20")
    grid = Grid(shape, "square8", cell_m)
    rng = np.random.default_rng([seed, *kind.encode()])
    for _ in range(TRIES):
        wanted = rng.uniform(LEAST_SHARE, MOST_SHARE) * grid.n_cells
        try:
            graph = rasterised((way * cell_m for way in STREET_KINDS[kind](rng, shape, wanted)), grid)
        except InvalidProblemError:  # nothing of it lies on the map
            continue
        if _is_likely(graph):
            return graph
    raise InvalidProblemError(f"no streets of kind {kind!r} from seed {seed} have the nodes wanted; take another seed")


def _is_likely(graph: OccupancyGraph) -> bool:
    """Whether real streets have so many nodes and edges."""
    share, edges = graph.n_nodes / graph.grid.n_cells, graph.n_edges / graph.n_nodes
    return LEAST_SHARE <= share <= MOST_SHARE and LEAST_EDGES <= edges <= MOST_EDGES


def _gridiron(rng: Generator, shape: tuple[int, int], wanted: float) -> list[Way]:
    """Two families of parallel streets; a piece from crossing to crossing is left out now and then."""
    longer = rng.uniform(1.2, 2.5)
    narrow = (1.0 + 1.0 / longer) * shape[0] * shape[1] / (wanted / METRES_A_NODE)
    half = float(np.hypot(*shape)) / 2.0
    places = [_spaced(rng, half, spacing) for spacing in (narrow, narrow * longer)]
    angle, centre = rng.uniform(0.0, pi / 2.0), np.array([shape[1], shape[0]]) / 2.0
    turned = np.array([[cos(angle), sin(angle)], [-sin(angle), cos(angle)]])
    ways = []
    for family in (0, 1):
        ends = places[1 - family]
        for place in places[family]:
            for begin, end in pairwise(ends):
                if rng.random() < 0.93:
                    piece = np.array([[place, begin], [place, end]])
                    ways.append((piece if family == 0 else piece[:, ::-1]) @ turned + centre)
    if rng.random() < 0.3:
        ways.append(_chord(rng, shape))
    return ways


def _spaced(rng: Generator, half: float, spacing: float) -> NDArray[np.float64]:
    """Places from -half to half, about a spacing apart."""
    count = int(2.0 * half / spacing) + 2
    return -half + spacing * (np.arange(count) + rng.uniform(-0.5, 0.5) + rng.uniform(-0.15, 0.15, count))


def _suburb(rng: Generator, shape: tuple[int, int], wanted: float) -> list[Way]:
    """Through roads, and streets off them, and off those, that end where they meet another or blind."""
    through = [_from_edge(rng, shape) for _ in range(int(rng.integers(2, 4)))]
    ways = [_meander(rng, *begin, 3.0 * max(shape), 0.02, shape) for begin in through]
    for _ in range(int(10 * wanted)):  # where there is no more room, other streets are tried
        if _metres(ways, shape) >= wanted * METRES_A_NODE:
            break
        way = ways[rng.integers(len(ways))]
        if len(way) < 4:
            continue
        k = int(rng.integers(1, len(way) - 1))
        along = way[k + 1] - way[k - 1]
        heading = float(np.arctan2(along[1], along[0])) + rng.choice([-1.0, 1.0]) * (pi / 2.0 + rng.normal(0.0, 0.15))
        street = _meander(rng, way[k], heading, rng.uniform(6.0, 22.0), 0.1, shape)
        street = _until_met(street, np.concatenate(ways), apart=3.0)
        if len(street) * STEP >= 4.0:
            ways.append(street)
    return ways


def _park(rng: Generator, shape: tuple[int, int], wanted: float) -> list[Way]:
    """Paths that wander from edge to edge and across each other, and rings."""
    ways: list[Way] = []
    while _metres(ways, shape) < wanted * METRES_A_NODE:
        if rng.random() < 0.25:
            ways.append(_ring(rng, shape))
            continue
        start, heading = _from_edge(rng, shape)
        if rng.random() < 0.4:
            start, heading = rng.uniform(0.0, 1.0, 2) * [shape[1], shape[0]], rng.uniform(-pi, pi)
        ways.append(_meander(rng, start, heading, rng.uniform(10.0, 50.0), 0.12, shape))
    return ways


def _meander(
    rng: Generator, start: NDArray[np.float64], heading: float, length: float, bend: float, shape: tuple[int, int]
) -> Way:
    """A way whose heading drifts, by `bend` radians a step at first, until its length is used or it leaves the map."""
    n = max(int(length / STEP), 1)
    curvature = np.cumsum(rng.normal(0.0, bend / 4.0, n)) * 0.5 + rng.normal(0.0, bend / 2.0)
    headings = heading + np.cumsum(np.clip(curvature, -0.35, 0.35))
    steps = STEP * np.column_stack([np.cos(headings), np.sin(headings)])
    points = np.concatenate([start[None, :], start + np.cumsum(steps, axis=0)])
    beyond = np.flatnonzero(((points < -1.0) | (points > [shape[1] + 1.0, shape[0] + 1.0])).any(axis=1))
    return points[: beyond[0] + 1] if len(beyond) else points


def _until_met(street: Way, others: Way, apart: float) -> Way:
    """A street up to where it comes near another, and on to that; from the one it begins on it must first get away."""
    near = np.sqrt(((street[:, None, :] - others[None, :, :]) ** 2).sum(axis=2))
    least = near.min(axis=1)
    away = np.flatnonzero(least >= apart)
    if not len(away) or away[0] > 2.0 * apart / STEP:
        return street[:1]
    met = np.flatnonzero(least[away[0] :] < apart)
    if not len(met):
        return street
    end = int(away[0] + met[0])
    return np.concatenate([street[: end + 1], others[near[end].argmin()][None, :]])


def _ring(rng: Generator, shape: tuple[int, int]) -> Way:
    centre, radii = rng.uniform(0.1, 0.9, 2) * [shape[1], shape[0]], rng.uniform(2.5, 7.0, 2)
    around, turn = np.linspace(0.0, 2.0 * pi, 33), rng.uniform(0.0, pi)
    ring = np.column_stack([radii[0] * np.cos(around), radii[1] * np.sin(around)])
    return np.asarray(ring @ np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]]) + centre)


def _chord(rng: Generator, shape: tuple[int, int]) -> Way:
    """A straight avenue across the map."""
    start, heading = _from_edge(rng, shape)
    return np.array([start, start + 2.0 * sum(shape) * np.array([cos(heading), sin(heading)])])


def _from_edge(rng: Generator, shape: tuple[int, int]) -> tuple[NDArray[np.float64], float]:
    """A place on an edge of the map, and a heading inwards."""
    side, along = int(rng.integers(4)), rng.uniform(0.1, 0.9)
    height, width = shape
    places = ((along * width, 0.0), (width, along * height), (along * width, height), (0.0, along * height))
    return np.array(places[side], float), pi / 2.0 * (side + 1) + rng.uniform(-0.6, 0.6)


def _metres(ways: list[Way], shape: tuple[int, int]) -> float:
    """Length of ways on the map, in cells, by their middles."""
    length = 0.0
    for way in ways:
        middles = (way[:-1] + way[1:]) / 2.0
        inside = ((middles >= 0.0) & (middles <= [shape[1], shape[0]])).all(axis=1)
        length += float(np.hypot(*np.diff(way, axis=0).T)[inside].sum())
    return length


STREET_KINDS: dict[str, Callable[[Generator, tuple[int, int], float], list[Way]]] = {
    "gridiron": _gridiron,
    "suburb": _suburb,
    "park": _park,
}
