"""What several drones keep of one drone that flies for all of them, planned by one computer.

python benchmarks/teams/central.py --environments 1-10 --seconds 3      # goes on where central.csv stops
python benchmarks/teams/central.py --table                              # the table of the README
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from pathlib import Path

from study import read, write

from sooner.belief import EvidenceGrid
from sooner.bounds import bounds
from sooner.campaigns.statistics import estimate
from sooner.decomposition import boustrophedon
from sooner.experiments.flight import cpu_seconds
from sooner.planners import solve
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.team import Team
from sooner.problem import SearchProblem
from sooner.problem.information_gains import information_gains
from sooner.problem.region_problem import PRESET_A, region_problem, two_searches_s
from sooner.scenarios.natural import natural_environment, starts
from sooner.sensors import BinarySensor

HERE = Path(__file__).parent
KINDS = "low", "med", "high", "vhf"
TEAMS = 2, 4, 8
COLUMNS = "kind", "environment", "searchers", "seconds", "bits", "joint", "single", "cpu_s"
INNER = RegionAnneal(moves=20_000, walks=4, longest=15)


def posed(kind: str, number: int, searchers: int) -> SearchProblem:
    """All start in one place; the paper's mission time is shared out among them."""
    ground = natural_environment(kind, number)
    gains = information_gains(EvidenceGrid(ground.theta), BinarySensor(0.85, 0.15))
    regions, places = boustrophedon(ground.grid), starts(ground, 1, 1) * searchers
    problem = region_problem(ground.grid, regions, PRESET_A, gains, places, 1e9)
    budget_s = two_searches_s(problem) / searchers
    return replace(problem, searchers=tuple(replace(each, budget=budget_s) for each in problem.searchers))


def top(problem: SearchProblem) -> float:
    """The best bound there is."""
    return min(found.value for found in bounds(problem))


def run(environments: Iterable[int], seconds: float, path: Path) -> None:
    """All rows that the CSV has not yet."""
    done = {tuple(row[key] for key in COLUMNS[:4]) for row in read(path)}
    for number, kind in product(environments, KINDS):
        keys = {(kind, str(number), str(searchers), str(seconds)): searchers for searchers in TEAMS}
        if done.issuperset(keys):
            continue
        single = top(posed(kind, number, 1))
        for key, searchers in keys.items():
            if key not in done:
                problem = posed(kind, number, searchers)
                began = time.process_time()
                value = solve(problem, Team(INNER), cpu_seconds(seconds), seed=number).best.value
                taken = time.process_time() - began
                numbers = round(value, 3), round(top(problem), 3), round(single, 3), round(taken, 2)
                write(path, dict(zip(COLUMNS, (*key, *numbers), strict=True)))


def table(path: Path) -> str:
    """Value in % of both bounds, means over environments with their 95 % intervals."""
    rows = read(path)
    lines = [
        "| class | drones | n | % of one drone's bound | % of the joint bound | CPU, s |",
        "|---|---|---|---|---|---|",
    ]
    for kind, searchers in product(KINDS, TEAMS):
        own = [row for row in rows if (row["kind"], row["searchers"]) == (kind, str(searchers))]
        if own:
            shares = [
                estimate([100.0 * float(row["bits"]) / float(row[bound]) for row in own])
                for bound in ("single", "joint")
            ]
            told = " | ".join(f"{share.value:.1f} [{share.low:.1f}, {share.high:.1f}]" for share in shares)
            took = sum(float(row["cpu_s"]) for row in own) / len(own)
            lines.append(f"| {kind} | {searchers} | {len(own)} | {told} | {took:.1f} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", default="1-10", help="first-last")
    parser.add_argument("--seconds", type=float, default=3.0, help="of processor time for each plan")
    parser.add_argument("--out", type=Path, default=HERE / "central.csv")
    parser.add_argument("--table", action="store_true", help="print the table of what is there")
    given = parser.parse_args()
    if not given.table:
        first, last = map(int, given.environments.split("-"))
        run(range(first, last + 1), given.seconds, given.out)
    print(table(given.out))


if __name__ == "__main__":
    main()
