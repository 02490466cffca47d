"""The cases of Table II of [Wolek2020] on its authors' maps, flown by our simulator: E, its halves, false calls, time.

SOONER_DATA=... python benchmarks/simulation/cases.py --trials 100                    # cases 1 to 7 and two lawnmowers
SOONER_DATA=... python benchmarks/simulation/cases.py --trials 100 --offset 0.5       # targets half a cell away
SOONER_DATA=... python benchmarks/simulation/cases.py --trials 100 --targets 0        # searches in vain
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

from sooner.io import read_street_map
from sooner.simulation import Estimator, Scene, World, simulate
from sooner.simulation.strategies import Lawnmower, make_strategy

MAPS = ("authors_map1_randalls_island", "authors_map2_silver_spring", "authors_map3_nyc")
CASES = {
    "1 random, cbht": (make_strategy("random"), Estimator("cbht")),
    "2 lawnmower, cbht": (make_strategy("lawnmower"), Estimator("cbht")),
    "3 random, lrdt": (make_strategy("random"), Estimator("lrdt")),
    "4 lawnmower, lrdt": (make_strategy("lawnmower"), Estimator("lrdt")),
    "5 information, uniform": (make_strategy("information"), Estimator("lrdt", "uniform")),
    "6 information, kriged": (make_strategy("information"), Estimator("lrdt", "kriged")),
    "7 information, known": (make_strategy("information"), Estimator("lrdt", "known")),
    "tuned lawnmower, lrdt": (make_strategy("tuned_lawnmower"), Estimator("lrdt")),
    "tuned lawnmower, then back, lrdt": (Lawnmower(1.0, 0.5, 0.5, "back"), Estimator("lrdt")),
}


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--trials", type=int, default=100, help="on each map")
    asked.add_argument("--first", type=int, default=0, help="the first seed")
    asked.add_argument("--offset", type=float, default=0.0, help="cells east and north by which targets are put wrong")
    asked.add_argument("--targets", type=int, default=1)
    asked.add_argument("--case", action="append", help="beginning of a case's name; all if left out")
    said = asked.parse_args()
    folder = Path(os.environ["SOONER_DATA"]) / "occupancy_graphs"
    graphs = [read_street_map(folder / f"{name}.graph.json").graph for name in MAPS]
    print("| case | E | E_nodes | E_targ | false calls a trial | false nodes a trial | CPU ms a trial |")
    print("|---|---|---|---|---|---|---|")
    for name, (strategy, estimator) in CASES.items():
        if said.case and not any(name.startswith(case) for case in said.case):
            continue
        flown, spent = [], 0.0
        for graph in graphs:
            offset = (said.offset, said.offset)
            scene = Scene(World(graph, n_targets=said.targets), estimator=estimator, target_offset=offset)
            simulate(scene, strategy, 10**6)  # compiles, and makes what a scene makes once
            began = time.process_time()
            flown += [simulate(scene, strategy, seed) for seed in range(said.first, said.first + said.trials)]
            spent += time.process_time() - began
        print("|", name, "|", " | ".join(row(flown)), f"| {1e3 * spent / len(flown):.1f} |", flush=True)


def row(flown: list) -> list[str]:
    halves = [[each.e for each in flown], [each.e_nodes for each in flown], [each.e_targets for each in flown]]
    told = [f"{np.mean(each):.3f} +- {np.std(each, ddof=1) / len(each) ** 0.5:.3f}" for each in halves]
    in_vain = np.mean([each.false_calls > 0 for each in flown])
    calls, nodes = np.mean([each.false_calls for each in flown]), np.mean([each.false_nodes for each in flown])
    return [*told, f"{calls:.3f} (in {in_vain:.1%} of trials)", f"{nodes:.2f}"]


if __name__ == "__main__":
    main()
