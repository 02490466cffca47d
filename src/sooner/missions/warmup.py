"""Warm-up: tiny missions through every planner and every bound, so that all kernels are compiled and cached."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
import shapely

from sooner.belief import EvidenceGrid
from sooner.bounds import bounds
from sooner.decomposition import boustrophedon, regions_for
from sooner.errors import SoonerError
from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace
from sooner.planners import max_ticks, solve
from sooner.planners.region_early import brought_forward
from sooner.planners.region_greedy import RegionGreedy
from sooner.planners.registry import PLANNERS
from sooner.plotting import draw_plan
from sooner.problem import CellMoves, Plan, Searcher, SearchProblem, evaluate, information_gains
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves
from sooner.problem.region_problem import Sweep, region_problem
from sooner.scenarios import bimodal, street_grid
from sooner.sensors import BinarySensor
from sooner.sensors.swath import Swath
from sooner.simulation import Agent, Estimator, Scene, World, simulate
from sooner.simulation.strategies import STRATEGIES, make_strategy
from sooner.streets import Evasive

__all__ = ["warm_up"]

LEG_TICKS = 24  # first routes take as many
BOUNDS = 60  # more than it takes for every kernel of every proof to have had its turn on a small map


def warm_up() -> Iterator[str]:
    """Yield the name of each planner, of the bounds and of what comes after, once they are compiled and cached."""
    regions, legs, problems = _regions(), _legs(), _problems()
    for problem in problems:
        for _ in islice(bounds(problem, 0.5 * problem.teleport.value), BOUNDS):
            pass
    for others in (regions, legs):
        for _ in islice(bounds(others), BOUNDS):
            pass
    yield "bounds"
    for name, entry in PLANNERS.items():
        for problem in (*problems, regions, legs):
            try:
                planner = entry.make()
                if planner.handles(problem) is None:
                    solve(problem, planner, stop=max_ticks(LEG_TICKS if problem is legs else 3))
            except SoonerError:  # a small map may be too small for it
                continue
        yield name
    brought_forward(regions, solve(regions, RegionGreedy()).best.plan, walks=1, moves=200)
    yield "brought forward"
    start = Plan.of([problems[0].grid.index(problems[0].searcher.start)])
    draw_plan(evaluate(problems[0], start), start, np.full(problems[0].grid.shape, 1.0 / problems[0].grid.n_cells))
    yield "picture"
    _fly_streets()
    yield "simulation"


def _fly_streets() -> None:
    """Some seconds over a few streets: every strategy and both detectors, with every prior."""
    world, agents = World(street_grid("gridiron", 0, (20, 20)), evasive=Evasive(np.empty((0, 2)))), (Agent(),) * 2
    for detector, prior in (("lrdt", "uniform"), ("lrdt", "known"), ("cbht", "kriged")):
        scene = Scene(world, agents, Estimator(detector, prior), seconds=20)  # type: ignore[arg-type]
        for name in STRATEGIES:
            simulate(scene, make_strategy(name), seed=0)
    simulate(Scene(replace(world, evasive=None), agents, seconds=10), make_strategy("random"), seed=0)


def _legs() -> SearchProblem:
    """Ground with a zone in it that nothing flies over, for two sorties that come home."""
    grid = Grid((16, 24), "square8", 10.0)
    space = Airspace(shapely.box(-5, -5, 235, 155).difference(shapely.box(80, 60, 120, 100)))
    swath = Swath.of_width(grid, 30.0, 20.0)
    moves = LegMoves(space, Pace(10.0, 2.0), swath, (20.0, 20.0), (20.0, 20.0))
    gains = effort_gains(np.full(grid.n_cells, 1.0 / grid.n_cells))
    return SearchProblem(grid, gains, (Searcher((13, 2), 60.0, (13, 2), moves),) * 2)


def _regions() -> SearchProblem:
    """Ground with an obstacle in it, cut into regions, for a drone that has to come home; gains of both kinds."""
    rock = np.zeros((24, 48), bool)
    rock[8:16, 16:30] = True
    grid = Grid(rock.shape, "square8", 2.0, rock)
    theta = np.linspace(0.1, 0.9, grid.n_cells).reshape(grid.shape)
    gains = information_gains(EvidenceGrid(theta), BinarySensor(0.85, 0.15))
    regions = regions_for(grid, gains.first, boustrophedon(grid, min_cells=9, min_columns=2, at_width=48))
    return region_problem(grid, regions, Sweep(round_turns=True), gains, [(2, 3)], 240.0, [(2, 3)])


def _problems() -> tuple[SearchProblem, ...]:
    """A copter, a fixed wing, and both with an end cell: the kinds of flight that kernels tell apart."""
    copter = bimodal(size=24).problem(steps=40)
    there = replace(copter.searcher, end=copter.searcher.start)
    wing = replace(copter.searcher, moves=CellMoves("fixed_wing"))
    rocks = np.zeros(copter.grid.shape, bool)
    rocks[0, 0] = True
    return (
        copter,
        replace(copter, searchers=(there,), grid=Grid(copter.grid.shape, obstacles=rocks)),
        replace(copter, searchers=(wing,)),
        replace(copter, searchers=(replace(there, moves=CellMoves("fixed_wing")),)),
    )
