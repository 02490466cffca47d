"""A slice of the study of Kuhlman et al. 2017, and what its folder must hold."""

import csv
import io
import json

import numpy as np
import pytest

from sooner.belief.effort import effort_by_looks
from sooner.campaigns.results import Results
from sooner.campaigns.study import Table, read_study
from sooner.campaigns.trial import Case, Place, Trial
from sooner.experiments import reproduce
from sooner.experiments.compare import compare
from sooner.experiments.kuhlman2017.claims import _blur, _table_1, tenfold
from sooner.experiments.kuhlman2017.flight import fly
from sooner.experiments.kuhlman2017.ground import STARTS, ground, posed
from sooner.experiments.published import read_published, read_reproduced, study_folder
from sooner.planners.depth_first import relaxation
from sooner.problem.region_ground import RegionGround
from sooner.scenarios.natural import EXPERIMENT_2_CELLS

FOLDER = study_folder("kuhlman2017")
STUDY = read_study(FOLDER)


def trial(instance: str, planner: str, seed: int = 0) -> Trial:
    (cell,) = STUDY.cells(Table(name="one", instances=[instance], planners=[planner]))
    return Trial(cell.case, seed)


def flown(instance: str, planner: str, seed: int = 0):
    return fly(trial(instance, planner, seed), Place(""))


# What is on paper ----------------------------------------------------------------------------------------------------


def test_every_published_number_stands_once_and_is_a_number():
    published = read_published(FOLDER)
    assert len(published) == len({number.key for number in published}) == 345
    assert all(np.isfinite(float(number.value)) and number.page for number in published)
    counts = {table: sum(number.table.startswith(table) for number in published) for table in ("Table 2", "Table 3")}
    assert counts == {"Table 2": 4 * 37, "Table 3": 4 * 37}


def test_every_published_number_is_measured_or_says_why_not():
    reproduced = {row.key for row in read_reproduced(FOLDER)}
    missing = [c for c in compare(read_published(FOLDER), read_reproduced(FOLDER), STUDY.rules) if c.ours is None]
    assert reproduced
    assert not missing, missing[:3]


def test_every_difference_has_its_reason():
    found = compare(read_published(FOLDER), read_reproduced(FOLDER), STUDY.rules)
    assert not [c.published.key for c in found if c.reason == "not explained yet"]


def test_table_1_is_the_printed_one():
    printed = {number.key: number.value for number in read_published(FOLDER) if number.table == "Table 1"}
    for table, row, column, bits, _ in _table_1():
        value = printed.pop((table, row, column))
        assert bits == pytest.approx(float(value), abs=0.0007 if value == "0.347" else 0.0005)
    assert not printed


def test_the_first_example_of_motion_blur_is_the_printed_one_and_the_second_is_that_of_other_numbers():
    blur = {row: pixels for _, row, _, pixels, _ in _blur()}
    assert blur["motion blur at 10 m/s, 10 m, 2 ms"] == pytest.approx(1.8)
    assert blur["motion blur at 20 m/s, 5 m, 2 ms"] == pytest.approx(5.4)
    assert blur["motion blur at 5 m/s, 20 m, 2 ms"] == pytest.approx(0.9)


# A trial -------------------------------------------------------------------------------------------------------------


def test_seeds_are_places():
    first, last = posed({"kind": "low"}, 4), posed({"kind": "low"}, 7)
    assert first.ground is last.ground is ground("low", 2)
    places = [each.searcher.start for each in first.ground.problems]
    assert len(set(places)) == STARTS
    centres = {first.ground.environment.grid.cell(int(cell)) for cell in first.ground.regions.centres}
    assert set(places) <= centres
    assert first.problem.searcher.start == places[0]
    assert last.problem.searcher.start == places[3]
    assert all(each.searcher.budget == first.ground.budget_s for each in first.ground.problems)


def test_a_prior_changes_what_looks_pay_and_nothing_of_the_ground():
    even, uneven = ground("low", 1), ground("low", 1, nonuniform=True)
    assert np.array_equal(even.regions.labels, uneven.regions.labels)
    assert even.budget_s == uneven.budget_s
    assert [each.searcher.start for each in even.problems] == [each.searcher.start for each in uneven.problems]
    assert uneven.problems[0].gains.first.sum() < even.problems[0].gains.first.sum()


