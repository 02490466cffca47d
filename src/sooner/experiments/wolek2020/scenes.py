"""What is searched in the study: the authors' maps, others like them, and the flight test."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from sooner.errors import DataFormatError, Fault
from sooner.grid import Grid
from sooner.io import read_street_map
from sooner.simulation import HALF_CELL, Estimator, Scene, World
from sooner.streets import OccupancyGraph

__all__ = ["FLIGHT_TEST", "scene", "three_blocks"]

FLIGHT_TEST = "flight test"
SIMULATED_S, FLOWN_S = 240, 300  # of a mission of the simulations, and of the flight test
REPLAN_S = {FLIGHT_TEST: 20}
KNOWN = ("map", "targets", "half_cell")


def scene(data: Path, instance: Mapping[str, Any], estimator: Estimator, seconds: int | None = None) -> Scene:
    """The scene of an instance, with the four agents of Table I   [Wolek2020, section IV].

    Parameters
    ----------
    data : Path             folder of the street maps
    instance : mapping      `map`, the name of a street map or "flight test"; `targets`, 1 if it is not said;
                            `half_cell`, whether the target sensor puts targets half a cell wrong
    seconds : int or None   of the mission; None for 240 s, and 300 s of the flight test

    Raises
    ------
    DataFormatError         an instance with other keys, or a map that cannot be read
    """
    if unknown := instance.keys() - set(KNOWN):
        raise DataFormatError(Fault("study", "instances", f"{min(unknown)!r} came", f"expected {', '.join(KNOWN)}"))
    name = str(instance["map"])
    world = _world(str(data), name, int(instance.get("targets", 1)))
    offset = HALF_CELL if instance.get("half_cell", False) else (0.0, 0.0)
    return _scene(world, estimator, seconds or (FLOWN_S if name == FLIGHT_TEST else SIMULATED_S), name, offset)


@lru_cache(maxsize=64)
def _scene(world: World, estimator: Estimator, seconds: int, name: str, offset: tuple[float, float]) -> Scene:
    replan_s = min(REPLAN_S.get(name, 5), seconds)
    return Scene(world, estimator=estimator, seconds=seconds, replan_s=replan_s, target_offset=offset)


@lru_cache(maxsize=16)
def _world(data: str, name: str, n_targets: int) -> World:
    """The streets of a name, made once in a process: what they are made of costs more than a trial."""
    graph = three_blocks() if name == FLIGHT_TEST else read_street_map(Path(data) / f"{name}.graph.json").graph
    return World(graph, n_targets=n_targets)


def three_blocks() -> OccupancyGraph:
    """Streets around three blocks: one to the west, two to the east of it, the northern one smaller.

    The flight test's streets are drawn in Fig. 5, not printed; these are ours. They are ten times the size of the
    test's 20 m, so that all of Table I holds as it stands: 0.5 m, 1.25 m and 0.3 m/s there are 5 m, 12.5 m and 3 m/s.

    >>> three_blocks().n_nodes, three_blocks().n_edges
    (141, 143)
    """
    grid = Grid((40, 40), "square8", 5.0)
    west, middle, east, north, between, south = 6, 19, 33, 7, 17, 32
    cells = {(row, col) for col in range(west, east + 1) for row in (north, south)}
    cells |= {(row, col) for row in range(north, south + 1) for col in (west, middle, east)}
    cells |= {(between, col) for col in range(middle, east + 1)}
    number = {cell: n for n, cell in enumerate(sorted(cells))}
    edges = [
        (number[row, col], number[row + down, col + right])
        for row, col in number
        for down, right in ((0, 1), (1, 0))
        if (row + down, col + right) in number
    ]
    return OccupancyGraph.of(grid, [grid.index(cell) for cell in number], edges)
