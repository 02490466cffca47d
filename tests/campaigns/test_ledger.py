"""The ledger: what is no ledger of this study is left as it is; what was recorded is kept whatever comes."""

import json
import os
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from sooner.campaigns import Case, Outcome, Trial, read_study, run_study
from sooner.campaigns.ledger import ASIDE, DONE, WAITING, Ledger
from sooner.campaigns.run import recall_study
from sooner.errors import DataFormatError

CASE = Case("here", "a", None, "{}")


def outcome(seed: int, ending: str = "done", value: object = 1) -> Outcome:
    said = json.dumps({"value": value}) if ending == "done" else ""
    return Outcome(Trial(CASE, seed), ending, said, "" if said else ending, 0.1, 0.1, 50.0, "{}")


def made(path: Path, trials: int = 500, study: str = "Small") -> Path:
    """A ledger with so many trials that are done."""
    with Ledger(path, study) as ledger:
        ledger.write([], [Trial(CASE, seed) for seed in range(trials)])
        ledger.write([(outcome(seed), DONE) for seed in range(trials)], [])
    return path


def changed(path: Path, *statements: str) -> None:
    with closing(sqlite3.connect(path, isolation_level=None)) as base:
        for statement in statements:
            base.execute(statement)


def another_study(path: Path) -> None:
    made(path, study="Large")


def of_version(number: int) -> Callable[[Path], None]:
    return lambda path: changed(made(path), f"PRAGMA user_version = {number}")


def another_application(path: Path) -> None:
    changed(path, "CREATE TABLE birds(name TEXT)", "INSERT INTO birds VALUES ('wren')")


def its_empty_database(path: Path) -> None:
    changed(path, "PRAGMA user_version = 7")


def a_text(path: Path) -> None:
    path.write_text("seed,value\n0,0.5\n" * 1000)


def a_short_text(path: Path) -> None:
    path.write_text("seed")


def damaged(page: int) -> Callable[[Path], None]:
    def damage(path: Path) -> None:
        made(path)
        with path.open("r+b") as file:
            file.seek(4096 * page)
            file.write(bytes(range(256)) * 16)

    return damage


