"""One line for each trial: nothing lost, nothing retyped, no half file."""

import csv
import math
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sooner.campaigns import tidy
from sooner.campaigns.tidy import Tidy, flat, write_tidy
from sooner.errors import DataFormatError, InvalidProblemError

ROWS = [
    {"instance": "hills", "seed": 1, "steps": 7, "pos": 0.1, "found": True},
    {"instance": "hills", "seed": 2, "steps": None, "pos": 1, "found": None},
    {"instance": 'a "plain",\nwide', "seed": 3, "note": "late", "nothing": None},
]


def read(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def parquet():
    return pytest.importorskip("pyarrow.parquet")


@pytest.fixture
def few_at_once(monkeypatch):
    monkeypatch.setattr(tidy, "ROWS_AT_ONCE", 2)


def test_a_nested_answer_becomes_flat_and_its_lists_are_left_out():
    nested = {"a": 1, "b": {"c": {"d": None}, "e": [1, {"f": 2}]}, "g": (1,), "h": "text"}
    assert flat(nested) == {"a": 1, "b.c.d": None, "h": "text"}


@pytest.mark.usefixtures("few_at_once")
def test_a_column_that_only_a_late_row_has_is_not_lost(tmp_path):
    done = write_tidy(iter(ROWS), ["seed", "instance", "planner"], tmp_path / "new" / "trials.csv")
    assert done == Tidy(3, ("seed", "instance", "planner", "steps", "pos", "found", "note", "nothing"))
    first, second, third = read(tmp_path / "new" / "trials.csv")
    assert first == dict(zip(done.columns, ["1", "hills", "", "7", "0.1", "true", "", ""], strict=True))
    assert (second["steps"], second["pos"], second["found"]) == ("", "1.0", "")
    assert (third["instance"], third["note"]) == ('a "plain",\nwide', "late")


@pytest.mark.usefixtures("few_at_once")
def test_parquet_keeps_the_types_whole_numbers_with_nulls_among_them(tmp_path, parquet):
    write_tidy(ROWS, ["seed"], tmp_path / "trials.csv", tmp_path / "trials.parquet")
    file = parquet.ParquetFile(tmp_path / "trials.parquet")
    types = {field.name: str(field.type) for field in file.schema_arrow}
    assert types == {
        "seed": "int64",
        "instance": "string",
        "steps": "int64",
        "pos": "double",
        "found": "bool",
        "note": "string",
        "nothing": "double",
    }
    assert file.num_row_groups == 2
    whole = file.read().to_pylist()
    assert [row["steps"] for row in whole] == [7, None, None]
    assert whole[0] == {**dict.fromkeys(types), **ROWS[0]}
    file.close()


@pytest.mark.parametrize(
    ("values", "kind", "held"),
    [
        ([True, 2], "int64", [1, 2]),
        ([True, 0.5], "double", [1.0, 0.5]),
        ([1, "x"], "string", ["1", "x"]),
        ([2**63, 1], "string", [str(2**63), "1"]),
        ([2**60 + 1, None], "int64", [2**60 + 1, None]),
        ([2**60 + 1, 0.5], "double", [float(2**60), 0.5]),
        (["", None], "string", ["", None]),
    ],
)
def test_a_column_has_the_narrowest_type_that_holds_its_values(tmp_path, parquet, values, kind, held):
    write_tidy([{"v": value} for value in values], [], tmp_path / "t.csv", tmp_path / "t.parquet")
    column = parquet.read_table(tmp_path / "t.parquet").column("v")
    assert (str(column.type), column.to_pylist()) == (kind, held)


VALUES = st.one_of(
    st.none(), st.integers(-(2**70), 2**70), st.floats(allow_nan=False), st.booleans(), st.text("ab|,\n")
)


@given(st.lists(st.dictionaries(st.sampled_from("abc"), VALUES), max_size=9))
def test_any_rows_come_back_line_by_line(tmp_path_factory, rows):
    place = tmp_path_factory.mktemp("any") / "t.csv"
    done = write_tidy(rows, ["a"], place)
    assert done.rows == len(rows)
    assert set(done.columns) == {"a"}.union(*rows)
    back = read(place) if len(done.columns) > 1 else []  # a line of one empty column is no line to a reader
    for line, row in zip(back, rows, strict=False):
        for name, value in row.items():
            if isinstance(value, float):
                assert line[name] == str(value) or math.isclose(float(line[name]), value)
            elif value is None:
                assert line[name] == ""


def test_without_pyarrow_the_csv_is_written_and_a_note_says_why_parquet_is_not(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    done = write_tidy(ROWS, ["seed"], tmp_path / "t.csv", tmp_path / "t.parquet")
    assert "pip install 'sooner[parquet]'" in done.note
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


@pytest.mark.usefixtures("few_at_once")
def test_rows_that_break_off_leave_the_old_files_as_they_were(tmp_path):
    write_tidy(ROWS, ["seed"], tmp_path / "t.csv")
    before = (tmp_path / "t.csv").read_bytes()

    def broken():
        yield from ROWS
        raise RuntimeError("the ledger ended early")

    with pytest.raises(RuntimeError, match="the ledger ended early"):
        write_tidy(broken(), ["seed"], tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


def test_a_parquet_that_cannot_be_written_leaves_no_csv_either(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tidy, "_write_parquet", full)
    monkeypatch.setattr(tidy, "_has_pyarrow", lambda: True)
    with pytest.raises(DataFormatError, match="No space left on device"):
        write_tidy(ROWS, ["seed"], tmp_path / "t.csv", tmp_path / "t.parquet")
    assert list(tmp_path.iterdir()) == []


def test_a_file_where_a_folder_should_be_is_told(tmp_path):
    (tmp_path / "here").write_text("in the way")
    with pytest.raises(DataFormatError, match="writing failed"):
        write_tidy(ROWS, ["seed"], tmp_path / "here" / "t.csv")


def test_a_column_asked_for_twice_is_refused(tmp_path):
    with pytest.raises(InvalidProblemError, match="expected each once"):
        write_tidy(ROWS, ["seed", "seed"], tmp_path / "t.csv")


def test_no_rows_make_a_file_of_its_header(tmp_path, parquet):
    assert write_tidy([], ["seed", "pos"], tmp_path / "t.csv", tmp_path / "t.parquet").rows == 0
    assert (tmp_path / "t.csv").read_text() == "seed,pos\n"
    assert parquet.read_table(tmp_path / "t.parquet").column_names == ["seed", "pos"]


def test_a_column_of_a_given_kind_has_its_type_whatever_it_holds_and_its_values_as_they_came_in_csv(tmp_path, parquet):
    kinds = {"budget": "number", "reason": "text", "alone": "yes_no", "seed": "whole"}
    done = write_tidy([{"budget": 40, "alone": True}], kinds, tmp_path / "t.csv", tmp_path / "t.parquet")
    assert done.columns == tuple(kinds)
    table = parquet.read_table(tmp_path / "t.parquet")
    assert [str(field.type) for field in table.schema] == ["double", "string", "bool", "int64"]
    assert table.to_pylist() == [{"budget": 40.0, "reason": None, "alone": True, "seed": None}]
    assert (tmp_path / "t.csv").read_text() == "budget,reason,alone,seed\n40,,true,\n"