def test_wide_footprints_see_more_and_fly_no_longer():
    narrow, wide = flown("4,608 cells", "DFS, 10 environments"), flown("wide 4,608 cells", "DFS, 10 environments")
    assert wide["swept_m2_per_m"] > narrow["swept_m2_per_m"]
    assert wide["t_max"] == narrow["t_max"]


@pytest.mark.parametrize("planner", ["eps-B&B", "greedy", "DFS", "DF-B&B"])
def test_a_trial_is_a_pure_function_of_its_seed(planner):
    one, other = (dict(flown("low nonuniform", planner, 1)) for _ in range(2))
    del one["timing"], other["timing"]
    assert one == other
    json.dumps(one, allow_nan=False)


@pytest.mark.parametrize("planner", ["eps-B&B", "DF-B&B"])
def test_what_a_search_over_walks_says_of_its_best_walk_is_what_the_judge_says(planner):
    found = flown("low uniform", planner, 2)
    search = posed({"kind": "low"}, 2)
    reference, _ = relaxation(RegionGround.of(search.problem))
    looks, free = search.looks(np.array(found["actions"])), search.free
    curve = effort_by_looks([0.5], int(looks.max()), 0.85, 0.15, variant="printed")[0]
    assert found["info"] == pytest.approx(100 * found["bits"] / reference)
    assert found["first_info"] <= found["info"] <= 100.5
    assert found["effort"] == pytest.approx(curve[looks[free]].mean())
    assert found["effort"] < found["effort_corrected"]
    assert found["success"]
    assert found["success_percent"] == 100


def test_a_search_that_found_no_walk_says_so_and_gives_no_numbers():
    said = trial("vhf uniform", "eps-B&B, late")
    few = json.dumps({**json.loads(said.case.settings), "planner": {**said.planner, "iterations": 20}})
    answer = fly(Trial(Case("vhf uniform", "few", None, few), 0), Place(""))
    assert answer["success"] is False
    assert answer["success_percent"] == 0
    assert answer["info"] is answer["first_info"] is answer["effort"] is answer["solutions"] is None
    assert answer["expanded"] > 0


def test_a_search_that_found_no_walk_proves_nothing():
    said = trial("4,608 cells", "eps-B&B, 10 environments")
    few = json.dumps({**json.loads(said.case.settings), "planner": {**said.planner, "iterations": 2}})
    answer = fly(Trial(Case("4,608 cells", "few", None, few), 0), Place(""))
    assert answer["proved"] is None
    assert answer["bound"] > 99


def test_what_ten_times_the_cells_do_is_a_slope_of_each_environment():
    seeds = np.array([0, 1, 2, 4, 5])  # three starts of one environment, two of the next
    rises = np.array([1.0, 2.0, 3.0, -0.5, 9.0])
    found = [
        Results("", "", None, seeds, {"info": 90 + rises * np.log10(cells)}, frozenset())
        for cells in EXPERIMENT_2_CELLS
    ]
    found[3] = Results("", "", None, seeds[:4], {"info": found[3].measure("info")[:4]}, frozenset())
    assert tenfold(found, "info") == pytest.approx([2.0, -0.5])
    gone = np.where(seeds[:4] == 2, np.nan, found[3].measure("info"))
    found[3] = Results("", "", None, seeds[:4], {"info": gone}, frozenset())
    assert tenfold(found, "info") == pytest.approx([1.5, -0.5])


# A slice of the study ------------------------------------------------------------------------------------------------


def test_two_tables_are_flown_without_any_data(tmp_path, monkeypatch):
    monkeypatch.delenv("SOONER_DATA", raising=False)
    monkeypatch.setattr("sooner.experiments.kuhlman2017.claims.COUNTED", 2)
    found = reproduce("kuhlman2017", trials=2, workers=1, out_dir=tmp_path / "out", only=["Table 2*"], figures=False)
    assert not found.aside
    rows = {row.key: row for row in found.rows}
    info = {name: rows["Table 2", "low uniform", f"{name} info"].value for name in ("eps-B&B final", "DFS", "greedy")}
    assert info["eps-B&B final"] > info["greedy"]
    assert rows["Table 2", "low uniform", "DFS info, standard deviation"].n == 2
    assert ("Table 3", "low nonuniform", "DFS info") not in rows
    told = (tmp_path / "out" / "comparison.md").read_text(encoding="utf-8")
    assert "## Table 2" in told
    assert list(csv.reader(io.StringIO((tmp_path / "out" / "reproduced.csv").read_text(encoding="utf-8"))))
