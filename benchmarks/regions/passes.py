"""The same plans under a count of looks that does not know of actions: every pass in view of a cell is one look.

The judge counts at most one look at a cell in each action [Kuhlman2017, sec. 6.3]. A large region's search that sees a
cell from two plow lines is credited once; two small ones that do so are credited twice. So part of what smaller
regions gain is a matter of counting. Here looks are counted along the whole flight: a cell that comes into view, goes
out of it and comes again has been looked at twice, whoever flies.

    python benchmarks/regions/passes.py --environment 1 --seconds 1
"""

from __future__ import annotations

import argparse

import numpy as np
from study import CUTS, KINDS, PRIORS

from sooner.belief import EvidenceGrid
from sooner.decomposition import boustrophedon
from sooner.experiments.flight import cpu_seconds
from sooner.grid import Grid, rows_and_cols
from sooner.planners import solve
from sooner.planners.region_anneal import RegionAnneal
from sooner.problem.information_gains import information_gains
from sooner.problem.region_problem import PRESET_A, PRESET_B, region_problem, two_searches_s
from sooner.scenarios.natural import natural_environment, starts
from sooner.sensors import BinarySensor


def passes(grid: Grid, path: np.ndarray, radius_m: float, step_m: float = 1.0) -> np.ndarray:
    """(N,) int: how often each cell comes into view along a path, sampled every so many metres."""
    far = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    along = np.arange(0.0, far[-1], step_m)
    places = rows_and_cols(grid, np.stack([np.interp(along, far, axis) for axis in path.T], axis=-1))
    reach = int(radius_m / grid.cell_m) + 1
    rows, cols = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    found, last = np.zeros(grid.shape, int), np.full(grid.shape, -2)
    for n, (row, col) in enumerate(places):
        here = rows + round(row), cols + round(col)
        near = np.hypot(here[0] - row, here[1] - col) * grid.cell_m <= radius_m
        near &= (here[0] >= 0) & (here[0] < grid.shape[0]) & (here[1] >= 0) & (here[1] < grid.shape[1])
        seen = here[0][near], here[1][near]
        found[seen] += last[seen] < n - 1
        last[seen] = n
    return np.where(grid.passable, found.ravel(), 0)


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
