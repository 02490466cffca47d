"""What a campaign costs beyond its trials: CPU of the client and of the workers, for trials of 50 ms.

    python benchmarks/campaigns/overhead.py [--trials 400] [--ms 50] [--workers 2] [--rounds 3]

Each trial computes until its process has used so much CPU. The CPU of a whole campaign, from a process that starts to
the end of its last worker, is set against the sum of what its trials took; the start (imports, a first trial in each
worker) is measured by a campaign of one trial per worker and told apart. CPU time depends little on what else the
machine does.
"""

from __future__ import annotations

import argparse
import os
import sqlite3
import statistics
import subprocess
import sys
import tempfile
from contextlib import closing
from pathlib import Path

WORK = """
import time

def fly(trial, place):
    end = time.process_time() + trial.planner["ms"] / 1000
    number = trial.seed
    while time.process_time() < end:
        for _ in range(200):
            number = (number * 6364136223846793005 + 1442695040888963407) % 2**64
    return {"value": number / 2**64, "found": True, "steps": trial.seed}
"""
STUDY = """
title = "Overhead"
trial = "spin:fly"
trials = {trials}
[instances]
here = {{}}
[planners]
spin = {{ ms = {ms} }}
"""
CLIENT = """
import sys
from pathlib import Path
from sooner.campaigns import read_study, run_study
if __name__ == "__main__":
    run_study(read_study(Path(sys.argv[1])), Path(sys.argv[1]) / "out", workers=int(sys.argv[2])).ledger.close()
"""


def flown(trials: int, ms: float, workers: int) -> tuple[float, float]:
    """CPU seconds of a whole campaign, and of its trials."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "spin.py").write_text(WORK)
        (folder / "study.toml").write_text(STUDY.format(trials=trials, ms=ms))
        before = os.times()
        subprocess.run([sys.executable, "-c", CLIENT, str(folder), str(workers)], check=True)
        after = os.times()
        with closing(sqlite3.connect(folder / "out" / "trials.sqlite")) as base:
            ((own,),) = base.execute("SELECT sum(cpu_s) FROM trials").fetchall()
    whole = (after.children_user + after.children_system) - (before.children_user + before.children_system)
    return whole, own


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=400)
    parser.add_argument("--ms", type=float, default=50.0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    print("CPU s: whole  trials  start    rest of it, ms a trial   %")
    shares = []
    for _ in range(args.rounds):
        few, few_own = flown(args.workers, args.ms, args.workers)
        start = few - few_own
        whole, own = flown(args.trials, args.ms, args.workers)
        rest = whole - own - start
        shares.append(100 * rest / own)
        print(f"{whole:12.2f} {own:7.2f} {start:6.2f} {1000 * rest / args.trials:26.2f} {shares[-1]:5.2f}", flush=True)
    print(f"median {statistics.median(shares):.2f} % beyond the trials, start apart")


if __name__ == "__main__":
    main()
