"""What a study leaves: its files, whole, and never over somebody else's."""

import csv

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.campaigns.report import COLUMNS, REPORT, _apart, write_report
from sooner.campaigns.study import read_study
from sooner.errors import DataFormatError
from sooner.io.writing import Folder
from tests.campaigns.filled import MADE_BY, filled

STUDY = """
title = "Small | one"
trials = 4
budgets = [40]
[instances]
hills = {}
plain = {}
[planners]
a = {}
b = {}
"""


def answer(trial):
    if (trial.case.instance, trial.case.planner, trial.seed) == ("plain", "b", 3):
        return None
    value = trial.seed + (10 if trial.case.planner == "b" else 0)
    return {"value": value, "found": trial.seed > 1, "path": [1, 2], "timing": {"seconds": 0.5}, "why": "done"}


@pytest.fixture
def study(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    return read_study(tmp_path)


@pytest.fixture
def ran(study, tmp_path):
    with filled(study, tmp_path / "out", answer) as found:
        yield found


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_report_is_a_page_a_picture_tables_and_every_trial(ran, tmp_path):
    report = write_report(ran, "Small | one", Folder(tmp_path / "out"))
    assert sorted(file.name for file in report.files) == sorted(REPORT)
    assert all(file.stat().st_size for file in report.files)
    assert (tmp_path / "out" / "summary.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert page.startswith("# Small \\| one\n\n15 trials finished, 1 were set aside.")
    left = {file.name for file in (tmp_path / "out").iterdir()} - set(REPORT)
    assert {name for name in left if not name.startswith("trials.sqlite")} == {".sooner-files.json"}


def test_every_trial_has_a_line_with_what_it_was_took_and_answered_and_what_flew_it(ran, tmp_path):
    write_report(ran, "Small", Folder(tmp_path / "out"))
    lines = rows(tmp_path / "out" / "trials.csv")
    assert len(lines) == 16
    line = next(row for row in lines if (row["instance"], row["planner"], row["seed"]) == ("hills", "b", "2"))
    told = (
        "budget",
        "state",
        "attempts",
        "wall_s",
        "cpu_s",
        "memory_mb",
        "commit",
        "packages",
        "value",
        "found",
        "why",
    )
    assert [line[key] for key in told] == [
        "40", "done", "1", "0.5", "0.25", "100.0", "abc", "numpy-2", "12", "true", "done"
    ]  # fmt: skip
    assert line["timing.seconds"] == "0.5"
    assert line["ended_at"].endswith("Z")
    assert "path" not in line


def test_a_trial_that_was_set_aside_has_a_line_with_its_reason_and_no_number(ran, tmp_path):
    write_report(ran, "Small", Folder(tmp_path / "out"))
    (line,) = (row for row in rows(tmp_path / "out" / "trials.csv") if row["state"] == "aside")
    assert (line["reason"], line["value"], line["found"]) == ("error: Boom: it broke", "", "")


def test_parquet_holds_the_same_lines(ran, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    write_report(ran, "Small", Folder(tmp_path / "out"))
    table = parquet.read_table(tmp_path / "out" / "trials.parquet")
    lines = rows(tmp_path / "out" / "trials.csv")
    assert table.column_names == list(lines[0])
    assert [str(v) if v is not None else "" for v in table["value"].to_pylist()] == [row["value"] for row in lines]


def test_what_sooner_did_not_write_or_somebody_edited_is_left_alone_unless_forced(ran, tmp_path):
    out = tmp_path / "out"
    (out / "summary.csv").write_text("my own", encoding="utf-8")
    with pytest.raises(DataFormatError, match=r"summary\.csv: a file of that name is there, and sooner did not write"):
        write_report(ran, "Small", Folder(out))
    assert (out / "summary.csv").read_text(encoding="utf-8") == "my own"
    assert not (out / "summary.md").exists()
    assert not list(out.glob(".sooner-*.tmp"))
    write_report(ran, "Small", Folder(out, force=True))
    write_report(ran, "Small", Folder(out))
    (out / "summary.md").write_text("my notes", encoding="utf-8")
    with pytest.raises(DataFormatError, match=r"summary\.md: this file has been changed since sooner wrote it"):
        write_report(ran, "Small", Folder(out))


def test_other_files_are_written_with_the_report_or_not_at_all(ran, tmp_path):
    report = write_report(ran, "Small", Folder(tmp_path / "out"), {"tables.md": b"# T\n"})
    assert report.files[-1].read_bytes() == b"# T\n"


def test_writing_again_gives_the_same_bytes(ran, tmp_path):
    first, second = (write_report(ran, "Small", Folder(tmp_path / name)) for name in ("one", "two"))
    for one, two in zip(first.files, second.files, strict=True):
        assert one.read_bytes() == two.read_bytes(), one.name


@pytest.mark.parametrize(("measure", "shown"), [("value", "value"), ("no such", "value"), ("found", "found")])
def test_the_picture_shows_the_measure_of_the_study_or_else_the_first_there_is(
    ran, tmp_path, monkeypatch, measure, shown
):
    drawn = []
    monkeypatch.setattr("sooner.plotting.plot_summary", lambda *told: drawn.append(told) or b"PNG")
    write_report(ran, "Small", Folder(tmp_path / "out"), measure=measure)
    ((title, name, places, yes_no, note),) = drawn
    lacking = "no trial has a number called 'no such'; they have 'value', 'found', 'timing.seconds'"
    assert note == (lacking if measure == "no such" else "")
    assert (title, name, yes_no) == ("Small", shown, shown == "found")
    assert list(places) == ["hills, budget 40", "plain, budget 40"]
    assert [len(sample.values) for sample in places["plain, budget 40"]] == [4, 3]
    if shown == "value":
        assert places["hills, budget 40"][1].mean == 11.5


def test_a_campaign_without_a_number_has_a_report_without_a_picture(study, tmp_path):
    with filled(study, tmp_path / "none", lambda trial: None) as ran:
        report = write_report(ran, "Small", Folder(tmp_path / "none"))
    assert "summary.png" not in {file.name for file in report.files}
    assert "4 set aside" in (tmp_path / "none" / "summary.md").read_text(encoding="utf-8")


def test_a_measure_that_no_trial_has_is_said_on_the_page_and_to_the_caller(ran, tmp_path):
    report = write_report(ran, "Small", Folder(tmp_path / "out"), measure="valeu")
    told = "no trial has a number called 'valeu'; they have 'value', 'found', 'timing.seconds'"
    assert told in report.notes
    assert f"# Small\n\n{told}\n" in (tmp_path / "out" / "summary.md").read_text(encoding="utf-8")
    assert not write_report(ran, "Small", Folder(tmp_path / "out")).notes


def test_an_answer_cannot_pass_for_what_the_trial_is(study, tmp_path):
    said = {"seed": 99, "planner": "best", "value": 0.5, "answer": {"seed": 7}, "state": True}
    with filled(study, tmp_path / "sly", lambda trial: said) as ran:
        write_report(ran, "Sly", Folder(tmp_path / "sly"))
    lines = rows(tmp_path / "sly" / "trials.csv")
    assert {line["seed"] for line in lines} == set("0123")
    assert {line["planner"] for line in lines} == {"a", "b"}
    assert {line["state"] for line in lines} == {"done"}
    told = ("answer.seed", "answer.answer.seed", "answer.planner", "answer.state")
    assert [lines[0][name] for name in told] == ["7", "99", "best", "true"]


@given(st.dictionaries(st.sampled_from(["seed", "answer.seed", "answer.answer.seed", "state", "x"]), st.integers()))
def test_every_value_of_an_answer_keeps_a_column_of_its_own(said):
    found = _apart(said)
    assert sorted(found.values()) == sorted(said.values())
    assert not found.keys() & COLUMNS.keys()


def test_a_planner_whose_trials_all_failed_is_in_the_picture_as_such(study, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr("sooner.plotting.plot_summary", lambda *told: drawn.append(told) or b"PNG")

    def said(trial):
        if trial.case.planner == "a":
            return None if trial.case.instance == "hills" else {"found": True}
        return {"value": 1.0}

    with filled(study, tmp_path / "some", said) as ran:
        write_report(ran, "Some", Folder(tmp_path / "some"))
    ((_, measure, places, *_),) = drawn
    assert measure == "value"
    told = {place: [(sample.planner, sample.note) for sample in samples] for place, samples in places.items()}
    assert told == {
        "hills, budget 40": [("a", "all 4 trials failed"), ("b", "")],
        "plain, budget 40": [("a", "none of 4 trials has the number"), ("b", "")],
    }


def test_results_of_several_sources_are_said_to_be_mixed(study, tmp_path, monkeypatch):
    with filled(study, tmp_path / "one", answer) as ran:
        write_report(ran, "One", Folder(tmp_path / "one"))
        assert "mixed" not in (tmp_path / "one" / "summary.md").read_text(encoding="utf-8")
        other = {**MADE_BY, "commit": "def", "source": "t"}
        monkeypatch.setattr(type(ran.ledger), "provenances", lambda self, *asked: [(MADE_BY, 9), (other, 6)])
        report = write_report(ran, "Two", Folder(tmp_path / "one"))
    page = (tmp_path / "one" / "summary.md").read_text(encoding="utf-8")
    assert "results of 2 sources are mixed here: 9 trials of commit abc" in page
    assert "6 trials of commit def" in page
    assert any("mixed" in note for note in report.notes)


def test_parquet_files_of_several_campaigns_fit_together(study, tmp_path):
    parquet, pyarrow = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("pyarrow")
    with filled(study, tmp_path / "one", lambda trial: {"value": 0.5}) as ran:  # no reason, whole budgets
        write_report(ran, "One", Folder(tmp_path / "one"))
    text = STUDY.replace("budgets = [40]", "budgets = [0.5]").replace("Small | one", "Other")
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    with filled(read_study(tmp_path), tmp_path / "two", lambda trial: None) as ran:  # nothing but reasons
        write_report(ran, "Two", Folder(tmp_path / "two"))
    tables = [parquet.read_table(tmp_path / name / "trials.parquet") for name in ("one", "two")]
    for table in tables:
        types = {name: str(table.schema.field(name).type) for name in COLUMNS}
        assert types == {
            name: {"text": "string", "number": "double", "whole": "int64", "yes_no": "bool"}[kind]
            for name, kind in COLUMNS.items()
        }
    assert pyarrow.concat_tables([table.select(list(COLUMNS)) for table in tables]).num_rows == 32
    assert {row["budget"] for row in rows(tmp_path / "one" / "trials.csv")} == {"40"}
