"""The cluster against a real Dask on this machine: whatever goes away, every trial has its one row."""

from __future__ import annotations

import os
import platform
import shutil
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

from sooner.campaigns.provenance import PACKAGE

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
import signal
import sys
from pathlib import Path

from sooner.campaigns import read_study, run_study
from sooner.errors import SoonerError

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a background job has not
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


def _only_in_the_air(dask: Dask, *trials: str) -> None:
    """Wait until these trials fly, and every other that was begun is recorded."""

    def so() -> bool:
        flown = set(_flown(dask.folder))
        recorded = _ledger(dask.folder / "out", "SELECT trial_id FROM answers") if flown else []
        return flown >= set(trials) and len(flown) == len(recorded) + len(trials)

    _until(so, f"only {', '.join(trials)} in the air")


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
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
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
    _only_in_the_air(dask, "a 2")
    _kill(first)
    dask.worker()
    _until(lambda: _flown(dask.folder)["a 2"] == 2, "it is in the air again")
    _go(dask)
    dask.ran(client)
    assert {trial for trial, times in _flown(dask.folder).items() if times > 1} == {"a 2"}
    assert _answers(dask.folder / "out") == _of_the_pool(dask)


def test_a_campaign_outlasts_all_of_its_workers(dask: Dask) -> None:
    _waiting(dask, 1, 3)
    dask.scheduler()
    gone = dask.worker("--nworkers", "2", "--nanny")
    client = dask.client()
    _only_in_the_air(dask, "a 1", "a 3")
    _kill(gone)
    _until(lambda: not _slots(dask), "their processes went with the workers")
    before = set(_flown(dask.folder).elements())
    time.sleep(1.0)
    assert client.poll() is None
    assert set(_flown(dask.folder).elements()) == before
    _go(dask)
    dask.worker("--nthreads", "2")
    dask.ran(client)
    assert {trial for trial, times in _flown(dask.folder).items() if times > 1} == {"a 1", "a 3"}
    assert _answers(dask.folder / "out") == _of_the_pool(dask)


def test_a_campaign_outlasts_its_scheduler(dask: Dask) -> None:
    _waiting(dask, 2)
    scheduler, worker = dask.scheduler(), dask.worker()
    client = dask.client()
    _only_in_the_air(dask, "a 2")
    _kill(scheduler)
    _until(lambda: not _slots(dask), "the worker ends what nobody waits for")
    _kill(worker)
    _go(dask)
    dask.scheduler()
    dask.worker()
    said = dask.ran(client)
    assert said.split() == ["12"]  # tracebacks of Dask stay away from the user
    assert {trial for trial, times in _flown(dask.folder).items() if times > 1} == {"a 2"}
    assert _answers(dask.folder / "out") == _of_the_pool(dask)


def test_a_killed_client_goes_on_where_it_was(dask: Dask) -> None:
    _waiting(dask, 2)
    dask.scheduler()
    dask.worker()
    client = dask.client()
    _only_in_the_air(dask, "a 2")
    _kill(client)
    _until(lambda: not _slots(dask), "the worker ends what nobody waits for")
    _go(dask)
    assert dask.ran(dask.client()).split() == ["12"]
    assert {trial for trial, times in _flown(dask.folder).items() if times > 1} == {"a 2"}
    assert _answers(dask.folder / "out") == _of_the_pool(dask)


def test_ctrl_c_ends_the_campaign_and_what_it_flew(dask: Dask) -> None:
    _waiting(dask, 0)
    dask.scheduler()
    dask.worker()
    client = dask.client()
    _until(lambda: "a 0" in _flown(dask.folder), "the trial is in the air")
    client.send_signal(signal.SIGINT)
    client.wait(PATIENCE_S)
    _until(lambda: not _slots(dask), "nothing of it is left on the worker")
    assert dask.said(client).rstrip().endswith("KeyboardInterrupt")
    assert "distributed" not in dask.said(client).replace("distributed/", "")
    assert set(_ledger(dask.folder / "out", "SELECT state, attempts FROM trials")) == {(3, 0)}


# ----------------------------------------------------------------------------------------- trials that misbehave


MISBEHAVE = '''
"""Trials that die, hang, eat and raise, between others that do not."""
import os
import time


def fly(trial, place):
    if trial.seed == 1:
        getattr(Misbehaviour, trial.case.planner)()
    return {"value": trial.seed}


class Misbehaviour:
    def dies():
        os.abort()

    def hangs():
        time.sleep(600)

    def eats():
        eaten = []
        while True:
            eaten.append(bytearray(40_000_000))
            time.sleep(0.005)

    def raises():
        raise RuntimeError("no such luck")
'''


ENDINGS = {("dies", "crash"): 2, ("hangs", "hang"): 2, ("eats", "memory"): 2, ("raises", "error"): 2}


def test_a_trial_that_misbehaves_is_contained_as_in_the_pool(dask: Dask) -> None:
    (dask.folder / "work.py").write_text(MISBEHAVE)
    planners = "dies = { }\nhangs = { }\neats = { }\nraises = { }\n"
    study = STUDY.replace("a = { }\nb = { }\n", planners).replace("trials = 6", "trials = 3")
    (dask.folder / "study.toml").write_text(study.replace("seconds = 60", "seconds = 3\nmemory_mb = 400"))
    dask.scheduler()
    worker = dask.worker("--nthreads", "2")
    assert dask.ran(dask.client()).split() == ["8"]
    assert worker.poll() is None
    assert "Restarting" not in dask.said(worker)
    endings = _failures(dask.folder / "out")
    assert endings == ENDINGS
    assert _answers(dask.folder / "out") == _of_the_pool(dask)
    assert endings == _failures(dask.folder / "pool")


