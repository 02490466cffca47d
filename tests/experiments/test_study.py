"""Studies on disk: found, read, refused with the reason, written whole."""

import pytest

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.experiments import reproduce
from sooner.experiments.study import (
    Reproduced,
    find_data,
    read_published,
    read_reproduced,
    read_study,
    study_folder,
    writable_folder,
    write_atomically,
    write_reproduced,
)

ROW = Reproduced("Table I", "BA", "300", 56.953, 56.0, 57.0, 10, "abc", "a processor, 2 cores")


def test_an_unknown_paper_is_refused_with_the_known_ones():
    with pytest.raises(DataFormatError, match=r"lin2015.*expected one of .*lin2014"):
        study_folder("lin2015")


def test_data_that_are_not_given_or_not_there_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.delenv("SOONER_DATA", raising=False)
    with pytest.raises(DataFormatError, match="give --data DIR or set SOONER_DATA"):
        find_data(None, "wisar", "hikerpaul_dist.csv")
    with pytest.raises(DataFormatError, match=r"wisar/hikerpaul_dist\.csv is not there"):
        find_data(tmp_path, "wisar", "hikerpaul_dist.csv")


@pytest.mark.parametrize("inside", [".", "wisar"])
def test_data_are_found_in_the_folder_or_in_the_one_above_it(tmp_path, inside):
    (tmp_path / inside).mkdir(exist_ok=True)
    (tmp_path / inside / "hikerpaul_dist.csv").touch()
    assert find_data(tmp_path, "wisar", "hikerpaul_dist.csv") == tmp_path / inside


def test_reproduce_without_its_maps_says_so_before_it_runs_anything(tmp_path):
    with pytest.raises(DataFormatError, match="is not there"):
        reproduce("lin2014", tmp_path, 1, 1, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("trials", "workers"), [(0, 1), (1, 0), (-3, 1)])
def test_no_trials_and_no_workers_are_refused(tmp_path, trials, workers):
    with pytest.raises(InvalidProblemError, match="at least one of each"):
        reproduce("lin2014", tmp_path, trials, workers)


def test_what_is_written_is_read_back(tmp_path):
    write_reproduced(tmp_path / "reproduced.csv", [ROW])
    assert read_reproduced(tmp_path) == (ROW,)


def test_a_table_of_another_shape_is_refused_line_by_line(tmp_path):
    (tmp_path / "published.csv").write_text("table,row,column,value\nTable I,BA,300,56.95\n", encoding="utf-8")
    with pytest.raises(DataFormatError) as caught:
        read_published(tmp_path)
    assert len(caught.value.faults) == 2


def test_a_study_that_is_no_toml_is_refused_by_name(tmp_path):
    (tmp_path / "study.toml").write_text("trials = = 3", encoding="utf-8")
    with pytest.raises(DataFormatError, match=r"study\.toml"):
        read_study(tmp_path)


def test_a_file_that_cannot_be_written_whole_is_not_written_at_all(tmp_path):
    path = tmp_path / "reproduced.csv"
    write_atomically(path, "before")
    with pytest.raises(TypeError):
        write_atomically(path, 3)  # type: ignore[arg-type]
    assert path.read_text(encoding="utf-8") == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["reproduced.csv"]


def test_a_folder_that_cannot_be_written_to_is_refused_before_the_run(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(DataFormatError, match="expected a folder that can be written to"):
        writable_folder(tmp_path / "file" / "out")
