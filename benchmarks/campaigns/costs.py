"""What a million trials of each planner of a study cost, from ledgers of trials that were flown.

    python benchmarks/campaigns/costs.py OUT/trials.sqlite [...] [--price 0.045] [--trials 1000000]

For each case the median over its trials of CPU and wall seconds, for each planner the mean of that over its cases: the
first trial in a process loads kernels, which a median leaves out where a case has three trials or more, and which a
million trials do not notice. Trials flown alone, for tables of times, are left out. `peak MB` is the most that a
process had resident while it flew one, what it kept of earlier trials included. Core hours are CPU hours; dollars are
core hours at a price that you replace by yours.
"""

from __future__ import annotations

import argparse
import sqlite3
from collections import defaultdict
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median

PRICE = 0.045  # US dollars a core hour: an assumption
DONE = 2
ROWS = """
SELECT planner, case_id, cpu_s, wall_s, memory_mb FROM trials JOIN cases ON cases.id = case_id
WHERE state = ? AND NOT alone ORDER BY trials.id
"""


@dataclass(frozen=True)
class Cost:
    planner: str
    cases: int
    trials: int
    fewest: int
    cpu_s: float
    wall_s: float
    memory_mb: float

    def core_hours(self, trials: int) -> float:
        return self.cpu_s * trials / 3600.0


def costs(ledgers: list[Path]) -> list[Cost]:
    taken: dict[str, dict[tuple[int, int], list[tuple[float, float, float]]]] = defaultdict(lambda: defaultdict(list))
    for number, ledger in enumerate(ledgers):
        with closing(sqlite3.connect(f"{ledger.resolve().as_uri()}?mode=ro", uri=True)) as base:
            for planner, case, *row in base.execute(ROWS, (DONE,)):
                taken[planner][number, case].append(tuple(row))
    return [_cost(planner, list(cases.values())) for planner, cases in taken.items()]


def _cost(planner: str, cases: list[list[tuple[float, float, float]]]) -> Cost:
    cpu, wall = (mean(median(trial[part] for trial in case) for case in cases) for part in (0, 1))
    memory = max(trial[2] for case in cases for trial in case)
    return Cost(planner, len(cases), sum(map(len, cases)), min(map(len, cases)), cpu, wall, memory)


def table(found: list[Cost], trials: int, price: float) -> str:
    """A Markdown table, the dearest last."""
    head = ["planner", "cases", "trials", "CPU s", "wall s", "peak MB", "core hours", f"at {price} USD"]
    lines = ["| " + " | ".join(head) + " |", "|---|" + "---:|" * (len(head) - 1)]
    for cost in sorted(found, key=lambda each: each.cpu_s):
        hours = cost.core_hours(trials)
        marked = "" if cost.fewest > 2 else " *"
        numbers = [f"{cost.cpu_s:.3g}{marked}", f"{cost.wall_s:.3g}", f"{cost.memory_mb:.0f}", _round(hours)]
        cells = [cost.planner, str(cost.cases), str(cost.trials), *numbers, _round(hours * price)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _round(number: float) -> str:
    """Two digits: more would claim too much."""
    return f"{float(f'{number:.2g}'):,.0f}" if number >= 1 else f"{number:.1g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ledgers", nargs="+", type=Path)
    parser.add_argument("--price", type=float, default=PRICE, help="US dollars a core hour")
    parser.add_argument("--trials", type=int, default=1_000_000)
    told = parser.parse_args()
    print(table(costs(told.ledgers), told.trials, told.price))
    print("\n* one or two trials of a case: the loading of kernels is in it")


if __name__ == "__main__":
    main()
