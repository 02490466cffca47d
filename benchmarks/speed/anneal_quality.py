"""How good `anneal` is after a second and after ten: % of teleport on the real maps of Lin and Goodrich (2014).

    python benchmarks/speed/anneal_quality.py --data DIR [--seconds 1] [--threads 1 2] [--seeds 10] [--clock cpu]

DIR (or the environment variable SOONER_DATA) holds wisar/NAME_dist.csv and NAME_diff.csv. Prints the median, lowest and
highest of all seeds for each map and T. With `--clock cpu` a run ends after seconds x threads of this process's own
time, which is what an idle machine gives; seconds on the wall depend on what else runs. Tune on other seeds
(`--first-seed 100`) than those you report.
"""

import argparse
import os
import time
from pathlib import Path

import numpy as np

from sooner.experiments.lin2014.maps import posed
from sooner.planners import StopRule, max_seconds, max_ticks, solve
from sooner.planners.anneal import Anneal
from sooner.problem import SearchProblem

MAPS = ("hikerpaul", "newyork53", "newyork108")
STEPS = (300, 600, 900)


def real_map(data: Path, name: str, steps: int) -> SearchProblem:
    """A map of the paper as it is searched there: copter, four neighbours, start in the middle."""
    folder = data / "wisar" if (data / "wisar").is_dir() else data
    return posed(folder, name, (50, 50), steps)


def cpu_seconds(seconds: float) -> StopRule:
    """Stop when this process has computed for `seconds`, over all its threads."""
    began = time.process_time()

    def share(_: object) -> float:
        return min((time.process_time() - began) / seconds, 1.0)

    return StopRule(lambda progress: share(progress) >= 1.0, share)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("SOONER_DATA"))
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--clock", choices=["wall", "cpu"], default="wall")
    parser.add_argument("--maps", nargs="+", default=MAPS)
    parser.add_argument("--steps", type=int, nargs="+", default=STEPS)
    args = parser.parse_args()
    if args.data is None:
        parser.error("give --data DIR or set SOONER_DATA")
    solve(real_map(args.data, args.maps[0], 60), Anneal(), max_ticks(5))  # compile first
    print("map          T  threads  median     low    high    ticks  cpu_s")
    for name in args.maps:
        for steps in args.steps:
            problem = real_map(args.data, name, steps)
            for threads in args.threads:
                began = time.process_time()
                runs = []
                for seed in range(args.first_seed, args.first_seed + args.seeds):
                    rule = cpu_seconds(args.seconds * threads) if args.clock == "cpu" else max_seconds(args.seconds)
                    runs.append(solve(problem, Anneal(threads=threads), rule, seed=seed))
                cpu = (time.process_time() - began) / args.seeds
                value = 100 * np.array([run.best.value for run in runs]) / problem.teleport.value
                ticks = np.median([run.trace[-1].ticks for run in runs])
                print(
                    f"{name:10} {steps:3} {threads:8} {np.median(value):7.2f} {value.min():7.2f} {value.max():7.2f} "
                    f"{ticks:8.0f} {cpu:6.2f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
