"""What a study leaves: its files, whole, and never over somebody else's."""

import csv

import pytest

from sooner.campaigns.report import REPORT, write_report
from sooner.campaigns.study import read_study
from sooner.errors import DataFormatError
from sooner.io.writing import Folder
from tests.campaigns.filled import filled

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
    ((title, name, places, yes_no),) = drawn
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
