"""Random areas: does any leg cross, is any sortie late, and what is refused, in which words?

From the repository's root:  python -m benchmarks.areas.study [--areas 10000] [--first 0] [--planner anneal]
The areas, the search over each, and the checks that know nothing of planners are those of tests/grounds.py.
"""

from __future__ import annotations

import argparse
import csv
import re
import sys
import time
from collections import Counter
from pathlib import Path

from tests.grounds import Flown, fly_area

from sooner.planners import Planner
from sooner.planners.leg_anneal import LegAnneal
from sooner.planners.registry import make_planner

TICKS = 9, *7 * (3,)  # of every eighth area: first routes, then annealing; of others: the way home, then two of lanes


def planner_named(name: str) -> Planner:
    return LegAnneal(moves=200, threads=1) if name == "anneal" else make_planner(name)


def kind_of(refusal: str) -> str:
    """A refusal without its numbers."""
    return re.sub(r"\[[^\]]*\]|-?\d+(\.\d+)?(e-?\d+)?", "..", refusal)


def main() -> None:
    asked = argparse.ArgumentParser()
    asked.add_argument("--areas", type=int, default=10_000)
    asked.add_argument("--first", type=int, default=0)
    asked.add_argument("--planner", default="anneal")
    asked.add_argument("--out", type=Path)
    given = asked.parse_args()
    planner, kinds = planner_named(given.planner), Counter[str]()
    tried = flown = broken = 0
    share, began, slowest = 0.0, time.process_time(), 0.0
    try:
        for seed in range(given.first, given.first + given.areas):
            before = time.process_time()
            found = flown_or_broken(seed, planner)
            tried, slowest = tried + 1, max(slowest, time.process_time() - before)
            if found.refused:
                kinds[kind_of(found.refused)] += 1
                continue
            flown, share = flown + 1, share + found.share
            if found.broken:
                broken += 1
                print(f"area {seed}: {'; '.join(found.broken)}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print(f"interrupted after {tried} areas", file=sys.stderr)
    rows = [
        ("areas", tried),
        ("flown", flown),
        ("broken", broken),
        ("mean share of the budget flown", f"{share / max(flown, 1):.3f}"),
        ("processor seconds", f"{time.process_time() - began:.0f}"),
        ("slowest area, seconds", f"{slowest:.2f}"),
        *((f"refused: {words}", count) for words, count in kinds.most_common()),
    ]
    writer = csv.writer(given.out.open("w", newline="") if given.out else sys.stdout)
    writer.writerows([("what", "count"), *rows])


def flown_or_broken(seed: int, planner: Planner) -> Flown:
    try:
        return fly_area(seed, planner, TICKS[seed % len(TICKS)])
    except Exception as fault:  # a crash is a fault of ours, to be counted
        return Flown(broken=(f"{type(fault).__name__}: {fault}",))


if __name__ == "__main__":
    main()
