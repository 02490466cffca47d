"""What links are worth to a team that plans for itself: against central planning, over range and loss.

python benchmarks/teams/study.py --environments 1-5                   # goes on where teams.csv stops
python benchmarks/teams/study.py --table                              # the table of the README
"""

from __future__ import annotations

import argparse
import csv
import time
from dataclasses import replace
from itertools import product
from math import inf
from pathlib import Path

import numpy as np

from sooner.belief import EvidenceGrid
from sooner.bounds import bounds
from sooner.campaigns.statistics import estimate
from sooner.decomposition import boustrophedon
from sooner.planners import solve
from sooner.planners.decentralised import Decentralised, Exchange, Links
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.team import Team
from sooner.problem import SearchProblem
from sooner.problem.information_gains import information_gains
from sooner.problem.region_problem import PRESET_A, region_problem, two_searches_s
from sooner.scenarios.natural import natural_environment, starts
from sooner.sensors import BinarySensor

HERE = Path(__file__).parent
KINDS = "low", "vhf"
TEAMS = 2, 4, 8
RANGES_M = 0.0, 50.0, 100.0, 200.0, inf
LOSSES = 0.0, 0.5, 0.9
COLUMNS = (
    "kind", "environment", "searchers", "range_m", "loss", "relays", "bits", "central", "bound", "sent", "lost",
    "known", "cpu_s",
)  # fmt: skip
INNER = RegionAnneal(moves=20_000, walks=4, threads=1, longest=15)
TICKS, ROUNDS = 15, 2


def posed(kind: str, number: int, searchers: int) -> SearchProblem:
    """Starts are free cells drawn at random; the paper's mission time is shared out among the searchers."""
    ground = natural_environment(kind, number)
    gains = information_gains(EvidenceGrid(ground.theta), BinarySensor(0.85, 0.15))
    regions, places = boustrophedon(ground.grid), starts(ground, searchers, number)
    problem = region_problem(ground.grid, regions, PRESET_A, gains, places, 1e9)
    budget_s = two_searches_s(problem) / searchers
    return replace(problem, searchers=tuple(replace(each, budget=budget_s) for each in problem.searchers))


def links() -> list[Links]:
    """Range at no loss, loss at all ranges, and one case without relays."""
    found = [Links(range_m, loss) for range_m, loss in product(RANGES_M, LOSSES) if range_m or not loss]
    return [*found, Links(100.0, 0.0, relays=False), Links(inf, 0.5, relays=False)]


def flown(problem: SearchProblem, link: Links, seed: int) -> Exchange:
    """One team, planned by itself."""
    told: list[Exchange] = []
    solve(problem, Decentralised(INNER, link, ROUNDS, TICKS, tell=told.append), seed=seed)
    return told[0]


def run(environments: range, path: Path) -> None:
    """All rows that the CSV has not yet."""
    done = {tuple(row[key] for key in COLUMNS[:6]) for row in read(path)}
    for number, kind, searchers in product(environments, KINDS, TEAMS):
        keys = {(kind, str(number), str(searchers), *_key(link)): link for link in links()}
        if done.issuperset(keys):
            continue
        problem = posed(kind, number, searchers)
        central = solve(problem, Team(INNER, ROUNDS, TICKS), seed=number).best.value
        bound = min(found.value for found in bounds(problem))
        for key, link in keys.items():
            if key in done:
                continue
            began = time.process_time()
            exchange = flown(problem, link, number)
            taken = round(time.process_time() - began, 3)
            others = searchers * (searchers - 1)
            known = (exchange.knows.sum() - searchers) / others
            numbers = round(exchange.value, 3), round(central, 3), round(bound, 3), exchange.sent, exchange.lost
            write(path, dict(zip(COLUMNS, (*key, *numbers, round(float(known), 4), taken), strict=True)))


def read(path: Path) -> list[dict[str, str]]:
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def write(path: Path, row: dict[str, object]) -> None:
    begun = path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, list(row))
        if not begun:
            writer.writeheader()
        writer.writerow(row)


def table(path: Path) -> str:
    """Value of the teams' flights in % of central planning, mean over environments with its 95 % interval."""
    rows = read(path)
    teams = list(product(KINDS, TEAMS))
    value = {tuple(row[key] for key in COLUMNS[:6]): row for row in rows}
    whole = [
        number
        for number in sorted({row["environment"] for row in rows})
        if all((kind, number, str(n), *_key(link)) in value for kind, n in teams for link in links())
    ]
    lines = [
        f"Environments {', '.join(whole)}.",
        "",
        "| range, m | loss | relays | " + " | ".join(f"{kind}, {n} drones" for kind, n in teams) + " |",
        "|---" * (3 + len(teams)) + "|",
    ]
    for link in links():
        found = [[value[kind, number, str(n), *_key(link)] for number in whole] for kind, n in teams]
        shares = [estimate([100.0 * float(row["bits"]) / float(row["central"]) for row in own]) for own in found]
        told = " | ".join(f"{share.value:.1f} [{share.low:.1f}, {share.high:.1f}]" for share in shares)
        range_m = "all" if link.range_m == inf else f"{link.range_m:g}"
        lines.append(f"| {range_m} | {link.loss:g} | {'yes' if link.relays else 'no'} | {told} |")
    first = [[value[kind, number, str(n), *_key(links()[0])] for number in whole] for kind, n in teams]
    tops = [100.0 * np.mean([float(row["central"]) / float(row["bound"]) for row in own]) for own in first]
    lines.append("| central, % of the joint bound | | | " + " | ".join(f"{top:.1f}" for top in tops) + " |")
    return "\n".join(lines)


def _key(link: Links) -> tuple[str, str, str]:
    return str(link.range_m), str(link.loss), str(link.relays)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", default="1-5", help="first-last")
    parser.add_argument("--out", type=Path, default=HERE / "teams.csv")
    parser.add_argument("--table", action="store_true", help="print the table of what is there")
    given = parser.parse_args()
    if not given.table:
        first, last = map(int, given.environments.split("-"))
        run(range(first, last + 1), given.out)
    print(table(given.out))


if __name__ == "__main__":
    main()
