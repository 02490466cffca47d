"""What planning over regions costs as maps get finer and regions more: seconds, memory, and how good plans are.

    python benchmarks/regions/scale.py cells                    # Experiment 2's ground in 4,608 to 320,000 cells
    python benchmarks/regions/scale.py million --cut tiles      # twenty million cells, from ground to plan
    python benchmarks/regions/scale.py regions --wide 8         # 800 x 1,600 cells of 2.2 m: some 3,000 regions
    python benchmarks/regions/scale.py cuts                     # decompositions alone, 0.3, 2 and 20 million cells

Each is a process of its own; memory is the most that it ever held (`ru_maxrss`), libraries and kernels included.
Kernels are loaded first, on a small map, and not counted as time.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sooner.belief import EvidenceGrid, information, look_information
from sooner.bounds.region_lp import RegionLP
from sooner.bounds.region_network import RegionNetwork
from sooner.decomposition import Regions, boustrophedon
from sooner.decomposition.aware import regions_for
from sooner.decomposition.voronoi import voronoi
from sooner.experiments.flight import cpu_seconds
from sooner.grid import Grid
from sooner.planners import solve
from sooner.planners.branch_and_bound import BranchAndBound
from sooner.planners.depth_first import relaxation
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.stop import StopRule, max_seconds, max_ticks
from sooner.problem import SearchProblem
from sooner.problem.information_gains import information_gains
from sooner.problem.region_ground import RegionGround
from sooner.problem.region_problem import PRESET_A, region_problem, two_searches_s
from sooner.scenarios.natural import (
    CELL_M,
    EXPERIMENT_2_CELLS,
    NaturalEnvironment,
    experiment_2,
    natural_environment,
    starts,
)
from sooner.sensors import BinarySensor

SENSOR, LOOKS = BinarySensor(0.85, 0.15), 64
Cut = Callable[[Grid, NDArray[np.float64]], Regions]


def cell_m_of(n_cells: int) -> float:
    """Metres of a cell where the paper's 220 m x 440 m are so many."""
    return float(CELL_M * np.sqrt(20_000 / n_cells))


CUTS: dict[str, Cut] = {
    "plain": lambda grid, first: boustrophedon(grid),
    "tiles": regions_for,
    "voronoi": lambda grid, first: voronoi(grid, first, 450.0, min_m2=150.0),
}


class Stages:
    """Wall seconds, processor seconds and memory of one stage after another, printed as they end."""

    def __init__(self) -> None:
        print("| stage | wall, s | processor, s | most memory so far, MB |\n|---|---:|---:|---:|")
        self.wall = self.cpu = 0.0

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        wall, cpu = time.perf_counter(), time.process_time()
        yield
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        self.wall, self.cpu = self.wall + wall, self.cpu + cpu
        row(name, f"{wall:.2f}", f"{cpu:.2f}", f"{peak_mb():.0f}")

    def total(self) -> None:
        row("in all", f"{self.wall:.2f}", f"{self.cpu:.2f}", f"{peak_mb():.0f}")


