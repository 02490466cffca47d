"""What made a result: digests change with what decides it, and with nothing else."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from sooner.campaigns import Place
from sooner.campaigns import provenance as module
from sooner.campaigns.provenance import provenance, same_source, sources
from sooner.errors import DataFormatError


def place(folder: Path) -> Place:
    return Place("work:fly", str(folder), str(folder / "maps"), ("*.csv",))


def laid_out(folder: Path) -> Path:
    (folder / "maps").mkdir(parents=True)
    (folder / "work.py").write_text("A = 1\n")
    (folder / "maps" / "hills.csv").write_text("1,2\n")
    return folder


def test_the_source_of_a_study_is_the_same_wherever_it_lies(tmp_path):
    here, there = provenance(place(laid_out(tmp_path / "a"))), provenance(place(laid_out(tmp_path / "b")))
    assert same_source(here, there)
    assert here == there


def test_a_module_beside_the_study_or_a_map_that_changes_makes_another_source(tmp_path):
    folder = laid_out(tmp_path / "a")
    before = provenance(place(folder))
    (folder / "notes.txt").write_text("of no matter")
    (folder / "maps" / "other.png").write_text("of no matter")
    assert same_source(before, provenance(place(folder)))
    (folder / "maps" / "hills.csv").write_text("1,3\n")
    changed = provenance(place(folder))
    assert (changed["source"] == before["source"], changed["data"] == before["data"]) == (True, False)
    (folder / "work.py").rename(folder / "other.py")
    changed = provenance(place(folder))
    assert changed["source"] != before["source"]
    assert not same_source(before, changed)


def test_modules_in_folders_below_the_study_count_but_not_what_lies_aside(tmp_path):
    folder = laid_out(tmp_path / "a")
    (folder / "deep" / "deeper").mkdir(parents=True)
    before = provenance(place(folder))
    for aside in (".git", "__pycache__", "mine-results", "env"):
        (folder / aside).mkdir()
        (folder / aside / "x.py").write_text("A = 1")
    (folder / "env" / "pyvenv.cfg").touch()
    assert same_source(before, provenance(place(folder)))
    (folder / "deep" / "deeper" / "x.py").write_text("A = 1")
    assert not same_source(before, provenance(place(folder)))


def test_folders_that_lead_back_to_themselves_are_read_once(tmp_path):
    folder = laid_out(tmp_path / "a")
    (folder / "deep").mkdir()
    (folder / "deep" / "x.py").write_text("A = 1")
    before = provenance(place(folder))
    (folder / "deep" / "up").symlink_to(folder)
    assert same_source(before, provenance(place(folder)))


def test_modules_elsewhere_that_fly_or_are_made_count_whole_and_are_not_loaded(tmp_path, monkeypatch):
    folder = laid_out(tmp_path / "a")
    package = tmp_path / "elsewhere" / "walks"
    package.mkdir(parents=True)
    for file in (package / "__init__.py", package / "deep.py", package.parent / "alone.py"):
        file.write_text("raise SystemExit\n")
    monkeypatch.syspath_prepend(package.parent)
    known = replace(place(folder), modules=("walks.deep", "alone", "sooner.planners.greedy", "no.such"))
    assert {"walks/__init__.py", "walks/deep.py", "alone.py", "work.py"} <= sources(known).keys()
    before = provenance(known)
    assert not same_source(before, provenance(place(folder)))
    (package / "deep.py").write_text("raise SystemExit  # changed\n")
    assert not same_source(before, provenance(known))


def test_a_study_among_too_many_files_is_refused(tmp_path, monkeypatch):
    folder = laid_out(tmp_path / "a")
    monkeypatch.setattr(module, "MOST_FILES", 3)
    with pytest.raises(DataFormatError, match=r"Python files; at most 3 are read; expected the study in a folder of"):
        provenance(place(folder))
    monkeypatch.setattr(module, "MOST_FILES", 5000)
    monkeypatch.setattr(module, "MOST_BYTES", 100)
    with pytest.raises(DataFormatError, match="its Python files hold more than 0 MB"):
        provenance(place(folder))
    monkeypatch.setattr(module, "MOST_ENTRIES", 1)
    with pytest.raises(DataFormatError, match="more than 1 files lie below it"):
        provenance(place(folder))


def test_a_study_without_maps_or_modules_has_a_source(tmp_path):
    told = provenance(Place("work:fly"))
    assert len(told["source"]) == len(told["data"]) == 16
    assert {"numpy", "llvmlite"} <= told["packages"].keys()
    assert told["processor"].endswith("cores")


def test_a_package_inside_somebody_elses_repository_has_no_commit(tmp_path, monkeypatch):
    package = tmp_path / "site-packages" / "sooner"
    package.mkdir(parents=True)
    monkeypatch.setattr(module, "PACKAGE", package)
    assert module.commit.__wrapped__() == ""


def test_a_machine_without_git_has_no_commit(monkeypatch):
    monkeypatch.setenv("PATH", "")
    assert shutil.which("git") is None
    assert module.commit.__wrapped__() == ""
