"""Reaching a CDP soonest, against the moment at which the plan for the whole time gets there, and the proven least.

    python benchmarks/soonest/study.py --data DIR [--seconds 10] [--seeds 3]

DIR (or SOONER_DATA) holds wisar/NAME_dist.csv and NAME_diff.csv of Lin and Goodrich (2014). Targets are shares of what
the plan for T = 900 collects. Both planners and the proof have the same seconds; medians over seeds.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from sooner.experiments.lin2014.maps import posed
from sooner.planners import max_seconds, solve
from sooner.planners.anneal import Anneal
from sooner.planners.proved import Proved
from sooner.planners.soonest import Soonest
from sooner.problem import Objective, evaluate

MAPS = ("hikerpaul", "newyork53", "newyork108")
SHARES = (0.25, 0.5, 0.75)
STEPS = 900


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("SOONER_DATA"))
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    if given.data is None:
        parser.error("give --data DIR or set SOONER_DATA")
    print("| map | target CDP | whole plan gets there | soonest | proven least |\n|---|---|---|---|---|")
    for name in MAPS:
        problem, stop = posed(Path(given.data) / "wisar", name, (50, 50), STEPS), max_seconds(given.seconds)
        whole = [evaluate(problem, solve(problem, Anneal(), stop, seed).best.plan) for seed in range(given.seeds)]
        for share in SHARES:
            target = share * float(np.median([score.total for score in whole]))
            asked = replace(problem, objective=Objective(target=target))
            best = [solve(asked, Proved(Soonest(Anneal())), stop, seed).best for seed in range(given.seeds)]
            there = np.median([score.time_to(target) for score in whole])
            soon, least = np.median([-b.value for b in best]), np.median([-b.bound for b in best])
            print(f"| {name} | {target:.4f} | {there:.0f} | {soon:.0f} | {least:.0f} |", flush=True)


if __name__ == "__main__":
    main()
