"""A slot and the pool of them: whatever a trial does to its process, an outcome comes back."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest

from sooner.campaigns import Case, Limits, Outcome, Place, Trial, read_study, run_study
from sooner.campaigns import pool as pool_module
from sooner.campaigns.slot import Slot
from sooner.campaigns.trial import in_short
from sooner.errors import DataFormatError

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no signals to die of")

SOUND = Limits(60.0, 2000.0)


@pytest.fixture
def flown(study):
    """(mishap, limits, settings) -> outcome, and the slot for more."""
    slots = []

    def fly(mishap: str, limits: Limits = SOUND, seed: int = 0, **more) -> Outcome:
        if not slots or slots[0].limits != limits:
            slots.insert(0, Slot(Place("work:fly", str(study())), limits))
        return slots[0].run(trial(mishap, seed, **more))

    yield fly
    for slot in slots:
        slot.drop()


def trial(mishap: str, seed: int = 0, **more) -> Trial:
    settings = {"instance": {}, "planner": {"mishap": mishap} | more}
    return Trial(Case("here", mishap, None, json.dumps(settings)), seed)


@pytest.mark.parametrize(
    ("mishap", "ending", "reason"),
    [
        ("raises", "error", "ValueError: the map has no snow"),
        ("interrupts itself", "done", ""),
        ("segfault", "crash", "signal SIGSEGV"),
        ("abort", "crash", "signal SIGABRT"),
        ("exits", "crash", "exit status 3\nwhat it said last"),
        ("killed", "killed", "signal SIGKILL"),
        ("leaves a child", "crash", "exit status 4"),
        ("unknown", "error", "KeyError: 'unknown'"),
    ],
)
def test_a_mishap_has_its_ending_and_reason_and_the_next_trial_flies(mishap, ending, reason, flown):
    outcome = flown(mishap)
    assert (outcome.ending, bool(outcome.answer)) == (ending, ending == "done")
    assert reason in outcome.reason
    assert flown("none").ending == "done"


def test_a_trial_that_hangs_is_ended(flown):
    outcome = flown("hangs", Limits(1.0, 2000.0))
    assert outcome.ending == "hang"
    assert outcome.reason == "it had no answer after 1 s"
    assert outcome.wall_s >= 1.0


def test_a_trial_that_eats_memory_is_ended(flown):
    outcome = flown("eats", Limits(60.0, 400.0))
    assert outcome.ending == "memory"
    assert "MB were resident; the limit is 400" in outcome.reason


def test_an_answer_comes_with_what_it_took_and_where_it_was_made(flown):
    outcome = flown("none")
    assert outcome.measures.keys() == {"value", "odd", "said"}
    assert outcome.cpu_s > 0
    assert 10 < outcome.memory_mb < 1000
    assert json.loads(outcome.provenance).keys() >= {"commit", "source", "data", "packages", "processor", "python"}


def test_what_is_no_object_is_no_answer(study):
    folder = study()
    (folder / "lists.py").write_text("def fly(trial, place):\n    return [1, 2]\n")
    slot = Slot(Place("lists:fly", str(folder)), SOUND)
    outcome = slot.run(trial("none"))
    assert outcome.ending == "error"
    assert "the trial returned list; expected an object" in outcome.reason
    slot.drop()


def test_a_function_that_is_not_there_is_named(study):
    slot = Slot(Place("nowhere:fly", str(study())), SOUND)
    outcome = slot.run(trial("none"))
    assert outcome.ending == "error"
    assert in_short(outcome.reason) == "ModuleNotFoundError: No module named 'nowhere'"


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ("{'value': 10**400}", "ValueError: the answer['value'] is a whole number above 1.8e308; expected one below"),
        ("{'a': {'b': [0, '\\ud800']}}", "TypeError: the answer['a']['b'][1] is text with half a character; expected"),
        ("{'a': {1: 2}}", "TypeError: the answer['a'] has the key 1; expected text as keys"),
        ("{'\\ud800': 2}", "TypeError: the answer has the key '\\ud800'; expected text as keys"),
        ("{'a': {1, 2}}", "TypeError: the answer['a'] is set; expected numbers, text, lists or objects"),
    ],
)
def test_an_answer_that_no_report_can_hold_is_the_error_of_its_trial(answer, reason, study):
    folder = study()
    (folder / "says.py").write_text(f"def fly(trial, place):\n    return {answer}\n")
    slot = Slot(Place("says:fly", str(folder)), SOUND)
    outcome = slot.run(trial("none"))
    assert outcome.ending == "error"
    assert in_short(outcome.reason).startswith(reason)
    slot.drop()


def test_arrays_and_their_numbers_are_answers(study):
    folder = study()
    (folder / "says.py").write_text(
        "import numpy as np\ndef fly(trial, place):\n"
        "    return {'a': np.arange(3), 'b': (np.int64(7), np.bool_(True), np.float64(0.5)), 'c': [np.float32(0.25)]}\n"
    )
    slot = Slot(Place("says:fly", str(folder)), SOUND)
    assert slot.run(trial("none")).measures == {"a": [0, 1, 2], "b": [7, True, 0.5], "c": [0.25]}
    slot.drop()


def test_the_words_of_an_exception_are_text_and_told_whole(flown, study):
    folder = study()
    (folder / "says.py").write_text(
        "def fly(trial, place):\n    raise ValueError('no such\\n  hills:\\nthem \\ud800')\n"
    )
    slot = Slot(Place("says:fly", str(folder)), SOUND)
    assert in_short(slot.run(trial("none")).reason) == "ValueError: no such hills: them ?"
    slot.drop()


def test_what_a_trial_says_is_of_this_trial_and_holds_no_gaps(study):
    folder = study()
    (folder / "says.py").write_text(
        "import os\ndef fly(trial, place):\n    print('said in', trial.seed, flush=True)\n"
        "    if trial.seed == 1:\n        os._exit(3)\n    return {'value': 1}\n"
    )
    slot = Slot(Place("says:fly", str(folder)), SOUND)
    assert slot.run(trial("none")).ending == "done"
    assert slot.run(trial("none", 1)).reason == "its process ended with exit status 3\nsaid in 1"
    slot.drop()


# Processes that trials start -----------------------------------------------------------------------------------------

STARTS = """
import os, signal, subprocess, sys, time
from pathlib import Path

