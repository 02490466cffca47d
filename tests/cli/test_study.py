"""`sooner study` and `sooner reproduce`."""

import csv
import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest

from sooner.campaigns.cluster import Cluster
from sooner.experiments import published as papers

TRIAL = """
import time
from pathlib import Path

def fly(trial, place):
    if (Path(place.folder) / "broken").exists() and trial.planner.get("breaks"):
        raise RuntimeError("it broke")
    time.sleep(trial.instance.get("sleep", 0.0))
    return {"value": trial.seed + trial.planner["width"], "timing": {"seconds": 0.5}}
"""
STUDY = """
title = "Small"
trial = "my_trial:fly"
trials = 3
[instances]
hills = {}
[planners]
a = { width = 1 }
b = { width = 2, breaks = true }
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "my_trial.py").write_text(TRIAL, encoding="utf-8")
    (tmp_path / "mine.toml").write_text(STUDY, encoding="utf-8")
    return tmp_path / "mine.toml"


@pytest.fixture
def out(study):
    return study.parent / "mine-results"


def flown(out):
    with (out / "trials.csv").open(newline="", encoding="utf-8") as file:
        return [(row["planner"], int(row["seed"]), row["value"]) for row in csv.DictReader(file)]


def test_a_study_is_flown_told_and_not_flown_twice(sooner, study, out):
    ended = sooner("study", study, "--workers", "1")
    assert ended.status == 0
    assert "6 of 6 trials" in ended.err
    written = [line.removeprefix("written  ") for line in ended.out.splitlines()]
    assert str(out / "summary.md") in written
    assert str(out / "summary.png") in written
    assert str(out / "trials.sqlite") in written
    assert all(os.path.exists(file) for file in written)  # noqa: PTH110
    assert flown(out) == [("a", seed, str(seed + 1)) for seed in range(3)] + [
        ("b", seed, str(seed + 2)) for seed in range(3)
    ]
    before = (out / "trials.csv").read_bytes()
    again = sooner("study", study, "--workers", "1")
    assert "6 of 6 trials were flown before" in again.err
    assert (out / "trials.csv").read_bytes() == before


def test_json_is_exactly_one_object_and_quiet_says_nothing_else(sooner, study, out):
    ended = sooner("study", study, "--workers", "1", "--trials", "1", "--json", "--quiet")
    assert ended.err == ""
    told = ended.json
    assert (told["trials"], told["done"], told["aside"]) == (2, 2, 0)
    assert str(out / "summary.md") in told["files"]


def test_a_slice_grows_and_keeps_what_it_has(sooner, study, tmp_path):
    out = tmp_path / "elsewhere"
    for trials, flown_before in ((1, None), (2, "2 of 4 trials were flown before")):
        ended = sooner("study", study, "--workers", "1", "--trials", trials, "--out", out)
        assert (flown_before or "0 of 2 trials") in ended.err
    assert len(flown(out)) == 4


def test_the_folder_of_a_study_stands_for_its_study_toml(sooner, study, tmp_path):
    study.rename(tmp_path / "study.toml")
    assert sooner("study", tmp_path, "--workers", "1", "--trials", "1").status == 0
    assert (tmp_path / "study-results" / "summary.md").is_file()


def test_tables_of_the_study_are_written(sooner, study, out):
    study.write_text(STUDY + "[[tables]]\nname = 'T'\nversus = 'a'\n", encoding="utf-8")
    assert sooner("study", study, "--workers", "1").status == 0
    assert "| b | 1.00 |" in (out / "tables.md").read_text(encoding="utf-8")
    assert (out / "tables.csv").is_file()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("trials = 3", "trials = 0", "trials: 0 came"),
        ("width = 2", "width = nan", "planners.b.width: nan came"),
        ('trial = "my_trial:fly"', "", "instances.hills: {} came; expected mission = FILE or scenario = NAME"),
        ("[planners]", "[planets]", "planets: there is no such key"),
    ],
)
def test_a_study_with_a_fault_is_refused_and_nothing_is_left(sooner, study, out, old, new, told):
    study.write_text(STUDY.replace(old, new), encoding="utf-8")
    ended = sooner("study", study)
    assert (ended.status, ended.out) == (2, "")
    assert told in ended.err
    assert all(line.startswith("sooner: ") for line in ended.err.splitlines())
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--earlier", "maybe"], "--earlier: 'maybe' came; expected one of ask, keep, redo"),
        (["--data", "no/such"], "--data: 'no/such' came; expected a folder that exists"),
        (["--scheduler", "tcp://x:1", "--workers", "2"], "--workers: 2 came with --scheduler"),
        (["--trials", "0"], "--trials"),
        (["--workers", "0"], "--workers"),
    ],
)
def test_a_bad_option_is_refused_before_anything_is_flown(sooner, study, out, arguments, told):
    ended = sooner("study", study, *arguments)
    assert ended.status == 2
    assert told in ended.err
    assert not out.exists()


def test_a_scheduler_that_is_not_there_is_told_and_costs_nothing(sooner, study, out, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("sooner.campaigns.cluster.Cluster", partial(Cluster, patience_s=0.5))
    ended = sooner("study", study, "--scheduler", "tcp://127.0.0.1:1")
    assert ended.status == 2
    assert "--scheduler: 'tcp://127.0.0.1:1' came, and no scheduler of Dask answers there" in ended.err
    assert sooner("study", study, "--workers", "1").status == 0


def test_a_report_that_somebody_edited_stops_the_study_before_it_flies(sooner, study, out):
    assert sooner("study", study, "--workers", "1", "--trials", "1").status == 0
    (out / "summary.md").write_text("my notes", encoding="utf-8")
    ended = sooner("study", study, "--workers", "1")
    assert ended.status == 2
    assert "summary.md: this file has been changed since sooner wrote it" in ended.err
    assert "of 6 trials" not in ended.err
    assert sooner("study", study, "--workers", "1", "--force").status == 0


def test_results_of_other_code_are_asked_about_kept_or_flown_again(sooner, study, out):
    small = ("study", study, "--workers", "1", "--trials", "1")
    assert sooner(*small).status == 0
    (study.parent / "my_trial.py").write_text(TRIAL.replace("trial.seed +", "10 +"), encoding="utf-8")
    asked = sooner(*small)
    assert asked.status == 2
    assert "2 trials were flown by other code or on other maps" in asked.err
    assert "--earlier keep to count them, --earlier redo to fly all of them again" in asked.err
    assert sooner(*small, "--earlier", "keep").status == 0
    assert flown(out) == [("a", 0, "1"), ("b", 0, "2")]
    assert sooner(*small, "--earlier", "redo").status == 0
    assert flown(out) == [("a", 0, "11"), ("b", 0, "12")]
    assert (out / "trials-1.sqlite").is_file()


def test_what_was_kept_once_is_not_asked_about_again_but_newer_code_is(sooner, study, out):
    small = ("study", study, "--workers", "1", "--trials")
    trial = study.parent / "my_trial.py"
    assert sooner(*small, "1").status == 0
    trial.write_text(TRIAL + "# one", encoding="utf-8")
    assert sooner(*small, "2", "--earlier", "keep").status == 0
    assert sooner(*small, "3").status == 0
    trial.write_text(TRIAL + "# two", encoding="utf-8")
    asked = sooner(*small, "3")
    assert asked.status == 2
    assert "4 trials were flown by other code" in asked.err


def test_where_the_earlier_ledger_went_is_told(sooner, study, out):
    assert sooner("study", study, "--workers", "1", "--trials", "1").status == 0
    (study.parent / "my_trial.py").write_text(TRIAL + "# changed", encoding="utf-8")
    ended = sooner("study", study, "--workers", "1", "--trials", "1", "--earlier", "redo")
    assert f"note: the earlier ledger is now {out / 'trials-1.sqlite'}" in ended.err


def test_more_trials_than_a_study_may_have_are_refused(sooner, study, out):
    ended = sooner("study", study, "--trials", "1000000000")
    assert ended.status == 2
    assert "1,000,000,000 trials came; expected at most 100,000,000 of each case" in ended.err
    assert not out.exists()


def test_trials_that_fail_are_set_aside_told_and_flown_again_when_asked(sooner, study, out):
    (study.parent / "broken").touch()
    ended = sooner("study", study, "--workers", "1")
    assert ended.status == 2
    assert "set aside: b on hills, seed 0: error: RuntimeError: it broke" in ended.err
    assert "3 of 6 trials have no answer; 3 trials were set aside; --retry flies them again" in ended.err
    assert ("b", 0, "") in flown(out)
    (study.parent / "broken").unlink()
    assert sooner("study", study, "--workers", "1", "--json").json["aside"] == 3
    assert sooner("study", study, "--workers", "1", "--json", "--retry").json["aside"] == 0
    assert ("b", 0, "2") in flown(out)


def test_a_hopeless_planner_is_told_in_one_line_and_the_report_is_of_the_others(sooner, study, out):
    (study.parent / "broken").touch()
    study.write_text(STUDY.replace("trials = 3", "trials = 40"), encoding="utf-8")
    ended = sooner("study", study, "--workers", "1", "--quiet")
    assert ended.status == 2
    note, last = ended.err.splitlines()
    assert note.startswith(
        "note: b: all of its first 20 attempts failed, the rest is not flown; the last one: b on hil"
    )
    assert note.endswith("error: RuntimeError: it broke")
    assert last == "40 of 80 trials have no answer"
    assert (out / "summary.md").exists()
    (study.parent / "broken").unlink()
    assert sooner("study", study, "--workers", "1", "--quiet", "--json").json["done"] == 80


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("my_trial:fly", "nowhere:fly", "trial: 'nowhere:fly' cannot be loaded (ModuleNotFoundError: No module named"),
        ("my_trial:fly", "my_trial:soar", "trial: 'my_trial:soar' cannot be loaded (AttributeError: "),
        ("my_trial:fly", "ends:fly", "trial: 'ends:fly' cannot be loaded (its process ended with exit status 3)"),
    ],
)
def test_a_trial_that_cannot_be_loaded_is_told_before_anything_flies_and_nothing_is_left(
    sooner, study, out, old, new, told
):
    (study.parent / "ends.py").write_text("import os\nos._exit(3)\n", encoding="utf-8")
    study.write_text(STUDY.replace(old, new), encoding="utf-8")
    ended = sooner("study", study, "--workers", "1")
    assert (ended.status, ended.out) == (2, "")
    assert f"mine.toml: {told}" in ended.err
    assert len(ended.err.splitlines()) == 1
    assert not out.exists()


def test_planners_of_the_users_own_that_cannot_be_made_are_told_at_once(sooner, study, out):
    (study.parent / "mine.py").write_text("class Mine:\n    def __init__(self, width=1): pass\n", encoding="utf-8")
    planners = ['"nowhere:Mine"', '"mine:Yours"', '"mine:Mine", height = 3', '"mine:Mine", width = 3']
    table = "\n".join(f"{name} = {{ make = {said}, ticks = 1 }}" for name, said in zip("abcd", planners, strict=True))
    text = f'title = "S"\n[instances]\nhills = {{ scenario = "bimodal", size = 8 }}\n[planners]\n{table}\n'
    study.write_text(text, encoding="utf-8")
    ended = sooner("study", study, "--workers", "1")
    assert ended.status == 2
    first, second, third = ended.err.splitlines()
    assert "planners.a: it cannot be made (ModuleNotFoundError: No module named 'nowhere')" in first
    assert "planners.b: it cannot be made (AttributeError: module 'mine' has no attribute 'Yours')" in second
    assert "planners.c: it cannot be made (TypeError: " in third
    assert not out.exists()


def test_a_report_is_written_of_what_is_there_and_nothing_is_flown(sooner, study, out):
    nothing = sooner("study", study, "--report")
    assert nothing.status == 2
    assert "trials.sqlite: it is not there; fly the study first" in nothing.err
    assert sooner("study", study, "--workers", "1", "--trials", "2").status == 0
    for file in out.glob("summary.*"):
        file.unlink()
    ended = sooner("study", study, "--report")
    assert ended.status == 2
    assert "2 of 6 trials have no answer" in ended.err
    assert (out / "summary.md").exists()
    assert sooner("study", study, "--report", "--trials", "2").status == 0
    refused = sooner("study", study, "--report", "--retry")
    assert "--report: it came with --retry or --earlier; leave them out: it flies nothing" in refused.err


def test_ctrl_c_keeps_what_is_flown_and_the_same_command_goes_on(sooner, study, out):
    study.write_text(STUDY.replace("hills = {}", "hills = { sleep = 0.2 }").replace("= 3", "= 8"), encoding="utf-8")
    command = [sys.executable, "-m", "sooner", "study", str(study), "--workers", "1", "--json"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    with process:
        while not (out / "trials.sqlite").exists() or not _done(out):
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)  # as Ctrl-C; which a shell may have told its background jobs to ignore
        told, said = process.communicate()
    assert process.returncode == 130
    assert told == ""
    assert "of 16 trials are kept; the same command goes on from there, with --report it tells of those" in said
    assert "nothing was written" not in said
    kept = _done(out)
    assert 0 < kept < 16
    ended = sooner("study", study, "--workers", "2", "--json")
    assert f"{kept} of 16 trials were flown before" in ended.err
    assert ended.json["done"] == 16


def _done(out):
    import sqlite3
    from contextlib import closing

    with closing(sqlite3.connect(f"file:{out / 'trials.sqlite'}?mode=ro", uri=True)) as base:
        try:
            return base.execute("SELECT count(*) FROM answers").fetchone()[0]
        except sqlite3.OperationalError:  # its tables are not there yet
            return 0


# reproduce -----------------------------------------------------------------------------------------------------------

PAPER = (
    STUDY
    + """
