"""The cluster against a real Dask on this machine: whatever goes away, every trial has its one row."""

from __future__ import annotations

import os
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import psutil
import pytest

pytestmark = pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed")

PATIENCE_S = 60.0  # of this file, for what takes a second on an idle machine
SLOT = "sooner.campaigns.worker"

STUDY = """
title = "Small"
trial = "work:fly"
trials = 6
[limits]
seconds = 60
[instances]
here = { }
[planners]
a = { }
b = { }
"""

WORK = '''
"""Trials that say when they fly, and wait where a file tells them to."""
import random
import time
from pathlib import Path


def fly(trial, place):
    here = Path(place.folder)
    with (here / "flown").open("a") as flown:
        flown.write(f"{trial.case.planner} {trial.seed}\\n")
    if trial.planner.get("waits"):
        while (here / f"wait-{trial.seed}").exists():
            time.sleep(0.02)
    return {"value": random.Random(trial.seed).random(), "planner": trial.case.planner}
'''

CLIENT = '''
"""Run a study on a cluster, as a user would."""
import sys
from pathlib import Path

from sooner.campaigns import read_study, run_study
from sooner.errors import SoonerError

if __name__ == "__main__":
    here, out, address = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    try:
        with run_study(read_study(here), out, scheduler=address or None, workers=2) as ran:
            print(ran.progress.done)
    except SoonerError as error:
        sys.exit(f"{type(error).__name__}: {error}")
'''


class Dask:
    """Processes of one test, each with all its children in a group of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.port = folder, _free_port()
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.started: list[subprocess.Popen[bytes]] = []

    def start(self, *command: str, **environment: str) -> subprocess.Popen[bytes]:
        with (self.folder / f"said-{len(self.started)}").open("wb") as said:
            process = subprocess.Popen(
                command,
                stdout=said,
                stderr=subprocess.STDOUT,
                cwd=self.folder,
                start_new_session=True,
                env=os.environ | {"PYTHONUNBUFFERED": "1"} | environment,
            )
        self.started.append(process)
        return process

    def said(self, process: subprocess.Popen[bytes]) -> str:
        return (self.folder / f"said-{self.started.index(process)}").read_text(errors="replace")

    def scheduler(self, **environment: str) -> subprocess.Popen[bytes]:
        script = "from distributed.cli.dask_scheduler import main; main()"
        where = "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard", "--no-show"
        return self.start(sys.executable, "-c", script, *where, **environment)

    def worker(self, *options: str, **environment: str) -> subprocess.Popen[bytes]:
        script = "from distributed.cli.dask_worker import main; main()"
        local = "--local-directory", str(self.folder / "dask"), "--no-dashboard"
        threads = () if "--nthreads" in options else ("--nthreads", "1")
        nanny = () if "--nanny" in options or "--no-nanny" in options else ("--no-nanny",)
        return self.start(sys.executable, "-c", script, self.address, *local, *threads, *nanny, *options, **environment)

    def client(self, out: str = "out") -> subprocess.Popen[bytes]:
        (self.folder / "client.py").write_text(CLIENT)
        return self.start(sys.executable, "client.py", str(self.folder), str(self.folder / out), self.address)

    def ran(self, process: subprocess.Popen[bytes]) -> str:
        """What it said, once it has ended well."""
        assert process.wait(PATIENCE_S) == 0, self.said(process)
        return self.said(process)

    def close(self) -> None:
        for process in self.started:
            _kill(process)


def _kill(process: subprocess.Popen[bytes]) -> None:
    """It and all that it started, without a chance to say farewell."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@pytest.fixture
def dask(tmp_path: Path) -> Iterator[Dask]:
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "work.py").write_text(WORK)
    found = Dask(tmp_path)
    yield found
    found.close()


def _until(holds: Callable[[], object], what: str) -> None:
    ends = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < ends, f"waited in vain: {what}"
        time.sleep(0.05)


