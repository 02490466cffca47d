"""A baseline from outside the field: the search posed as an orienteering problem and given to PyVRP.

N. A. Wouda, L. Lan, W. Kool, "PyVRP: a high-performance VRP solver package", INFORMS Journal on Computing 36 (2024),
943-955. Needs the extra `orienteering`.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.planners.planner import single_cell_searcher
from sooner.problem import Incumbent, Plan, Reach, SearchProblem, evaluate

__all__ = ["Orienteering", "fly"]

PRIZES = 10_000  # PyVRP counts in whole numbers: the best first look is worth this much, a tenth of its highest penalty


@dataclass(frozen=True)
class Orienteering:
    """Cells are clients with a prize, distances are steps, the battery is the most that one vehicle may drive.

    The prize of a client is what a first look at its cell pays; later looks, and looks at the cells between two
    clients, are not in the model. The matrix of distances is what limits it: only the `clients` best cells that can
    be reached take part. The tour that comes back is flown link by link along the shortest way that pays most, and
    steps left over go to the best next cell; so the plan is worth more than the model knew.

    Parameters
    ----------
    tour_seconds : float       of this process's own time, for PyVRP's iterated local search
    per_step : float           cells modelled for each step of the budget; more only slow PyVRP down
    clients : int              largest number of cells modelled; 1,000 make a matrix of a million distances
    """

    tour_seconds: float = 10.0
    per_step: float = 1.0
    clients: int = 1000

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher that may hover, over cells; and PyVRP installed."""
        if find_spec("pyvrp") is None:
            return "it needs PyVRP: pip install 'sooner[orienteering]'"
        unable = single_cell_searcher(problem)
        if unable is None and Reach(problem.grid, problem.searcher).fixed_wing:
            return "its links are shortest ways, which a fixed wing cannot always join"
        return unable

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield once."""
        cells = _candidates(problem, min(round(self.per_step * problem.searcher.steps), self.clients))
        tour = _tour(problem, cells, self.tour_seconds, int(rng.integers(2**31)))
        plan = Plan.of(fly(problem, cells[tour]))
        yield Incumbent(plan, evaluate(problem, plan).value)


def _candidates(problem: SearchProblem, limit: int) -> NDArray[np.int64]:
    """(n,) the best cells that can be reached in time, best first; the start is where the vehicle stands anyway."""
    reach = Reach(problem.grid, problem.searcher)
    first = problem.gains.first.copy()
    there = problem.grid.distances_from(reach.start)
    back = problem.grid.distances_from(reach.end) if reach.end >= 0 else np.zeros_like(there)
    first[(there < 0) | (back < 0) | (there + back > problem.searcher.steps)] = 0.0
    first[reach.start] = 0.0
    best = np.argsort(-first, kind="stable")[:limit]
    return np.asarray(best[first[best] > 0])


def _tour(problem: SearchProblem, cells: NDArray[np.int64], seconds: float, seed: int) -> NDArray[np.int64]:
    """Positions in `cells`, in the order in which PyVRP's vehicle visits them."""
    from pyvrp import Client, Depot, Location, ProblemData, VehicleType, solve
    from pyvrp.exceptions import PenaltyBoundWarning

    if cells.size == 0:
        return np.zeros(0, np.int64)
    steps = _steps_between(problem, cells)
    prizes = np.rint(problem.gains.first[cells] / problem.gains.first[cells].max() * PRIZES).astype(int)
    grid = problem.grid
    places = [Location(*grid.centres_m[cell]) for cell in (grid.index(problem.searcher.start), cells[0], *cells)]
    vehicle = VehicleType(start_depot=0, end_depot=1, max_distance=problem.searcher.steps, unit_distance_cost=1)
    data = ProblemData(
        places,
        [Client(location=n, prize=max(int(prize), 1), required=False) for n, prize in enumerate(prizes, 2)],
        [Depot(location=0), Depot(location=1)],
        [vehicle],
        [steps],
        [np.zeros_like(steps)],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PenaltyBoundWarning)  # `fly` leaves out what does not fit
        best = solve(data, _out_of_time(seconds), seed=seed, collect_stats=False, display=False).best
    return np.array([visit for route in best.routes() for visit in _clients(route)], np.int64)


