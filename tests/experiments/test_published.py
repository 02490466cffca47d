"""What papers printed and what we measured, on disk: found, read, refused with the reason."""

import pytest

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.experiments import reproduce
from sooner.experiments.published import Reproduced, read_published, read_reproduced, reproduced_csv, study_folder

ROW = Reproduced("Table I", "BA", "300", 56.953, 56.0, 57.0, 10, "abc", "a processor, 2 cores")


def test_an_unknown_paper_is_refused_with_the_known_ones():
    with pytest.raises(DataFormatError, match=r"lin2015.*expected one of .*lin2014"):
        study_folder("lin2015")


def test_reproduce_without_its_maps_says_so_before_it_runs_anything(tmp_path):
    with pytest.raises(DataFormatError, match="is not there"):
        reproduce("lin2014", tmp_path, 1, 1, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("trials", "workers"), [(0, 1), (1, 0), (-3, 1)])
def test_no_trials_and_no_workers_are_refused(tmp_path, trials, workers):
    with pytest.raises(InvalidProblemError, match="at least one of each"):
        reproduce("lin2014", tmp_path, trials, workers)


def test_what_is_written_is_read_back(tmp_path):
    (tmp_path / "reproduced.csv").write_text(reproduced_csv([ROW]), encoding="utf-8")
    assert read_reproduced(tmp_path) == (ROW,)


def test_a_table_of_another_shape_is_refused_line_by_line(tmp_path):
    (tmp_path / "published.csv").write_text("table,row,column,value\nTable I,BA,300,56.95\n", encoding="utf-8")
    with pytest.raises(DataFormatError) as caught:
        read_published(tmp_path)
    assert len(caught.value.faults) == 2