def _failures(folder: Path) -> Counter[tuple[Any, ...]]:
    """How the attempts at each planner's trials went wrong."""
    sql = "SELECT planner, ending FROM failures JOIN trials ON trials.id = trial_id JOIN cases ON cases.id = case_id"
    return Counter(_ledger(folder, sql))


# ----------------------------------------------------------------------------------------------- what it says and holds


ONE = '''
"""One trial on a cluster, without a campaign around it."""
import sys

from sooner.campaigns.cluster import Cluster
from sooner.campaigns.trial import Case, Limits, Place, Trial
from sooner.errors import SoonerError

crew = Cluster(sys.argv[1], Place("work:fly", sys.argv[3]), Limits(60.0), patience_s=float(sys.argv[2]))
try:
    crew.start(Trial(Case("i", "p", None, "{}"), 0))
    while not (ended := crew.ended(1.0)):
        pass
    print(ended)
except SoonerError as error:
    print(f"{type(error).__name__}: {error}")
finally:
    crew.close()
'''


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("tcp://127.0.0.1:1", "after 0.5 s"),
        ("127.0.0.1", "missing port number"),
        ("carrier-pigeon://127.0.0.1:8786", "unknown address scheme"),
    ],
    ids=["nobody there", "no port", "no such scheme"],
)
def test_an_address_without_a_scheduler_is_told(dask: Dask, address: str, says: str) -> None:
    said = _one(dask, address, 0.5)
    assert said.startswith(f"DataFormatError: --scheduler: {address!r} came, and no scheduler of Dask answers there")
    assert says in said
    assert "expected an address as tcp://" in said
    assert len(said.splitlines()) == 1


def test_without_dask_it_says_what_to_install(dask: Dask) -> None:
    (dask.folder / "distributed.py").write_text("raise ImportError")
    assert _one(dask, dask.address) == "UnsupportedProblemError: a cluster needs Dask: pip install 'sooner[cluster]'"


WITHOUT = '''
"""Read by Python when it starts: here, nobody has installed sooner."""
import sys

sys.modules["sooner"] = None
'''


def test_a_worker_without_sooner_is_told(dask: Dask) -> None:
    (dask.folder / "bare").mkdir()
    (dask.folder / "bare" / "sitecustomize.py").write_text(WITHOUT)
    dask.scheduler()
    worker = dask.worker(PYTHONPATH=str(dask.folder / "bare"))
    said = _one(dask, dask.address)
    assert said.startswith("DataFormatError: --scheduler: a worker cannot fly for us")
    assert f"on {platform.node()}); expected sooner, in this version," in said
    assert worker.poll() is None  # it may have others to serve


def test_a_machine_without_the_folder_of_the_study_is_told(dask: Dask) -> None:
    dask.scheduler()
    dask.worker()
    said = _one(dask, dask.address, folder="not-there")
    assert "the folder of the study, not-there, is not there, on " in said
    assert said.startswith("DataFormatError: --scheduler: a worker cannot fly for us")


def test_the_scheduler_needs_no_sooner(dask: Dask) -> None:
    (dask.folder / "bare").mkdir()
    (dask.folder / "bare" / "sitecustomize.py").write_text(WITHOUT)
    dask.scheduler(PYTHONPATH=str(dask.folder / "bare"))
    dask.worker()
    assert dask.ran(dask.client()).split() == ["12"]


def _one(dask: Dask, address: str, patience_s: float = PATIENCE_S, folder: str = ".") -> str:
    (dask.folder / "one.py").write_text(ONE)
    return dask.ran(dask.start(sys.executable, "one.py", address, str(patience_s), folder)).strip()


def test_a_worker_with_other_source_is_refused(dask: Dask) -> None:
    other = dask.folder / "other" / "sooner"
    shutil.copytree(PACKAGE, other, ignore=shutil.ignore_patterns("__pycache__"))
    (other / "__init__.py").write_text((other / "__init__.py").read_text() + "\n# changed\n")
    dask.scheduler()
    dask.worker(PYTHONPATH=str(other.parent))
    client = dask.client()
    assert client.wait(PATIENCE_S) == 1
    assert "answered with other code or other maps than ours" in dask.said(client)
    assert _ledger(dask.folder / "out", "SELECT * FROM answers") == []
    _until(lambda: not _slots(dask), "no process of it is left")


MANY = '''
"""Many empty trials; says how many were under way at once at most."""
import sys
from pathlib import Path

from sooner.campaigns import cluster, read_study, run_study


class Counted(cluster.Cluster):
    under_way = most = 0

    def start(self, trial):
        super().start(trial)
        Counted.under_way += 1
        Counted.most = max(Counted.most, Counted.under_way)

    def ended(self, wait_s):
        found = super().ended(wait_s)
        Counted.under_way -= len(found)
        return found


cluster.Cluster = Counted
with run_study(read_study(Path(sys.argv[1])), Path(sys.argv[2]), scheduler=sys.argv[3], trials=100) as ran:
    print(ran.progress.done, Counted.most)
'''


def test_only_two_trials_for_each_thread_are_under_way(dask: Dask) -> None:
    (dask.folder / "many.py").write_text(MANY)
    dask.scheduler()
    dask.worker("--nthreads", "2")
    many = dask.start(sys.executable, "many.py", str(dask.folder), str(dask.folder / "out"), dask.address)
    assert dask.ran(many).split() == ["200", "4"]