[[tables]]
name = "Table I"
column = "mean"
[[tables]]
name = "Table II"
planners = ["a"]
column = "mean"
times = "Table II Speed"
[[rules]]
near = 5.0
reason = "chance"
"""
)
PRINTED = "table,row,column,value,page\nTable I,a,mean,2.00,p. 1\nTable I,b,mean,4.00,p. 1\nTable II,a,mean,9.9,p. 2\n"


@pytest.fixture
def paper(study, tmp_path, monkeypatch):
    home = tmp_path / "papers" / "lin2014"
    home.mkdir(parents=True)
    (home / "study.toml").write_text(PAPER, encoding="utf-8")
    (home / "published.csv").write_text(PRINTED, encoding="utf-8")
    (home / "my_trial.py").write_text(TRIAL, encoding="utf-8")
    monkeypatch.setattr(papers, "_studies", lambda: (tmp_path / "papers",))
    return ("reproduce", "lin2014", "--data", tmp_path, "--workers", "1", "--out", tmp_path / "out")


def test_a_paper_is_flown_and_compared(sooner, paper, tmp_path):
    ended = sooner(*paper)
    assert ended.status == 0
    assert {"reproduced.csv", "comparison.md", "summary.md", "trials.csv"} <= {
        p.name for p in (tmp_path / "out").iterdir()
    }
    assert f"written  {tmp_path / 'out' / 'comparison.md'}" in ended.out
    told = (tmp_path / "out" / "comparison.md").read_text(encoding="utf-8")
    assert "| a | mean | 2.00 | 2.00 | 1.00 to 3.00 | 3 | +0.00 | same |" in told
    assert "| b | mean | 4.00 | 3.00 |" in told
    assert "Table II Speed" in told


def test_a_slice_of_a_paper_is_one_json_object(sooner, paper):
    told = sooner(*paper, "--trials", "1", "--json", "--quiet").json
    assert (told["trials"], told["done"], told["aside"]) == (3, 3, 0)
    assert any(file.endswith("reproduced.csv") for file in told["files"])


def test_only_some_tables_are_flown_and_rows_of_others_are_kept(sooner, paper, tmp_path):
    assert sooner(*paper, "--only", "Table I", "--json").json["trials"] == 6
    assert sooner(*paper, "--only", "Table II*", "--json").json["trials"] == 6
    told = (tmp_path / "out" / "reproduced.csv").read_text(encoding="utf-8")
    assert "Table I,b,mean,3," in told
    assert "Table II,a,mean,2," in told
    ended = sooner(*paper, "--only", "Table X")
    assert ended.status == 2
    assert "Table X came; expected some of 'Table I', 'Table II'" in ended.err


def test_rows_of_other_code_are_mixed_with_those_of_some_tables_only_when_asked_for(sooner, paper, tmp_path):
    assert sooner(*paper, "--only", "Table I", "--json").status == 0
    (tmp_path / "papers" / "lin2014" / "my_trial.py").write_text(TRIAL + "# changed", encoding="utf-8")
    asked = sooner(*paper, "--only", "Table II")
    assert asked.status == 2
    assert "6 trials were flown by other code" in asked.err
    assert sooner(*paper, "--only", "Table II", "--earlier", "keep").status == 0
    assert sooner(*paper, "--only", "Table II").status == 0


def test_earlier_and_retry_work_for_papers_too(sooner, paper, tmp_path):
    home = tmp_path / "papers" / "lin2014"
    (home / "broken").touch()
    small = (*paper, "--trials", "1", "--json")
    assert sooner(*small).json["aside"] == 1
    (home / "broken").unlink()
    assert sooner(*small, "--retry").json["aside"] == 0
    (home / "my_trial.py").write_text(TRIAL.replace("trial.seed +", "10 +"), encoding="utf-8")
    assert "were flown by other code" in sooner(*small).err
    assert sooner(*small, "--earlier", "redo").json["done"] == 3
    assert "Table I,b,mean,12," in (tmp_path / "out" / "reproduced.csv").read_text(encoding="utf-8")


def test_a_comparison_that_sooner_did_not_write_is_left_alone_and_nothing_is_flown(sooner, paper, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "comparison.md").write_text("mine", encoding="utf-8")
    ended = sooner(*paper)
    assert ended.status == 2
    assert "comparison.md: a file of that name is there, and sooner did not write it" in ended.err
    assert not (tmp_path / "out" / "trials.sqlite").exists()
    assert sooner(*paper, "--trials", "1", "--force").status == 0


def test_maps_that_are_missing_are_named(sooner, paper, tmp_path):
    text = PAPER.replace('title = "Small"', 'title = "Small"\ndata = "maps"\ndata_files = ["a_*", "b_*"]')
    (tmp_path / "papers" / "lin2014" / "study.toml").write_text(text, encoding="utf-8")
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "a_1.csv").touch()
    ended = sooner(*paper)
    assert ended.status == 2
    assert "maps/b_* is not there; give --data DIR or set SOONER_DATA" in ended.err