def _waiting(dask: Dask, *seeds: int) -> None:
    """A study whose trials of planner a wait, for these seeds, until they may go on."""
    (dask.folder / "study.toml").write_text(STUDY.replace("a = { }", "a = { waits = true }"))
    for seed in seeds:
        (dask.folder / f"wait-{seed}").touch()


def _go(dask: Dask) -> None:
    for held in dask.folder.glob("wait-*"):
        held.unlink()


def _flown(folder: Path) -> Counter[str]:
    """How often each trial was begun."""
    told = folder / "flown"
    return Counter(told.read_text().splitlines()) if told.exists() else Counter()


def _ledger(folder: Path, sql: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(folder / "trials.sqlite")) as base:
        return base.execute(sql).fetchall()


def _answers(folder: Path) -> list[tuple[Any, ...]]:
    """Every row of the ledger that is done, as far as machines do not decide it."""
    return _ledger(
        folder,
        "SELECT planner, seed, state, answer FROM trials JOIN cases ON cases.id = case_id "
        "LEFT JOIN answers ON trial_id = trials.id ORDER BY planner, seed",
    )


def _of_the_pool(dask: Dask) -> list[tuple[Any, ...]]:
    """Answers of the embedded pool to the same study."""
    dask.address = ""
    dask.ran(dask.client("pool"))
    return _answers(dask.folder / "pool")


def _slots(dask: Dask) -> list[psutil.Process]:
    """Processes that fly trials of this test, or wait for some."""
    found = []
    for process in psutil.process_iter(["cmdline", "status"]):
        command = process.info["cmdline"] or []
        if SLOT in command and any(str(dask.folder) in part for part in command):
            found.append(process)
    return found


# ---------------------------------------------------------------------------------------------------- the same answers


@pytest.mark.parametrize(
    "workers",
    [("--nworkers", "1"), ("--nworkers", "2", "--nanny"), ("--nthreads", "2")],
    ids=["one worker", "two workers under nannies", "one worker of two threads"],
)
def test_answers_are_those_of_the_embedded_pool(dask: Dask, workers: tuple[str, ...]) -> None:
    dask.scheduler()
    dask.worker(*workers)
    said = dask.ran(dask.client())
    assert said.split() == ["12"]  # and nothing of Dask's own
    _until(lambda: not _slots(dask), "no process is left where trials were flown")
    assert set(_flown(dask.folder).values()) == {1}
    assert _answers(dask.folder / "out") == _of_the_pool(dask)


LOCAL = """
import sys
from pathlib import Path

from distributed import LocalCluster

from sooner.campaigns import read_study, run_study

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, processes=False) as cluster:
        with run_study(read_study(Path(sys.argv[1])), Path(sys.argv[2]), scheduler=cluster.scheduler_address) as ran:
            print(ran.progress.done)
"""


def test_a_local_cluster_will_do(dask: Dask) -> None:
    (dask.folder / "local.py").write_text(LOCAL)
    said = dask.ran(dask.start(sys.executable, "local.py", str(dask.folder), str(dask.folder / "out")))
    assert said.split() == ["12"]
    assert _answers(dask.folder / "out") == _of_the_pool(dask)


# ------------------------------------------------------------------------------------------------- whatever goes away


def test_a_killed_worker_costs_the_trial_it_flew(dask: Dask) -> None:
    _waiting(dask, 2)
    dask.scheduler()
    first = dask.worker()
    client = dask.client()
    _until(lambda: "a 2" in _flown(dask.folder), "the trial is in the air")
    _kill(first)
    dask.worker()
    _until(lambda: _flown(dask.folder)["a 2"] == 2, "it is in the air again")
    _go(dask)
    dask.ran(client)
    assert {trial for trial, times in _flown(dask.folder).items() if times > 1} == {"a 2"}
    assert _answers(dask.folder / "out") == _of_the_pool(dask)
