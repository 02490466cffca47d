"""Plans made for one look at a cell in each action, counted pass by pass: what of their gain is a matter of counting.

The paper counts at most one look at a cell in each action [Kuhlman2017, sec. 6.3]. A large region's search that sees a
cell from two plow lines is credited once; two small ones that do so are credited twice. Here looks are counted along
the whole flight: a cell that comes into view, goes out of it and comes again has been looked at twice, whoever flies.

    python benchmarks/regions/passes.py --environment 1 --seconds 1
"""

from __future__ import annotations

import argparse

import numpy as np
from study import CUTS, KINDS, PRIORS

from sooner.belief import EvidenceGrid
from sooner.decomposition import boustrophedon
from sooner.experiments.flight import cpu_seconds
from sooner.grid import Grid
from sooner.planners import solve
from sooner.planners.region_anneal import RegionAnneal
from sooner.problem.information_gains import information_gains
from sooner.problem.region_problem import PRESET_A, PRESET_B, region_problem, two_searches_s
from sooner.scenarios.natural import natural_environment, starts
from sooner.sensors import BinarySensor, cell_passes


def passes(grid: Grid, path: np.ndarray, radius_m: float) -> np.ndarray:
    """(N,) int: how often each cell comes into view along a path."""
    return np.bincount(cell_passes(grid, path, radius_m)[0], minlength=grid.n_cells)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environment", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=2.0, help="of processor time for each plan")
    parser.add_argument("--kinds", nargs="+", default=list(KINDS))
    given = parser.parse_args()
    print("| preset | class | prior | cut | judged, % of plain | by passes, % of plain |")
    print("|---|---|---|---|---|---|")
    for name, preset in (("A", PRESET_A), ("B", PRESET_B)):
        for kind in given.kinds:
            for prior in PRIORS:
                ground = natural_environment(kind, given.environment, nonuniform=prior == "nonuniform")
                gains = information_gains(EvidenceGrid(ground.theta), BinarySensor(0.85, 0.15))
                base, places = boustrophedon(ground.grid), starts(ground, 1, 1)
                budget_s = two_searches_s(region_problem(ground.grid, base, preset, gains, places, 1e9))
                plain = None
                for cut, regions in CUTS.items():
                    problem = region_problem(
                        ground.grid, regions(ground.grid, base, gains.first), preset, gains, places, budget_s
                    )
                    best = solve(problem, RegionAnneal(), cpu_seconds(given.seconds)).best
                    path = problem.searcher.moves.path(best.plan.actions[0])
                    looks = np.minimum(passes(ground.grid, path, preset.radius_m), gains.table.shape[1])
                    table = np.concatenate([np.zeros((len(looks), 1)), np.cumsum(gains.table, axis=1)], axis=1)
                    row = best.value, float(table[np.arange(len(looks)), looks].sum())
                    plain = plain or row
                    shares = " | ".join(
                        f"{100 * (ours / theirs - 1):+.1f}" for ours, theirs in zip(row, plain, strict=True)
                    )
                    print(f"| {name} | {kind} | {prior} | {cut} | {shares} |", flush=True)


if __name__ == "__main__":
    main()
