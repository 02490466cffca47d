"""Does asking again pay? Receding horizon against planning once, on a drifting and on a still person.

    python benchmarks/receding/study.py [--seeds 40] [--out benchmarks/receding]

Section VI of Lin and Goodrich (2014) leaves this open. Every search is flown by the same inner planner with the same
number of ticks a plan; planning once is for the person held still where he will be in the middle of the flight.
Differences are paired by seed; `lost` counts the searches in which asking again did worse.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from sooner.planners import Planner, TopN, solve
from sooner.planners.anneal import Anneal
from sooner.planners.greedy import Greedy
from sooner.planners.receding import Receding
from sooner.scenarios import drifting_hiker

STEPS = 300
EVERY = (150, 60, 30, 15)
MOVES = (0.0, 0.05, 0.25)
INNER: dict[str, Planner] = {"greedy": Greedy(), "topn": TopN(threads=1), "anneal": Anneal(threads=1)}
TICKS = 12


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent)
    given = parser.parse_args()
    rows = ["inner,move,every,once,receding,difference,low,high,lost,n"]
    for name, inner in INNER.items():
        for move in MOVES:
            rows += compare(name, inner, move, given.seeds)
            print("\n".join(rows[-len(EVERY) :]), flush=True)
    (given.out / "receding.csv").write_text("\n".join(rows) + "\n")


def compare(name: str, inner: Planner, move: float, seeds: int) -> list[str]:
    """One row for each interval between plans; the interval of the difference is its mean and two standard errors."""
    problems = [drifting_hiker(seed, move, steps=STEPS) for seed in range(seeds)]
    alone = np.array([solve(p, Receding(inner, STEPS, TICKS), seed=seed).best.value for seed, p in enumerate(problems)])
    rows = []
    for every in EVERY:
        again = np.array(
            [solve(p, Receding(inner, every, TICKS), seed=seed).best.value for seed, p in enumerate(problems)]
        )
        gained = again - alone
        error = 2 * gained.std(ddof=1) / np.sqrt(seeds)
        rows.append(
            f"{name},{move},{every},{alone.mean():.4f},{again.mean():.4f},{gained.mean():.4f},"
            f"{gained.mean() - error:.4f},{gained.mean() + error:.4f},{int((gained < 0).sum())},{seeds}"
        )
    return rows


if __name__ == "__main__":
    main()
