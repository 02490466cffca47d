"""What made a result: digests change with what decides it, and with nothing else."""

import shutil
from pathlib import Path

from sooner.campaigns import Place
from sooner.campaigns import provenance as module
from sooner.campaigns.provenance import provenance, same_source


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
