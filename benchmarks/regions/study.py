"""Decompositions compared in pairs: the same ground, start, mission time and planner; rows go to a CSV as they come.

python benchmarks/regions/study.py --environments 1-20                  # looks by passes; goes on where it stopped
python benchmarks/regions/study.py --environments 1-20 --looks actions  # as the paper counts them
python benchmarks/regions/study.py --table                              # the tables of the README
"""

from __future__ import annotations

import argparse
import csv
import time
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from sooner.belief import EvidenceGrid
from sooner.campaigns.statistics import estimate
from sooner.decomposition import Regions, boustrophedon
from sooner.decomposition.aware import gain_classes, regions_for, spacing_for
from sooner.decomposition.chunks import chunked
from sooner.decomposition.voronoi import voronoi
from sooner.experiments.flight import cpu_seconds
from sooner.grid import Grid
from sooner.planners import solve
from sooner.planners.region_anneal import RegionAnneal
from sooner.problem import evaluate
from sooner.problem.information_gains import information_gains
from sooner.problem.region_problem import PRESET_A, region_problem, two_searches_s
from sooner.scenarios.natural import NaturalEnvironment, natural_environment, starts
from sooner.sensors import BinarySensor

HERE = Path(__file__).parent
KINDS = "low", "med", "high", "vhf"
PRIORS = "nonuniform", "uniform"
KEYS = "looks", "share", "kind", "prior", "environment", "cut", "seconds"
COLUMNS = (*KEYS, "regions", "actions", "atoms", "build_s", "bits", "early_share", "freely_percent")


def plain(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return base


def aware(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return regions_for(grid, first, base)


def tiles(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return chunked(grid, base, 22.0, gain_classes(grid, first), min_m2=100.0, tall_m=22.0)


def cells_of_voronoi(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return voronoi(grid, first, 450.0, min_m2=150.0)


def large_cells_of_voronoi(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return voronoi(grid, first, 1800.0, min_m2=300.0)


CUTS = {
    "plain": plain, "aware": aware, "tiles": tiles, "voronoi": cells_of_voronoi, "large voronoi": large_cells_of_voronoi
}  # fmt: skip
ASKED = {  # by how looks are counted: shares of the mission time, priors and cuts
    "passes": ((1.0, 0.5, 0.25), ("nonuniform",), ("plain", "aware", "tiles", "large voronoi")),
    "actions": ((1.0,), PRIORS, ("plain", "aware", "tiles", "voronoi")),
}


def flown(ground: NaturalEnvironment, cut: str, looks: str, share: float, seconds: float) -> dict[str, float]:
    """One decomposition of one ground, planned and judged; the mission time is that of the plain one, or less."""
    gains = information_gains(EvidenceGrid(ground.theta), BinarySensor(0.85, 0.15))
    base, places = boustrophedon(ground.grid), starts(ground, 1, 1)
    time_s = share * two_searches_s(region_problem(ground.grid, base, PRESET_A, gains, places, 1e9))
    spacing_m = PRESET_A.radius_m
    if looks == "passes":  # as missions do
        swept_m2 = time_s * PRESET_A.dynamics.v_max * spacing_m
        spacing_m = spacing_for(spacing_m, swept_m2, float(ground.grid.passable.sum()) * ground.grid.cell_m**2)
    sweep = replace(PRESET_A, looks=looks, spacing_m=spacing_m)
    began = time.process_time()
    regions = CUTS[cut](ground.grid, base, gains.first)
    problem = region_problem(ground.grid, regions, sweep, gains, places, time_s)
    built = time.process_time() - began
    plan = solve(problem, RegionAnneal(), cpu_seconds(seconds)).best.plan
    found = evaluate(problem, plan)
    looked = int(problem.searcher.moves.cell_looks(problem.grid, plan.actions[0]).sum())
    freely = np.sort(gains.table[problem.grid.passable].ravel())[::-1][:looked].sum()
    return {
        "regions": regions.n_regions, "actions": regions.n_regions + len(regions.adjacency),
        "atoms": problem.gains.n_cells, "build_s": round(built, 3), "bits": round(found.total, 2),
        "early_share": round(found.early_share, 4), "freely_percent": round(100 * (freely / found.total - 1), 2),
    }  # fmt: skip


def run(environments: range, looks: str, seconds: float, path: Path) -> None:
    """All rows that the CSV has not yet."""
    done = {tuple(row[key] for key in KEYS) for row in read(path)}
    shares, priors, cuts = ASKED[looks]
    for number in environments:
        for prior in priors:
            for kind in KINDS:
                ground = natural_environment(kind, number, nonuniform=prior == "nonuniform")
                for share in shares:
                    for cut in cuts:
                        key = (looks, str(share), kind, prior, str(number), cut, str(seconds))
                        if key not in done:
                            write(path, dict(zip(KEYS, key, strict=True)) | flown(ground, cut, looks, share, seconds))


def read(path: Path) -> list[dict[str, str]]:
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def write(path: Path, row: dict[str, object]) -> None:
    begun = path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if not begun:
            writer.writeheader()
        writer.writerow(row)


def table(path: Path, looks: str) -> str:
    """Bits against plain in pairs, %, with their 95 % intervals, and medians of the rest."""
    rows = [row for row in read(path) if row["looks"] == looks]
    value = {tuple(row[key] for key in ("share", "prior", "kind", "cut", "environment")): row for row in rows}
    lines = [
        "| time | prior | class | cut | n | bits against plain, % | freely, % | early share | regions | atoms |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    shares, priors, cuts = ASKED[looks]
    for share, prior, kind, cut in product(map(str, shares), priors, KINDS, cuts):
        own = {key[4]: row for key, row in value.items() if key[:4] == (share, prior, kind, cut)}
        base = {e: value.get((share, prior, kind, "plain", e)) for e in own}
        pairs = [(float(own[e]["bits"]), float(b["bits"])) for e, b in base.items() if b]
        if not pairs:
            continue
        gained = estimate([100.0 * (ours / theirs - 1.0) for ours, theirs in pairs])
        middle = {name: np.median([float(row[name]) for row in own.values()]) for name in COLUMNS[7:]}
        lines.append(
            f"| {share} | {prior} | {kind} | {cut} | {len(pairs)} | "
            f"{gained.value:+.1f} [{gained.low:+.1f}, {gained.high:+.1f}] | {middle['freely_percent']:+.1f} | "
            f"{middle['early_share']:.3f} | {middle['regions']:.0f} | {middle['atoms']:.0f} |"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", default="1-20", help="first-last")
    parser.add_argument("--looks", choices=list(ASKED), default="passes")
    parser.add_argument("--seconds", type=float, default=1.0, help="of processor time for each plan")
    parser.add_argument("--out", type=Path, default=HERE / "regions.csv")
    parser.add_argument("--table", action="store_true", help="print the tables of what is there")
    given = parser.parse_args()
    if not given.table:
        first, last = map(int, given.environments.split("-"))
        run(range(first, last + 1), given.looks, given.seconds, given.out)
    for looks in ASKED if given.table else [given.looks]:
        print(table(given.out, looks), end="\n\n")


if __name__ == "__main__":
    main()