def fly(trial, place):
    eats = "b'x' * 300_000_000" if trial.planner["then"] == "eats" else "0"
    code = f"import time; input(); eaten = {eats}; print('up', flush=True); time.sleep(600)"
    child = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    (Path(place.folder) / "child").write_text(str(child.pid))
    child.stdin.write(b"now\\n")
    child.stdin.close()
    child.stdout.readline()
    if trial.planner["then"] == "dies":
        os.kill(os.getpid(), signal.SIGSEGV)
    time.sleep(600)
"""


@pytest.fixture
def starts(study):
    folder = study()
    (folder / "starts.py").write_text(STARTS)
    return folder


def begun(then: str) -> Trial:
    return Trial(Case("here", then, None, json.dumps({"instance": {}, "planner": {"then": then}})), 0)


def is_gone(pid: int) -> bool:
    """A process that nobody has waited for yet is gone as well."""
    end = time.monotonic() + 60.0
    while psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE:
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


@pytest.mark.parametrize(
    ("then", "limits", "ending"),
    [("hangs", Limits(3.0, 2000.0), "hang"), ("eats", Limits(60.0, 250.0), "memory"), ("dies", SOUND, "crash")],
)
def test_what_a_trial_has_started_ends_with_it_and_its_memory_counts(then, limits, ending, starts):
    slot = Slot(Place("starts:fly", str(starts)), limits)
    outcome = slot.run(begun(then))
    assert outcome.ending == ending
    assert is_gone(int((starts / "child").read_text()))
    if then == "eats":
        assert outcome.memory_mb > 250
    slot.drop()


FLIES = """
import json, sys
from sooner.campaigns import Case, Limits, Place, Trial
from sooner.campaigns.slot import Slot