def _out_of_time(seconds: float) -> Any:
    """What PyVRP asks after every iteration: whether to stop."""
    until = time.process_time() + seconds
    return lambda _: time.process_time() >= until


def _clients(route: Any) -> list[int]:
    return [activity.idx for activity in route if activity.is_client()]


def _steps_between(problem: SearchProblem, cells: NDArray[np.int64]) -> Any:
    """(n + 2, n + 2) steps: the start, the end and every cell. Without an end every flight ends where it is."""
    reach = Reach(problem.grid, problem.searcher)
    steps = np.zeros((len(cells) + 2, len(cells) + 2), np.int64)
    for row, cell in zip((0, *range(2, len(cells) + 2)), (reach.start, *cells), strict=True):
        there = problem.grid.distances_from(int(cell))
        steps[row, 0], steps[row, 2:] = there[reach.start], there[cells]
        steps[row, 1] = there[reach.end] if reach.end >= 0 else 0
    steps[1, :] = steps[:, 1] if reach.end >= 0 else 0
    return np.where(steps < 0, 10 * problem.searcher.steps + 10, steps)  # no way at all: further than any flight


def fly(problem: SearchProblem, tour: Sequence[int] | NDArray[np.int64]) -> list[int]:
    """The cells of a flight along `tour`: shortest links that pay most on their way, then the best next looks."""
    reach = Reach(problem.grid, problem.searcher)
    ahead = set(map(int, tour))
    looks = np.zeros(problem.grid.n_cells, np.int64)
    path = [reach.start]
    looks[reach.start] += 1
    for stop in [*map(int, tour), *([reach.end] if reach.end >= 0 else [])]:
        ahead.discard(stop)
        link = _link(problem.grid, path[-1], stop, _pay(problem, looks, ahead))
        left = problem.searcher.steps - len(path) + 1 - len(link)
        if left < 0 or not reach.can_go_on(stop, -1, left):
            continue  # PyVRP may answer with a tour that is too long: what does not fit is left out
        for cell in link:
            looks[cell] += 1
            path.append(cell)
    if reach.end < 0:
        _spend(problem, reach, path, looks)
    return path


def _pay(problem: SearchProblem, looks: NDArray[np.int64], ahead: set[int]) -> NDArray[np.float64]:
    """What the next look pays now; nothing where the tour will look anyway."""
    pay = problem.gains.of(np.arange(problem.grid.n_cells), looks)
    pay[list(ahead)] = 0.0
    return pay


def _link(grid: Grid, start: int, stop: int, pay: NDArray[np.float64]) -> list[int]:
    """Cells after `start` on the shortest way to `stop` that pays most: a staircase, by dynamic programming."""
    left = grid.distances_from(stop)
    layer: dict[int, tuple[float, int]] = {start: (0.0, -1)}
    layers = [layer]
    for steps in range(int(left[start]) - 1, -1, -1):
        following: dict[int, tuple[float, int]] = {}
        for cell, (paid, _) in layer.items():
            for near in map(int, grid.neighbours[cell]):
                if near >= 0 and left[near] == steps and following.get(near, (-1.0,))[0] < paid + pay[near]:
                    following[near] = (paid + float(pay[near]), cell)
        layer = following
        layers.append(layer)
    way = [stop]
    for layer in reversed(layers[1:]):
        way.append(layer[way[-1]][1])
    return way[-2::-1]


def _spend(problem: SearchProblem, reach: Reach, path: list[int], looks: NDArray[np.int64]) -> None:
    """Greedy to the end of the battery."""
    while len(path) <= problem.searcher.steps:
        here = path[-1]
        near = np.array([here, *(n for n in problem.grid.neighbours[here] if n >= 0)])
        path.append(int(near[np.argmax(problem.gains.of(near, looks[near]))]))
        looks[path[-1]] += 1
