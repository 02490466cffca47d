"""From ground to a search over regions: what each action flies, how long it takes, what it looks at, what that pays."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sooner.decomposition.plow import coverage_paths
from sooner.decomposition.regions import Regions
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.grid.paths import distances_m, way
from sooner.motion.kinematics import Dynamics
from sooner.motion.rounded import rounded
from sooner.motion.trajectory import Trajectory
from sooner.problem.atoms import Footprints, Rows, atom_gains
from sooner.problem.common_atoms import common_atoms
from sooner.problem.gains import Gains
from sooner.problem.regions import RegionGraph, RegionMoves
from sooner.problem.search_problem import Objective, Searcher, SearchProblem
from sooner.sensors.footprint import cell_passes, swept_cells

__all__ = ["PRESET_A", "PRESET_B", "Place", "Sweep", "region_problem", "two_searches_s"]

LOOKS = 64
THREADS = 2  # that look for what is in view, the same whatever their number
LARGE = 1 << 20  # cells from which on they are worth it
CHUNK = 1 << 14  # looks whose times are worked out at once
Place = tuple[int, int]


@dataclass(frozen=True)
class Sweep:
    """How regions are searched: the drone, its sensor's reach, and how far apart it flies.

    Parameters
    ----------
    dynamics : Dynamics
    radius_m : float         cells with their centres so near to the path are in view
    spacing_m : float        between plow lines
    taut : bool              ways around obstacles are pulled tight; False: pruned by the paper's rule
    round_turns : bool       plow lines are joined by arcs instead of stops [Kuhlman2017, Fig. 4]
    looks : str              "passes": a cell is looked at each time that it comes into view, however the ground is
                             cut into regions; "actions": once in every action that sees it [Kuhlman2017, sec. 6.3]

    Notes
    -----
    A flight goes on where one action ends and the next begins, at a region's centre, and so does what is in view
    there. It is counted once: in a search, which comes back to where it began; not in an edge at all. So no plan is
    credited with more passes than its flight makes, except that every search looks at the cells that it never lets
    out of view; and a flight that passes through a region's centre without a search is credited with less: values are
    lower limits there, and bounds are bounds of what is credited. (To count those looks by visits of centres, which
    the numbers of edges tell, is left to do.)
    """

    dynamics: Dynamics = field(default_factory=lambda: Dynamics(2.0, 2.0))
    radius_m: float = 8.8
    spacing_m: float = 8.8
    taut: bool = True
    round_turns: bool = False
    looks: Literal["passes", "actions"] = "passes"

    def __post_init__(self) -> None:
        for name in ("radius_m", "spacing_m"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise InvalidProblemError(f"{name} = {getattr(self, name)} came; expected a positive number")
        if self.looks not in ("passes", "actions"):
            raise InvalidProblemError(f"looks = {self.looks!r} came; expected 'passes' or 'actions'")

    def flight(self, path: NDArray[np.float64]) -> Trajectory:
        """The path as it is flown."""
        if self.round_turns and len(path) > 2:
            return rounded(path, self.dynamics, deviation_m=self.spacing_m / 4)  # a reversal must not cut off its line
        return Trajectory.through(path, self.dynamics)

    def search(self, grid: Grid, regions: Regions, region: int) -> NDArray[np.float64]:
        """The fastest of the four coverage paths of a region."""
        return min(coverage_paths(grid, regions, region, self.spacing_m), key=lambda path: self.flight(path).duration)


PRESET_A = Sweep(Dynamics(2.0, 2.0), taut=False, looks="actions")
PRESET_B = Sweep(Dynamics(1.25, 1.25), spacing_m=17.6, taut=False, looks="actions")
"""What the paper leaves open, chosen so that its times (A) or its search efforts (B) come out."""


def region_problem(
    grid: Grid,
    regions: Regions,
    sweep: Sweep | Sequence[Sweep],
    gains: Gains | Rows,
    starts: Sequence[Place],
    budget_s: float | Sequence[float],
    ends: Sequence[Place | None] | None = None,
    objective: Objective | None = None,
) -> SearchProblem:
    """Pose a search over regions.

    Parameters
    ----------
    grid : Grid                square cells, 8 neighbours: ways between regions go diagonally
    sweep : Sweep or many      of all searchers, or of each: those who fly alike share a graph
    gains : Gains or callable  what looks at cells pays: (N, L), or a function of cell numbers (n,) that answers (n, L)
    starts : of (row, col)     one for each searcher; its walk begins at the centre of the nearest region
    budget_s : float or many   seconds of each searcher
    ends : of (row, col)       where each must come to rest; None: anywhere

    Raises
    ------
    InvalidProblemError        a start or end on an obstacle or in ground that no region can be reached from
    InfeasibleProblemError     too little time for any action
    """
    homes = list(ends or [None] * len(starts))
    budgets = [float(budget_s)] * len(starts) if np.isscalar(budget_s) else list(map(float, budget_s))  # type: ignore
    sweeps = [sweep] * len(starts) if isinstance(sweep, Sweep) else list(sweep)
    if not len(starts) == len(homes) == len(budgets) == len(sweeps):
        raise InvalidProblemError(
            f"{len(starts)} starts, {len(homes)} ends, {len(budgets)} budgets and {len(sweeps)} sweeps came; "
            "expected as many of each"
        )
    flying = {kind: [n for n, each in enumerate(sweeps) if each == kind] for kind in dict.fromkeys(sweeps)}
    flown = [
        _graph(grid, regions, kind, [starts[n] for n in team] + [homes[n] for n in team])
        for kind, team in flying.items()
    ]
    shared = common_atoms([graph.footprints for graph, _ in flown], grid.n_cells)
    of_kind = {kind: (*own, atoms) for kind, own, atoms in zip(flying, flown, shared, strict=True)}
    searchers = []
    for kind, start, end, budget in zip(sweeps, starts, homes, budgets, strict=True):
        graph, places, atoms = of_kind[kind]
        first, depart = places[start]
        last, back = (-1, -1) if end is None else (places[end][0], places[end][1] + 1 if places[end][1] >= 0 else -1)
        searchers.append(Searcher(start, budget, end, RegionMoves(graph, atoms, first, last, depart, back)))
    rows = _rows(gains) if isinstance(gains, Gains) else gains
    return SearchProblem(grid, atom_gains(shared[0], rows), tuple(searchers), objective or Objective())


def two_searches_s(problem: SearchProblem) -> float:
    """Twice the time that a search of every region takes, without ways between them [Kuhlman2017, sec. 7.2]."""
    moves = problem.searchers[0].moves
    assert isinstance(moves, RegionMoves)
    return 2.0 * float(moves.graph.seconds[: moves.graph.n_regions].sum())


def _rows(gains: Gains) -> Rows:
    looks = np.arange(max(LOOKS, gains.table.shape[1]))
    return lambda cells: gains.of(cells[:, None], looks)


def _graph(
    grid: Grid, regions: Regions, sweep: Sweep, wanted: Sequence[Place | None]
) -> tuple[RegionGraph, dict[Place, tuple[int, int]]]:
    """All that can be flown; and for each place the region it belongs to, and its leg there (the next is back)."""
    centres = regions.centres
    paths = [sweep.search(grid, regions, region) for region in range(regions.n_regions)]
    paths += [way(grid, int(centres[one]), int(centres[other]), sweep.taut) for one, other in regions.adjacency]
    places: dict[Place, tuple[int, int]] = {}
    for place in dict.fromkeys(place for place in wanted if place is not None):
        cell = grid.index(place)
        region = _region_of(grid, regions, cell)
        if cell == centres[region]:
            places[place] = region, -1
            continue
        places[place] = region, len(paths)
        there = way(grid, cell, int(centres[region]), sweep.taut)
        paths += [there, there[::-1]]
    kinds = ["search"] * regions.n_regions + ["edge"] * len(regions.adjacency)
    kinds += ["depart", "back"] * ((len(paths) - len(kinds)) // 2)
    flights = [sweep.flight(path) for path in paths]
    seconds = np.array([flight.duration for flight in flights])
    footprints = _footprints(grid, sweep, flights, kinds)
    graph = RegionGraph(
        regions.n_regions, regions.adjacency, _searchable(seconds, sweep), tuple(paths), footprints, regions.labels
    )
    return graph, places


def _searchable(seconds: NDArray[np.float64], sweep: Sweep) -> NDArray[np.float64]:
    """A region that is searched from its centre without moving still takes the time of a leg of one radius."""
    still = float(sweep.dynamics.leg_seconds(sweep.radius_m))
    return np.where(seconds > 0, seconds, still)


def _region_of(grid: Grid, regions: Regions, cell: int) -> int:
    """The region of a cell, or else the one whose ground is the shortest way off."""
    label = int(regions.labels.ravel()[cell]) if grid.passable[cell] else -1
    if label >= 0:
        return label
    if not grid.passable[cell]:
        raise InvalidProblemError(f"{list(grid.cell(cell))} came; an obstacle stands there")
    off = np.where(regions.labels.ravel() >= 0, distances_m(grid, cell), np.inf)
    nearest = int(np.argmin(off))
    if not np.isfinite(off[nearest]):
        raise InvalidProblemError(f"{list(grid.cell(cell))} came; no region can be reached from there")
    return int(regions.labels.ravel()[nearest])


def _footprints(grid: Grid, sweep: Sweep, flights: Sequence[Trajectory], kinds: Sequence[str]) -> Footprints:
    with ThreadPoolExecutor(THREADS if grid.n_cells >= LARGE else 1) as pool:
        seen = list(pool.map(lambda flown: _looks(grid, sweep, *flown), zip(flights, kinds, strict=True)))
    starts = np.cumsum([0, *(len(cells) for cells, _, _ in seen)])
    cells, ahead, behind = (list(each) for each in zip(*seen, strict=True))
    seen.clear()
    return Footprints(starts, _poured(cells), _poured(ahead), _poured(behind))


def _looks(
    grid: Grid, sweep: Sweep, flight: Trajectory, kind: str
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
    """Cells that one action looks at, and the seconds before each look, as it is flown and the other way round."""
    points, flown_m = flight.polyline()
    chords_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    seen, comes_m, goes_m = (_in_view if sweep.looks == "actions" else _passes)(grid, sweep, points, kind)
    cells = seen.astype(np.int32)
    del seen
    ahead, behind = np.empty((2, len(cells)), np.float32)
    for first in range(0, len(cells), CHUNK):  # what is in between stays in the processor's cache
        part = slice(first, first + CHUNK)
        ahead[part] = flight.times_at(np.interp(comes_m[part], chords_m, flown_m))
        behind[part] = flight.duration - flight.times_at(np.interp(goes_m[part], chords_m, flown_m))
    return cells, ahead, behind


_Seen = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]


def _in_view(grid: Grid, sweep: Sweep, points: NDArray[np.float64], kind: str) -> _Seen:
    """Cells in view, each once, with the metres at which it first is and last is."""
    seen, first_m = swept_cells(grid, points, sweep.radius_m)
    _, back_m = swept_cells(grid, points[::-1], sweep.radius_m)
    return seen, first_m, float(np.hypot(*np.diff(points, axis=0).T).sum()) - back_m


def _passes(grid: Grid, sweep: Sweep, points: NDArray[np.float64], kind: str) -> _Seen:
    """Cells as often as they come into view, with the metres between which they are; see `Sweep` for the ends."""
    seen, comes_m, goes_m = cell_passes(grid, points, sweep.radius_m)
    at_start, at_end = comes_m <= 1e-6, goes_m >= np.hypot(*np.diff(points, axis=0).T).sum() - 1e-6
    counted = {
        "search": at_start | ~at_end,
        "edge": ~at_start & ~at_end,
        "depart": np.ones(len(seen), bool),
        "back": ~at_start,
    }[kind]
    return seen[counted], comes_m[counted], goes_m[counted]


def _poured(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """All parts as one array; the list is emptied as it fills, as on large maps there is no room for both."""
    whole = np.empty(sum(map(len, parts)), parts[0].dtype)
    filled = len(whole)
    while parts:
        part = parts.pop()
        whole[filled - len(part) : filled] = part
        filled -= len(part)
    return whole
