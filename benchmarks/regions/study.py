"""Decompositions compared in pairs: the same ground, start, mission time and planner; rows go to a CSV as they come.

python benchmarks/regions/study.py --environments 1-20 --seconds 2      # goes on where it stopped
python benchmarks/regions/study.py --table                              # the table of the README
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from sooner.belief import EvidenceGrid
from sooner.campaigns.statistics import estimate
from sooner.decomposition import Regions, boustrophedon
from sooner.decomposition.aware import gain_classes, regions_for
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
COLUMNS = (
    "kind", "prior", "environment", "cut", "seconds", "regions", "actions", "atoms", "build_s", "bits", "early_share"
)  # fmt: skip


def plain(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return base


def bands(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return chunked(grid, base, 35.2, gain_classes(grid, first), min_m2=363.0)


def tiles(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return regions_for(grid, first, base)


def cells_of_voronoi(grid: Grid, base: Regions, first: np.ndarray) -> Regions:
    return voronoi(grid, first, 450.0, min_m2=150.0)


CUTS = {"plain": plain, "bands": bands, "tiles": tiles, "voronoi": cells_of_voronoi}


def flown(ground: NaturalEnvironment, cut: str, budget_s: float | None, seconds: float) -> dict[str, float]:
    """One decomposition of one ground, planned and judged; without a budget, only what two searches of it take."""
    gains = information_gains(EvidenceGrid(ground.theta), BinarySensor(0.85, 0.15))
    began = time.process_time()
    regions = CUTS[cut](ground.grid, boustrophedon(ground.grid), gains.first)
    problem = region_problem(ground.grid, regions, PRESET_A, gains, starts(ground, 1, 1), budget_s or 1e9)
    built = time.process_time() - began
    if budget_s is None:
        return {"budget_s": two_searches_s(problem)}
    found = evaluate(problem, solve(problem, RegionAnneal(), cpu_seconds(seconds)).best.plan)
    actions = regions.n_regions + len(regions.adjacency)
    return {
        "regions": regions.n_regions, "actions": actions, "atoms": problem.gains.n_cells, "build_s": round(built, 3),
        "bits": round(found.total, 2), "early_share": round(found.early_share, 4),
    }  # fmt: skip


def run(environments: range, seconds: float, path: Path) -> None:
    """All rows that the CSV has not yet."""
    done = {tuple(row[key] for key in COLUMNS[:5]) for row in read(path)}
    for number in environments:
        for prior in PRIORS:
            for kind in KINDS:
                keys = [(kind, prior, str(number), cut, str(seconds)) for cut in CUTS]
                if done.issuperset(keys):
                    continue
                ground = natural_environment(kind, number, nonuniform=prior == "nonuniform")
                budget_s = flown(ground, "plain", None, seconds)["budget_s"]
                for key in keys:
                    if key not in done:
                        row = dict(zip(COLUMNS[:5], key, strict=True)) | flown(ground, key[3], budget_s, seconds)
                        write(path, row)


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


def table(path: Path) -> str:
    """Bits against plain in pairs, %, with their 95 % intervals, and medians of the rest."""
    rows = read(path)
    value = {(row["kind"], row["prior"], row["cut"], row["environment"]): row for row in rows}
    lines = [
        "| class | prior | cut | n | bits against plain, % | early share | regions | actions | atoms | build, s |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for prior in PRIORS:
        for kind in KINDS:
            for cut in CUTS:
                own = {e: row for (k, p, c, e), row in value.items() if (k, p, c) == (kind, prior, cut)}
                base = {e: value.get((kind, prior, "plain", e)) for e in own}
                pairs = [(float(own[e]["bits"]), float(b["bits"])) for e, b in base.items() if b]
                if not pairs:
                    continue
                gained = estimate([100.0 * (ours / theirs - 1.0) for ours, theirs in pairs])
                cells = [f"{np.median([float(row[c]) for row in own.values()]):.4g}" for c in COLUMNS[5:9]]
                early = np.mean([float(row["early_share"]) for row in own.values()])
                lines.append(
                    f"| {kind} | {prior} | {cut} | {len(pairs)} | "
                    f"{gained.value:+.1f} [{gained.low:+.1f}, {gained.high:+.1f}] | {early:.3f} | {' | '.join(cells)} |"
                )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", default="1-20", help="first-last")
    parser.add_argument("--seconds", type=float, default=2.0, help="of processor time for each plan")
    parser.add_argument("--out", type=Path, default=HERE / "regions.csv")
    parser.add_argument("--table", action="store_true", help="print the table of what is there")
    given = parser.parse_args()
    if not given.table:
        first, last = map(int, given.environments.split("-"))
        run(range(first, last + 1), given.seconds, given.out)
    print(table(given.out))


if __name__ == "__main__":
    main()