def cut_short(path: Path) -> None:
    made(path)
    os.truncate(path, path.stat().st_size // 8192 * 4096)


def a_folder(path: Path) -> None:
    path.mkdir()
    (path / "note.txt").write_text("mine")


@pytest.mark.parametrize(
    ("left", "said"),
    [
        (another_study, "it is the ledger of the study 'Large', not of 'Small'; move it, or give another --out"),
        (
            of_version(0),
            "a ledger of version 0 .by sooner .*this sooner keeps version 1; finish it with the sooner that",
        ),
        (
            of_version(2),
            "a ledger of version 2 .by sooner .*this sooner keeps version 1; finish it with the sooner that",
        ),
        (another_application, "it is a database, but no ledger of sooner's; move it"),
        (its_empty_database, "it is a database, but no ledger of sooner's; move it"),
        (a_text, "it is no ledger, or a damaged one .file is not a database.; move it"),
        (a_short_text, "it is no ledger, or a damaged one .file is not a database.; move it"),
        (damaged(5), "damaged"),
        (damaged(12), "damaged"),
        (damaged(14), "damaged"),
        (cut_short, "damaged"),
        (a_folder, "it is a folder; expected a file"),
    ],
)
def test_what_is_no_sound_ledger_of_this_study_is_refused_and_left_as_it_is(left, said, tmp_path):
    path = tmp_path / "trials.sqlite"
    left(path)
    before = content(path)
    with pytest.raises(DataFormatError, match=said) as refused:
        Ledger(path, "Small")
    assert str(path) in str(refused.value)
    assert content(path) == before


def content(path: Path) -> bytes:
    return b"".join(file.read_bytes() for file in sorted([path] if path.is_file() else path.iterdir()))


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(
        DataFormatError, match=r"(?i)(not a directory|file exists).*expected a folder that can be written"
    ):
        Ledger(tmp_path / "out" / "trials.sqlite", "Small")
    assert (tmp_path / "out").read_text() == "a file"


def test_a_ledger_in_use_is_refused(tmp_path):
    path = tmp_path / "trials.sqlite"
    with (
        Ledger(path, "Small"),
        pytest.raises(DataFormatError, match="another sooner is flying this campaign; wait until"),
    ):
        Ledger(path, "Small")
    Ledger(path, "Small").close()


def in_a_world_of_its_own(folder: Path, mount: str, script: str) -> str:
    """What a script says where a file system of its own lies over a folder."""
    if (
        shutil.which("unshare") is None
        or subprocess.run(
            ["unshare", "-rm", "mount", "-t", "tmpfs", "tmpfs", str(folder)], capture_output=True
        ).returncode
    ):
        pytest.skip("this machine lets nobody mount a file system")
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", f'{mount} && exec "$0" -c "$1" "$2"', sys.executable, script, str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


REFUSED = """
import sys
from pathlib import Path
from sooner.campaigns.ledger import Ledger
from sooner.errors import DataFormatError
try:
    Ledger(Path(sys.argv[1]) / "trials.sqlite", "Small")
except DataFormatError as error:
    print(error)
"""


@pytest.mark.parametrize("there", [True, False], ids=["with a ledger", "without one"])
def test_a_read_only_folder_is_refused(there, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    if there:
        made(folder / "trials.sqlite")
    before = content(folder)
    said = in_a_world_of_its_own(
        folder, f"mount --bind {folder} {folder} && mount -o remount,ro,bind {folder}", REFUSED
    )
    assert "it cannot be written" in said
    assert "expected a folder and a ledger that can be written to; give another --out" in said
    assert content(folder) == before


FULL = """
import subprocess, sys
from pathlib import Path
from sooner.campaigns import read_study, run_study
from sooner.errors import DataFormatError
out = Path(sys.argv[1])
study = read_study(out.parent / "study")
try:
    run_study(study, out, workers=1)
except DataFormatError as error:
    print(error)
subprocess.run(["mount", "-o", "remount,size=20m", str(out)], check=True)
told = []
with run_study(study, out, workers=1, watch=told.append) as ran:
    print(told[0].done, ran.progress.done)
"""


def test_a_full_disk_ends_the_campaign_and_all_that_was_recorded_is_kept(study, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    study("a = { words = 20000 }", trials=100)
    said = in_a_world_of_its_own(folder, f"mount -t tmpfs -o size=1m tmpfs {folder}", FULL)
    message, counts = said.strip().splitlines()
    assert (
        "the disk is full; make room and give the same command again; every trial that was recorded is kept" in message
    )
    kept, done = map(int, counts.split())
    assert 10 < kept < 100
    assert done == 100


def test_a_limit_on_the_size_of_files_is_told_and_all_that_was_recorded_is_kept(tmp_path):
    path = tmp_path / "trials.sqlite"
    with Ledger(path, "Small") as ledger:
        ledger.write([], [Trial(CASE, seed) for seed in range(50)])
        ledger._base.execute("PRAGMA max_page_count = 40")
        for seed in range(50):
            try:
                ledger.write([(outcome(seed, value="x" * 5000), DONE)], [])
            except DataFormatError as error:
                assert "the disk is full" in str(error)  # noqa: PT017
                break
        done = ledger.counts(CASE, range(50)).done
        assert 0 < done == seed
    with Ledger(path, "Small") as ledger:
        assert ledger.counts(CASE, range(50)).done == done
        assert ledger.recover() == 50 - done


@pytest.fixture
def ledger(tmp_path):
    with Ledger(tmp_path / "trials.sqlite", "Small") as opened:
        yield opened


def test_an_answer_counts_once_and_only_where_a_trial_was_begun(ledger):
    ledger.write([(outcome(3), DONE)], [])
    assert list(ledger.rows(CASE, range(9))) == []
    ledger.write([], [Trial(CASE, 3)])
    ledger.write([(outcome(3), DONE), (outcome(3, value=2), DONE)], [Trial(CASE, 3)])
    ledger.write([(outcome(3, value=3), DONE), (outcome(3, "error"), WAITING)], [])
    assert list(ledger.answers(CASE, range(9))) == [(3, {"value": 1})]
    assert ledger.counts(CASE, range(9)).done == 1


def test_failures_are_the_last_of_those_set_aside(ledger):
    for ending, state in (("error", WAITING), ("crash", ASIDE)):
        ledger.write([], [Trial(CASE, 0), Trial(CASE, 1)])
        ledger.write([(outcome(0, ending), state), (outcome(1, ending), WAITING)], [])
    assert ledger.failures([CASE]) == [(Trial(CASE, 0), "crash", "crash")]
    assert ledger.attempts(Trial(CASE, 0)) == 2


def test_a_write_that_fails_leaves_nothing_of_itself(ledger):
    other = Case("there", "b", 5, "{}")
    with pytest.raises(DataFormatError):
        ledger.write([], [Trial(other, 1), Trial(other, None)])
    assert list(ledger.rows(other, range(9))) == []
    ledger.write([], [Trial(other, 1)])
    assert [row["state"] for row in ledger.rows(other, range(9))] == ["leased"]


def test_a_ledger_put_aside_is_unharmed_and_an_empty_one_takes_its_place(tmp_path):
    path = made(tmp_path / "trials.sqlite", 20)
    names = []
    for trials in (20, 10):
        with Ledger(path, "Small") as ledger:
            aside = ledger.begin_anew()
            assert ledger.counts(CASE, range(99)).done == 0
        names.append(aside.name)
        with Ledger(aside, "Small") as ledger:
            assert ledger.counts(CASE, range(99)).done == trials
        path.unlink()
        made(path, 10)
    assert names == ["trials-1.sqlite", "trials-2.sqlite"]


def test_only_trials_that_are_asked_for_are_given_another_chance(ledger):
    other = Case("there", "b", 5, "{}")
    trials = [Trial(CASE, 0), Trial(CASE, 1), Trial(other, 0)]
    ledger.write([], trials)
    ledger.write([(Outcome(each, "error", "", "bad luck", provenance="{}"), ASIDE) for each in trials], [])
    ledger.retry([(CASE, range(1))])
    states = [row["state"] for case in (CASE, other) for row in ledger.rows(case, range(9))]
    assert states == ["waiting", "aside", "aside"]


def test_who_flew_the_trials_that_are_asked_for_is_told_and_other_packages_are_noted(study, tmp_path, told):
    folder, out = study(trials=3), tmp_path / "out"
    with run_study(read_study(folder), out, workers=1) as ran:
        ((_, source, data, trials),) = ran.sources()
        assert (len(source), len(data), trials) == (16, 16, 6)
    path = out / "trials.sqlite"
    changed(path, """UPDATE provenance SET text = json_set(text, '$.packages.numpy', '1.0', '$.python', '2.7')""")
    notes = []
    with run_study(read_study(folder), out, trials=4, workers=1, watch=lambda p: notes.append(p.notes)) as ran:
        assert sorted(each[3] for each in ran.sources()) == [8]
    with recall_study(read_study(folder), out, trials=2) as ran:
        assert [each[3] for each in ran.sources()] == [4]
    ((note,),) = set(notes)
    assert note.startswith("6 trials were flown with Python 2.7 (now 3.")
    assert ", numpy 1.0 (now " in note


def test_results_of_other_code_are_mixed_in_only_when_asked_for(study, tmp_path, told):
    folder, out = study(trials=3), tmp_path / "out"
    run_study(read_study(folder), out, workers=1).ledger.close()
    before = told(out, "SELECT * FROM answers")
    (folder / "more.py").write_text("CHANGED = True\n")
    with pytest.raises(DataFormatError, match=r"6 trials were flown by other code .*--earlier keep .*--earlier redo"):
        run_study(read_study(folder), out, workers=1)
    assert told(out, "SELECT * FROM answers") == before
    with run_study(read_study(folder), out, trials=4, workers=1, earlier="keep") as ran:
        assert (ran.progress.done, len(ran.ledger.provenances(case for case, _ in ran.asked.cases))) == (8, 2)
    with run_study(read_study(folder), out, trials=4, workers=1, earlier="redo") as ran:
        assert (ran.progress.done, len(ran.ledger.provenances(case for case, _ in ran.asked.cases))) == (8, 1)
    shutil.copy(out / "trials-1.sqlite", tmp_path / "trials.sqlite")
    assert told(tmp_path, "SELECT count(*) FROM answers") == [(8,)]
    assert set(before) <= set(told(tmp_path, "SELECT * FROM answers"))
