"""Sorties along legs (`LegAnneal`) on a scenario whose cells are cut finer, or left as they are."""

from __future__ import annotations

import numpy as np
import shapely
from cells import processor_seconds
from numpy.typing import NDArray
from router import shares

from sooner.experiments.sarenv import SAMPLE_M, Sarenv
from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace
from sooner.planners import solve
from sooner.planners.leg_anneal import LegAnneal
from sooner.planners.registry import make_planner
from sooner.problem import Searcher, SearchProblem
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, places_of
from sooner.sensors.swath import Swath

Way = NDArray[np.float64]

PACE = Pace(speed_mps=1.0, accel_mps2=np.inf)  # a second is a metre: SAREnv's budgets are lengths, corners cost nothing


def search(scenario: Sarenv, drones: int, metres: float, rows: int = 0, law: str = "seen") -> tuple[SearchProblem, Way]:
    """The scenario as a search, and where its frame lies in the scenario's: a perfect disc, from the centre and back.

    rows : int      of cells across the swath. 0 keeps the scenario's cells, which is SAREnv's measure: a cell is seen
                    when its centre is, from one of the points that lie 15 m apart. An odd number comes near to what
                    is truly swept; the cells are then a hair wider than 2 r / rows, so that no lane sees more rows
                    than its swath is wide
    law : str       "seen" by a cell's centre, or "edged", in part at the edge of what is in view
    """
    height, width = scenario.heat.shape
    cell_m, heat, origin = scenario.cell_m, scenario.heat, np.zeros(2)
    if rows:
        cell_m = 2 * scenario.radius_m / rows * (1 + 1e-6)
        north, east = (_axis(cells, scenario.cell_m, cell_m) for cells in (height, width))
        up, right = shares(height, scenario.cell_m, north, cell_m), shares(width, scenario.cell_m, east, cell_m)
        heat, origin = (up @ heat[::-1] @ right.T)[::-1], np.array([east[0], north[0]])
    grid = Grid(heat.shape, cell_m=cell_m)
    home = np.array(scenario.centre) - origin
    far = 2 * scenario.radius_m
    space = Airspace(shapely.box(-far, -far, grid.shape[1] * cell_m + far, grid.shape[0] * cell_m + far))
    radius_m = scenario.radius_m if rows else float(np.sqrt(scenario.radius_m**2 - (SAMPLE_M / 2) ** 2))
    swath = (Swath.seen if law == "seen" else Swath.edged)(grid, radius_m)
    moves = LegMoves(space, PACE, swath, tuple(home), tuple(home))
    middle = (grid.shape[0] // 2, grid.shape[1] // 2)
    searchers = tuple(Searcher(middle, metres / drones, moves=moves) for _ in range(drones))
    return SearchProblem(grid, effort_gains(heat), searchers), origin


def _axis(cells: int, side_m: float, fine_m: float) -> NDArray[np.float64]:
    """Centres of the fewest finer cells, along one axis, that cover the scenario."""
    many = int(np.ceil(cells * side_m / fine_m))
    return (cells - 1) * side_m / 2 + (np.arange(many) - (many - 1) / 2) * fine_m


def fly(
    scenario: Sarenv,
    drones: int,
    metres: float,
    rows: int,
    seconds: float,
    seed: int = 0,
    law: str = "seen",
    pattern: str | None = None,
) -> list[Way]:
    """The ways that are best after that much processor time of one thread; those of a manual's pattern, if named."""
    problem, origin = search(scenario, drones, metres, rows, law)
    planner = LegAnneal(threads=1) if pattern is None else make_planner(pattern)
    best = solve(problem, planner, stop=processor_seconds(seconds), seed=seed).best
    return [places_of(actions) + origin for actions in best.plan.actions]
