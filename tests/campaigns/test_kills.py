"""Whoever is killed, and whenever: every trial has its one row, and says what it says undisturbed."""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from sooner.campaigns import read_study
from sooner.campaigns.ledger import Ledger
from tests.campaigns.conftest import ledger_told, small_study

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no process groups to kill")

PATIENCE_S = 120.0  # with a machine that is busy
KILLS = 20
SLOT = "sooner.campaigns.worker"
ANSWERS = (
    "SELECT planner, seed, answer FROM answers JOIN trials ON trials.id = trial_id JOIN cases ON cases.id = case_id"
)
CLIENT = """
import sys
from pathlib import Path

from sooner.campaigns import read_study, run_study

if __name__ == "__main__":
    with run_study(read_study(Path(sys.argv[1])), Path(sys.argv[2]), workers=int(sys.argv[3])) as ran:
        print(ran.progress.done)
"""


class Campaign:
    """The command of a user, in a process group of its own."""

    def __init__(self, tmp_path: Path, study: Path, told, out: str = "out") -> None:
        self.study, self.out, self.told = study, tmp_path / out, told
        self.trials = read_study(study).file.trials
        self.client = tmp_path / "client.py"
        self.client.write_text(CLIENT)
        self.said = tmp_path / f"{out}.txt"

    def start(self, workers: int = 2, nap_s: float = 0.025) -> subprocess.Popen[bytes]:
        command = [sys.executable, str(self.client), str(self.study), str(self.out), str(workers)]
        with self.said.open("wb") as said:
            return subprocess.Popen(
                command, stdout=said, stderr=said, start_new_session=True, env=os.environ | {"NAP_S": str(nap_s)}
            )

    def finish(self, workers: int = 2) -> None:
        assert self.start(workers, 0.0).wait(PATIENCE_S) == 0, self.said.read_text()

    def workers(self) -> list[psutil.Process]:
        found = []
        for process in psutil.process_iter():
            with suppress(psutil.Error):
                line = process.cmdline()
                if SLOT in line and any(str(self.study) in word for word in line):
                    found.append(process)
        return found

    def begun(self, trials: int) -> None:
        """Wait until so many trials are done."""
        until(lambda: (self.out / "trials.sqlite").exists() and self._done() >= trials)

    def _done(self) -> int:
        with suppress(sqlite3.OperationalError):  # the tables are still to come
            return len(self.told(self.out, "SELECT 1 FROM answers"))
        return 0

    def answers(self) -> list[tuple]:
        return self.told(self.out, f"{ANSWERS} ORDER BY planner, seed")


def until(holds) -> None:
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, "it never came to pass"
        time.sleep(0.01)


@pytest.fixture
def campaign(tmp_path, study, told) -> Campaign:
    return Campaign(tmp_path, study(trials=200), told)


@pytest.fixture
def short(tmp_path, study, told) -> Campaign:
    return Campaign(tmp_path, study(trials=50), told)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> list[tuple]:
    """What all trials say when nobody disturbs them, and one worker flies them all."""
    folder = tmp_path_factory.mktemp("undisturbed")
    campaign = Campaign(folder, small_study(folder, trials=200), ledger_told)
    campaign.finish(workers=1)
    return campaign.answers()


def is_whole(campaign: Campaign, undisturbed: list[tuple]) -> None:
    """Every trial once, with one answer, the one that it has undisturbed; and nobody is left behind."""
    campaign.finish()
    trials = campaign.told(campaign.out, "SELECT planner, seed, state FROM trials JOIN cases ON cases.id = case_id")
    assert sorted(trials) == [(planner, seed, 2) for planner in "ab" for seed in range(campaign.trials)]
    assert campaign.answers() == [row for row in undisturbed if row[1] < campaign.trials]
    until(lambda: not campaign.workers())


@pytest.mark.slow
@pytest.mark.parametrize("whole_group", [False, True], ids=["the client", "the whole group"])
def test_a_campaign_outlives_the_death_of(whole_group, campaign, undisturbed):
    rng, killed = random.Random(whole_group), 0
    while killed < KILLS:
        process = campaign.start()
        time.sleep(rng.uniform(0.0, 1.0))
        assert process.poll() is None, campaign.said.read_text()
        if whole_group:
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()
        killed += 1
    until(lambda: not campaign.workers())
    is_whole(campaign, undisturbed)


@pytest.mark.slow
def test_a_campaign_outlives_the_death_of_its_workers(campaign, undisturbed):
    rng = random.Random(2)
    process = campaign.start(nap_s=0.12)
    for _ in range(KILLS):
        until(lambda: campaign.workers() or process.poll() is not None)
        time.sleep(rng.uniform(0.0, 0.4))
        for worker in rng.sample(alive := campaign.workers(), min(len(alive), 1)):
            worker.kill()
    assert process.wait(PATIENCE_S) == 0, campaign.said.read_text()
    assert 1 <= len(campaign.told(campaign.out, "SELECT 1 FROM failures WHERE ending = 'killed'")) <= KILLS
    is_whole(campaign, undisturbed)


def test_two_workers_say_what_one_says(short, undisturbed):
    is_whole(short, undisturbed)


def test_a_ledger_whose_maker_is_killed_begins_anew(tmp_path):
    maker = (
        "import sys, pathlib\n"
        "from sooner.campaigns.ledger import Ledger\n"
        "print('now', flush=True)\n"
        "Ledger(pathlib.Path(sys.argv[1]), 'Small').close()\n"
        "sys.stdin.read()"
    )
    rng = random.Random(3)
    for number in range(8):
        path = tmp_path / str(number) / "trials.sqlite"
        with subprocess.Popen(
            [sys.executable, "-c", maker, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == b"now\n"
            time.sleep(rng.uniform(0.0, 0.02))
            process.kill()
        with Ledger(path, "Small") as ledger:
            assert ledger.recover() == 0


def test_ctrl_c_gives_back_what_was_in_the_air_and_the_campaign_goes_on(short, undisturbed):
    process = short.start()
    short.begun(10)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(PATIENCE_S) in (-signal.SIGINT, 130)
    assert "KeyboardInterrupt" in short.said.read_text()
    assert short.told(short.out, "SELECT count(*), sum(interrupted) FROM trials WHERE state = 1") == [(0, None)]
    assert short.told(short.out, "SELECT sum(interrupted), sum(state = 3) > 0 FROM trials") == [(0, 1)]
    before = short.answers()
    assert 10 <= len(before) < 100
    until(lambda: not short.workers())
    is_whole(short, undisturbed)
    assert set(before) <= set(short.answers())


def test_ctrl_c_at_any_moment_loses_nothing(short, undisturbed):
    rng = random.Random(4)
    for _ in range(6):
        process = short.start()
        time.sleep(rng.uniform(0.1, 0.9))
        os.killpg(process.pid, signal.SIGINT)
        if process.wait(PATIENCE_S) == 0:  # it was quicker
            break
    is_whole(short, undisturbed)


def test_a_second_campaign_on_one_ledger_is_refused_and_the_first_goes_on(short, undisturbed, tmp_path, told):
    first = short.start()
    short.begun(1)
    first.send_signal(signal.SIGSTOP)  # or a busy machine might let it end before the second comes
    second = Campaign(tmp_path, short.study, told)
    second.said = tmp_path / "second.txt"
    assert second.start().wait(PATIENCE_S) == 1
    assert "another sooner is flying this campaign; wait until it ends" in second.said.read_text()
    first.send_signal(signal.SIGCONT)
    assert first.wait(PATIENCE_S) == 0, short.said.read_text()
    is_whole(short, undisturbed)