case = Case("here", "hangs", None, json.dumps({"instance": {}, "planner": {"then": "hangs"}}))
Slot(Place("starts:fly", sys.argv[1]), Limits(600.0, 2000.0)).run(Trial(case, 0))
"""


def test_what_a_trial_has_started_ends_with_whoever_asked_for_it(starts):
    with subprocess.Popen([sys.executable, "-c", FLIES, str(starts)], start_new_session=True) as client:
        end = time.monotonic() + 60.0
        while not (starts / "child").exists() or not (starts / "child").read_text():
            assert time.monotonic() < end
            time.sleep(0.01)
        os.killpg(client.pid, signal.SIGKILL)
    assert is_gone(int((starts / "child").read_text()))


def test_a_slot_can_be_closed_from_another_thread(flown, study):
    slot = Slot(Place("work:fly", str(study())), SOUND)
    came: list[Outcome] = []
    thread = threading.Thread(target=lambda: came.append(slot.run(trial("hangs"))))
    thread.start()
    while not psutil.Process().children():
        time.sleep(0.01)
    slot.close()
    thread.join()
    assert came[0].ending == "killed"
    slot.drop()


def test_mishaps_are_retried_once_then_set_aside_and_the_rest_goes_on(study, tmp_path, told):
    folder = study(
        'sound = {}\nsegfault = { mishap = "segfault" }\nhangs = { mishap = "hangs" }\n'
        'eats = { mishap = "eats" }\nraises = { mishap = "raises" }\nagain = { mishap = "raises once" }\n'
        'killed = { mishap = "killed" }\nspared = { mishap = "killed 4 times" }\n',
        trials=1,
        limits="seconds = 3\nmemory_mb = 400",
    )
    with run_study(read_study(folder), tmp_path / "out", workers=2) as ran:
        assert (ran.progress.done, ran.progress.aside, ran.progress.total) == (3, 5, 8)
        said = {trial.case.planner: (ending, reason) for trial, ending, reason in ran.ledger.failures(_cases(ran))}
    assert {planner: ending for planner, (ending, _) in said.items()} == {
        "segfault": "crash", "hangs": "hang", "eats": "memory", "raises": "error", "killed": "killed"
    }  # fmt: skip
    assert "the map has no snow" in said["raises"][1]
    failed = told(
        tmp_path / "out",
        "SELECT planner, count(*) FROM failures JOIN trials ON trials.id = trial_id JOIN cases ON cases.id = case_id "
        "GROUP BY planner",
    )
    assert dict(failed) == {
        "segfault": 2, "hangs": 2, "eats": 2, "raises": 2, "again": 1, "killed": 5, "spared": 4
    }  # fmt: skip


def test_trials_that_were_set_aside_fly_again_when_asked_to(study, tmp_path, told):
    folder = study('sound = {}\nraises = { mishap = "raises" }', trials=3)
    for retry, ended in ((False, 6), (False, 0), (True, 3)):
        rates = []
        with run_study(read_study(folder), tmp_path / "out", workers=1, retry=retry, watch=rates.append) as ran:
            assert (ran.progress.done, ran.progress.aside) == (3, 3)
        assert (rates[-1].rate > 0) == (ended > 0)
        assert ("no snow" in rates[-1].last_failure) == (ended > 0)
        assert len(told(tmp_path / "out", "SELECT 1 FROM failures")) == {False: 6, True: 12}[retry]


def test_a_machine_that_starts_no_process_ends_the_campaign_and_says_why(study, tmp_path, monkeypatch, told):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    folder = study(trials=3)
    with monkeypatch.context() as broken:
        broken.setattr("sooner.campaigns.slot.tempfile.TemporaryFile", full)
        with pytest.raises(DataFormatError, match=r"no process can be started .*No space left.*is kept"):
            run_study(read_study(folder), tmp_path / "out", workers=1)
    assert not (tmp_path / "out").exists()
    with run_study(read_study(folder), tmp_path / "out", trials=1, workers=1):
        pass
    with monkeypatch.context() as broken:
        broken.setattr("sooner.campaigns.slot.tempfile.TemporaryFile", full)
        broken.setattr(pool_module.Pool, "rehearse", lambda *_: {})
        with pytest.raises(DataFormatError, match=r"no process can be started .*No space left.*is kept"):
            run_study(read_study(folder), tmp_path / "out", workers=1)
    assert told(tmp_path / "out", "SELECT 1 FROM failures") == []
    with run_study(read_study(folder), tmp_path / "out", workers=1) as ran:
        assert ran.progress.done == 6


def test_workers_share_the_memory_of_the_machine():
    whole = psutil.virtual_memory().total / 2**20
    assert pool_module.share_of_memory_mb(3) == pytest.approx(0.3 * whole, rel=1e-6)
    assert 1 <= pool_module.cores() <= (os.cpu_count() or 1)


def _cases(ran):
    return [case for case, _ in ran.asked.cases]
