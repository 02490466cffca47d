"""How tight the proven bound is after so many seconds of one core, in % of teleport.

    python benchmarks/speed/bound_quality.py --data DIR [--seconds 120] [--maps hikerpaul,newyork53] [--steps 300,900]

Seconds are processor time of the thread that proves, so other work on the machine does not blur the table; kernels
are compiled before the clock starts. The value of a good plan is told to the proof, as it is in a real run; by
default that of the best plans we know, less 0.2 points.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

from sooner.bounds import ConnectedSubgraph, bounds
from sooner.experiments.lin2014.maps import posed
from sooner.grid import Grid
from sooner.problem import Gains, Searcher, SearchProblem

KNOWN = {  # best plans found, % of teleport, T = 300, 600, 900
    "hikerpaul": {300: 98.82, 600: 97.77, 900: 97.29},
    "newyork53": {300: 90.08, 600: 94.33, 900: 95.80},
    "newyork108": {300: 83.47, 600: 87.66, 900: 88.57},
}
MARKS = (0.3, 1.0, 3.0, 10.0, 30.0, 120.0)


def warm_up() -> None:
    """Compile every kernel on a map of islands."""
    rng = np.random.default_rng(0)
    weights = rng.random(400) * (rng.random(400) < 0.3)
    problem = SearchProblem(Grid((20, 20)), Gains.independent(weights / weights.sum(), np.ones(400)),
                            (Searcher((0, 0), 60),))  # fmt: skip
    for tick, _ in enumerate(ConnectedSubgraph().bounds(problem, 0.5 * problem.teleport.value)):
        if tick > 100:
            return


def measure(problem: SearchProblem, known: float, seconds: float) -> tuple[list[float], int]:
    reference = problem.teleport.value
    started, found, ticks = time.thread_time(), [], 0
    value = reference
    for bound in bounds(problem, known * reference / 100.0):
        spent = time.thread_time() - started
        while len(found) < len(MARKS) and spent > MARKS[len(found)]:
            found.append(100.0 * value / reference)
        if spent > seconds:
            break
        value, ticks = bound.value, ticks + 1
    last = 100.0 * value / reference
    return found + [last] * (sum(mark <= seconds for mark in MARKS) - len(found)), ticks


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("SOONER_DATA"))
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--maps", default=",".join(KNOWN))
    parser.add_argument("--steps", default="300,600,900")
    parser.add_argument("--less", type=float, default=0.2, help="points by which the plan told is worse than the best")
    given = parser.parse_args()
    if given.data is None:
        parser.error("give --data DIR or set SOONER_DATA")
    folder = Path(given.data)
    folder = folder / "wisar" if (folder / "wisar").is_dir() else folder
    started = time.thread_time()
    warm_up()
    print(f"compiled or loaded in {time.thread_time() - started:.1f} s")
    print(f"{'':>16}{'best plan':>10}" + "".join(f"{mark:>8g} s" for mark in MARKS if mark <= given.seconds))
    for name in given.maps.split(","):
        for steps in map(int, given.steps.split(",")):
            best = KNOWN[name][steps]
            row, ticks = measure(posed(folder, name, (50, 50), steps), best - given.less, given.seconds)
            cells = "".join(f"{value:>10.3f}" for value in row)
            print(f"{name:>11} {steps:>4}{best:>10.2f}{cells}   {ticks} ticks", flush=True)


if __name__ == "__main__":
    main()
