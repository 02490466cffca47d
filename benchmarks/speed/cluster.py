"""What Dask costs a campaign: trials a second, and processor time and memory of the client and of the scheduler.

python benchmarks/speed/cluster.py --trials 4000 --seconds 0
"""

from __future__ import annotations

import argparse
import socket
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil

from sooner.campaigns import Progress, read_study, run_study

STUDY = """
title = "What Dask costs"
trial = "sleeps:fly"
instances = {{ here = {{ }} }}
planners = {{ sleeps = {{ seconds = {seconds} }} }}
"""

TRIAL = """
import time


def fly(trial, place):
    time.sleep(trial.planner["seconds"])
    return {"value": trial.seed}
"""


class Meter:
    """Trials and what processes have taken so far, from the first tenth of a campaign to its end."""

    def __init__(self, scheduler: psutil.Process | None) -> None:
        self.processes = {"client": psutil.Process()} | ({"scheduler": scheduler} if scheduler else {})
        self.marks: list[tuple[int, float, dict[str, float]]] = []

    def tell(self, progress: Progress) -> None:
        if progress.done >= progress.total // 10 and (not self.marks or progress.done > self.marks[-1][0]):
            taken = {name: sum(process.cpu_times()[:2]) for name, process in self.processes.items()}
            self.marks.append((progress.done, time.perf_counter(), taken))

    def say(self, name: str) -> None:
        if len(self.marks) < 2:
            print(f"{name}: too few trials to measure")
            return
        (first, began, before), (last, ended, after) = self.marks[0], self.marks[-1]
        print(f"{name}: {(last - first) / (ended - began):.1f} trials/s")
        for who, process in self.processes.items():
            each, held = (after[who] - before[who]) / (last - first), process.memory_info().rss
            print(f"  {who}: {1e3 * each:.2f} ms of a processor for each trial; holds {held / 2**20:.0f} MB")


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--trials", type=int, default=4000)
    asked.add_argument("--seconds", type=float, default=0.0, help="that a trial sleeps")
    asked.add_argument("--workers", type=int, default=2)
    told = asked.parse_args()
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "study.toml").write_text(STUDY.format(seconds=told.seconds))
        (folder / "sleeps.py").write_text(TRIAL)
        _fly(folder, told, Meter(None), "pool", None)
        with socket.socket() as found:
            found.bind(("127.0.0.1", 0))
            port = found.getsockname()[1]
        address = f"tcp://127.0.0.1:{port}"
        scheduler = _dask(folder, "scheduler", "--host", "127.0.0.1", "--port", str(port))
        workers = ("--nworkers", str(told.workers), "--nthreads", "1", "--local-directory", name)
        worker = _dask(folder, "worker", address, *workers)
        try:
            _fly(folder, told, Meter(psutil.Process(scheduler.pid)), "cluster", address)
        finally:
            for process in (worker, scheduler):
                process.terminate()
                process.wait()


def _dask(folder: Path, what: str, *options: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "dask", what, *options, "--no-dashboard"]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def _fly(folder: Path, told: argparse.Namespace, meter: Meter, name: str, scheduler: str | None) -> None:
    workers = None if scheduler else told.workers
    study = read_study(folder)
    with run_study(study, folder / name, None, told.trials, workers, scheduler, watch=meter.tell):
        meter.say(name)


if __name__ == "__main__":
    main()
