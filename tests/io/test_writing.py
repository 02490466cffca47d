import os

import pytest

from sooner.errors import DataFormatError
from sooner.io import Folder
from sooner.io.writing import LEDGER


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_files_are_written_whole_and_nothing_is_left_beside(tmp_path):
    Folder(tmp_path / "a" / "b").write({"x": b"1", "y": b"2"})
    assert names(tmp_path / "a" / "b") == [LEDGER, "x", "y"]


def test_what_sooner_wrote_is_replaced(tmp_path):
    for content in (b"1", b"2", b"3"):
        Folder(tmp_path).write({"x": content})
        assert (tmp_path / "x").read_bytes() == content


def test_what_somebody_else_wrote_is_left_alone(tmp_path):
    (tmp_path / "x").write_bytes(b"mine")
    with pytest.raises(DataFormatError, match="sooner did not write it"):
        Folder(tmp_path).write({"w": b"1", "x": b"1"})
    assert names(tmp_path) == ["x"]
    assert (tmp_path / "x").read_bytes() == b"mine"


def test_what_somebody_has_changed_is_left_alone(tmp_path):
    Folder(tmp_path).write({"x": b"1"})
    (tmp_path / "x").write_bytes(b"edited")
    with pytest.raises(DataFormatError, match="changed since sooner wrote it"):
        Folder(tmp_path).write({"x": b"2"})
    assert (tmp_path / "x").read_bytes() == b"edited"


def test_force_replaces(tmp_path):
    (tmp_path / "x").write_bytes(b"mine")
    Folder(tmp_path, force=True).write({"x": b"1"})
    assert (tmp_path / "x").read_bytes() == b"1"


def test_all_files_in_the_way_are_told_at_once(tmp_path):
    (tmp_path / "x").write_bytes(b"mine")
    (tmp_path / "y").mkdir()
    with pytest.raises(DataFormatError) as raised:
        Folder(tmp_path).check("x", "y", "z")
    assert len(raised.value.faults) == 2


def test_a_check_makes_nothing(tmp_path):
    Folder(tmp_path / "new").check("x")
    assert names(tmp_path) == []


def test_a_file_in_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(DataFormatError, match="not a folder"):
            Folder(path).write({"x": b"1"})


def test_when_one_file_cannot_be_written_none_is(tmp_path, monkeypatch):
    Folder(tmp_path).write({"x": b"old"})
    real = os.fsync
    calls = []

    def full(handle):
        calls.append(handle)
        if len(calls) == 2:
            raise OSError(28, "No space left on device")
        real(handle)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(DataFormatError, match="No space left"):
        Folder(tmp_path).write({"x": b"new", "y": b"new"})
    assert names(tmp_path) == [LEDGER, "x"]
    assert (tmp_path / "x").read_bytes() == b"old"


def test_what_a_killed_run_left_beside_is_swept(tmp_path):
    gone = 2**22 + 1  # no system has a process of this number
    (tmp_path / f".sooner-{gone}-plan.csv.tmp").write_bytes(b"half")
    Folder(tmp_path).write({"x": b"1"})
    assert names(tmp_path) == [LEDGER, "x"]


def test_a_ledger_of_garbage_is_as_none(tmp_path):
    (tmp_path / LEDGER).write_text('{"x": 3}')
    (tmp_path / "x").write_bytes(b"mine")
    with pytest.raises(DataFormatError, match="sooner did not write it"):
        Folder(tmp_path).check("x")