def row(*cells: object) -> None:
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def peak_mb() -> float:
    """The most memory that this process ever held."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def million(n_cells: int, cut: str, number: int, seconds: float) -> None:
    """All stages from ground to plan, each cell with its own gains by a function of its number."""
    through(natural_environment("vhf", number, (48, 96), nonuniform=True), cut, max_ticks(3), None)
    stages = Stages()
    height = round(np.sqrt(n_cells / 2))
    with stages.stage("ground, obstacles and prior"):
        ground = natural_environment("vhf", number, (height, 2 * height), cell_m_of(2 * height**2), nonuniform=True)
    problem, value = through(ground, cut, max_seconds(seconds), stages)
    stages.total()
    moves = problem.searcher.moves
    print(
        f"\n{ground.grid.n_cells:,} cells, cut {cut}: {moves.graph.n_regions} regions, {moves.graph.n_edges} ways, "
        f"{problem.gains.n_cells:,} atoms, {len(moves.graph.footprints.cells):,} cells in footprints; {value:.6g} bits"
    )


def through(ground: NaturalEnvironment, cut: str, stop: StopRule, stages: Stages | None) -> tuple[SearchProblem, float]:
    """Cut the ground, pose the problem, plan."""
    stage = stages.stage if stages else lambda name: nullcontext()
    with stage("gains of first looks"):
        theta = ground.theta.ravel()
        first = look_information(theta, SENSOR.detect, SENSOR.false_alarm)
    with stage("regions"):
        regions = CUTS[cut](ground.grid, first)
    with stage("flights, footprints, atoms, gains"):
        del first

        def rows(cells: NDArray[np.int64]) -> NDArray[np.float64]:
            return information(theta[cells], LOOKS, SENSOR.detect, SENSOR.false_alarm)

        problem = region_problem(ground.grid, regions, PRESET_A, rows, starts(ground, 1, 1), 10_000.0)
    with stage("plan"):
        value = solve(problem, RegionAnneal(), stop).best.value
    return problem, value


def cells(numbers: range) -> None:
    """One ground in more and more cells: what building takes, and what planning takes that does the same."""
    print(f"Environments {numbers.start} to {numbers.stop - 1}, means; processor seconds.\n")
    row("cells", "regions", "atoms", "build", "relaxation", "branch and bound", "iterations", "20 ticks of annealing")
    row(*["---:"] * 8)
    cells_row(numbers.start, EXPERIMENT_2_CELLS[0])  # loads kernels
    for n_cells in EXPERIMENT_2_CELLS:
        means = np.mean([cells_row(number, n_cells) for number in numbers], axis=0)
        row(*(f"{mean:.4g}" if mean < 1000 else f"{mean:,.0f}" for mean in means))


def cells_row(number: int, n_cells: int) -> list[float]:
    """Regions, atoms and seconds of one ground."""
    ground = experiment_2(number, n_cells)
    gains = information_gains(EvidenceGrid(ground.theta), SENSOR)
    clock = [time.process_time()]
    regions, places = boustrophedon(ground.grid), starts(ground, 1, 1)
    problem = region_problem(ground.grid, regions, PRESET_A, gains, places, 10_000.0)
    clock.append(time.process_time())
    relaxation(RegionGround.of(problem))
    clock.append(time.process_time())
    *_, last = BranchAndBound(eta=0.0).searched(problem, np.random.default_rng(1))
    clock.append(time.process_time())
    solve(problem, RegionAnneal(), max_ticks(20))
    clock.append(time.process_time())
    built, relaxed, branched, annealed = np.diff(clock)
    return [n_cells, regions.n_regions, problem.gains.n_cells, built, relaxed, branched, last.iterations, annealed]


def regions(wide: int, number: int, seconds: float, bound_s: float) -> None:
    """More ground of one kind: what annealing reaches of the relaxed plan, and of a bound where there is time."""
    solve(wide_problem(1, number), RegionAnneal(), max_ticks(3))  # loads kernels
    problem = wide_problem(wide, number)
    moves, reference = problem.searcher.moves, relaxation(RegionGround.of(problem))[0]
    print(f"{moves.graph.n_regions} regions, {moves.graph.n_edges} ways, {problem.gains.n_cells:,} atoms", flush=True)
    began = time.process_time()
    best = solve(problem, RegionAnneal(), cpu_seconds(seconds)).best.value
    row(f"plan, {time.process_time() - began:.0f} s", f"{100 * best / reference:.3f} % of the relaxed plan")
    began = time.process_time()
    for bound, _ in RegionLP().solutions(RegionNetwork.of(problem)) if bound_s > 0 else ():
        spent = time.process_time() - began
        row(f"bound, {spent:.1f} s", f"{100 * bound / reference:.3f} %, the plan {100 * best / bound:.3f} % of it")
        if spent > bound_s:
            break


def wide_problem(wide: int, number: int) -> SearchProblem:
    """vhf ground of 100 x 200 cells of 2.2 m, so many times as long and as wide, with T_max as in the paper."""
    ground = natural_environment("vhf", number, (100 * wide, 200 * wide))
    gains = information_gains(EvidenceGrid(ground.theta), SENSOR)
    cut = boustrophedon(ground.grid, at_width=200.0 * wide)
    problem = region_problem(ground.grid, cut, PRESET_A, gains, starts(ground, 1, 1), 1e7)
    return replace(problem, searchers=(replace(problem.searcher, budget=two_searches_s(problem)),))


def cuts(number: int) -> None:
    """What decompositions alone take, in processor seconds."""
    row("cells", *CUTS)
    row("---:", *["---:"] * len(CUTS))
    for n_cells in (4_608, 320_000, 2_000_000, 20_480_000):  # the first loads kernels
        height = round(np.sqrt(n_cells / 2))
        ground = natural_environment("vhf", number, (height, 2 * height), cell_m_of(2 * height**2), nonuniform=True)
        first = look_information(ground.theta.ravel(), SENSOR.detect, SENSOR.false_alarm)
        spent = []
        for cut in CUTS.values():
            began = time.process_time()
            cut(ground.grid, first)
            spent.append(f"{time.process_time() - began:.2f}")
        row(f"{ground.grid.n_cells:,}", *spent)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    sub = parser.add_subparsers(dest="what", required=True)
    one = sub.add_parser("cells")
    one.add_argument("--environments", default="1-5", help="first-last")
    one = sub.add_parser("million")
    one.add_argument("--cells", type=int, default=20_480_000)
    one.add_argument("--cut", choices=CUTS, default="plain")
    one.add_argument("--environment", type=int, default=1)
    one.add_argument("--seconds", type=float, default=1.0, help="for the plan")
    one = sub.add_parser("regions")
    one.add_argument("--wide", type=int, default=8)
    one.add_argument("--environment", type=int, default=1)
    one.add_argument("--seconds", type=float, default=120.0, help="of processor time, of both threads together")
    one.add_argument("--bound", type=float, default=0.0, help="processor seconds after which no round begins")
    one = sub.add_parser("cuts")
    one.add_argument("--environment", type=int, default=1)
    given = parser.parse_args()
    if given.what == "cells":
        first, last = map(int, given.environments.split("-"))
        cells(range(first, last + 1))
    elif given.what == "million":
        million(given.cells, given.cut, given.environment, given.seconds)
    elif given.what == "regions":
        regions(given.wide, given.environment, given.seconds, given.bound)
    else:
        cuts(given.environment)


if __name__ == "__main__":
    main()
