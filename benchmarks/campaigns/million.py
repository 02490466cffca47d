"""What a ledger of a million trials costs: to fill, to come back to, to read and to sum up.

    python benchmarks/campaigns/million.py [--trials 1000000] [--cases 10] [--batch 4] [--out DIR]

The trials are empty: their answers come from a crew that invents them, so that every second is the campaign's own. They
are recorded in batches, as the campaign does with four trials in the air, each batch on the disk before the next. For
the rest a thousand trials are missing: a new process opens the ledger and flies on, and what is measured is from
`run_study` to the first trial that goes out; another reads all results and sums them up. CPU is that of the process,
memory the most that was resident.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from sooner.campaigns import Outcome, Trial, read_study, run, run_study
from sooner.campaigns.ledger import DONE, Ledger
from sooner.campaigns.provenance import provenance
from sooner.campaigns.summary import summary_rows
from sooner.campaigns.trial import Place

STUDY = """
title = "A million"
trial = "empty:fly"
trials = {seeds}
[instances]
here = {{}}
[planners]
{planners}
"""
MISSING = 1000
ANSWER = '{"value": 0.5, "found": true, "timing.seconds": 0.05}'


class Invented:
    """A crew that flies nothing."""

    workers, places = 2, 4

    def __init__(self, place: Place) -> None:
        self.provenance = json.dumps(provenance(place))
        self.asked: list[Trial] = []
        self.first: float | None = None

    def start(self, trial: Trial) -> None:
        self.first = self.first or time.perf_counter()
        self.asked.append(trial)

    def ended(self, wait_s: float) -> list[Outcome]:
        asked, self.asked = self.asked, []
        return [Outcome(trial, "done", ANSWER, wall_s=0.05, provenance=self.provenance) for trial in asked]

    def close(self) -> None:
        pass


def fill(folder: Path, batch: int) -> dict[str, float]:
    """All trials but a thousand, in batches."""
    study = read_study(folder)
    place = Place(study.file.trial, str(study.folder.resolve()))
    by = json.dumps(provenance(place))
    cases = study.asked().cases
    todo = [Trial(case, seed) for seed in cases[0][1] for case, _ in cases][:-MISSING]
    with Ledger(folder / "out" / run.LEDGER, study.key) as ledger:
        ended: list[tuple[Outcome, int]] = []
        for at in range(0, len(todo) + batch, batch):
            begun = todo[at : at + batch]
            ledger.write(ended, begun)
            ended = [(Outcome(trial, "done", ANSWER, wall_s=0.05, provenance=by), DONE) for trial in begun]
    return {}


def resume(folder: Path) -> dict[str, float]:
    """From the command to the first trial that goes out."""
    crews: list[Invented] = []

    def crew(study: Any, place: Place, *_: Any) -> Invented:
        crews.append(Invented(place))
        return crews[0]

    run._crew = crew
    began = time.perf_counter()
    with run_study(read_study(folder), folder / "out") as ran:
        assert ran.progress.done == ran.progress.total
    return {"to the first trial": (crews[0].first or began) - began}


def read(folder: Path) -> dict[str, float]:
    """What `Ran.results` and the summary take, of a campaign that is done."""
    with run_study(read_study(folder), folder / "out") as ran:
        began = time.perf_counter()
        results = ran.results()
        taken = time.perf_counter() - began
        began = time.perf_counter()
        summary_rows(list(results.values()))
        return {"results": taken, "summary": time.perf_counter() - began}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=1_000_000)
    parser.add_argument("--cases", type=int, default=10)
    parser.add_argument("--batch", type=int, default=4, help="trials recorded at once")
    parser.add_argument("--out", type=Path, help="an empty folder on the disk to be measured")
    parser.add_argument("--step", choices=["fill", "resume", "read"], help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.step:
        began = time.perf_counter()
        steps = {"fill": lambda: fill(args.out, args.batch), "resume": lambda: resume(args.out)}
        told = steps.get(args.step, lambda: read(args.out))()
        used = resource.getrusage(resource.RUSAGE_SELF)
        peak_mb = used.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
        wall = time.perf_counter() - began
        print(json.dumps({"wall": wall, "cpu": used.ru_utime + used.ru_stime, "peak": peak_mb} | told))
        return
    with tempfile.TemporaryDirectory(dir=args.out) as made:
        folder = Path(made)
        planners = "\n".join(f"p{number} = {{}}" for number in range(args.cases))
        (folder / "study.toml").write_text(STUDY.format(seeds=args.trials // args.cases, planners=planners))
        (folder / "empty.py").write_text("def fly(trial, place):\n    return {}\n")
        print(f"{args.trials} trials of {args.cases} cases, {args.batch} at once")
        print(f"{'step':8} {'wall s':>8} {'CPU s':>8} {'peak MB':>8}")
        for step in ("fill", "resume", "read"):
            command = [sys.executable, __file__, "--step", step, "--out", str(folder), "--batch", str(args.batch)]
            done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
            told = json.loads(done.stdout)
            wall, cpu, peak = (told.pop(key) for key in ("wall", "cpu", "peak"))
            more = ", ".join(f"{key} {value:.2f} s" for key, value in told.items())
            print(f"{step:8} {wall:8.1f} {cpu:8.1f} {peak:8.0f}  {more}", flush=True)
            if step == "fill":
                print(f"{'':8} {(folder / 'out' / run.LEDGER).stat().st_size / 2**20:.0f} MB on the disk")


if __name__ == "__main__":
    main()
