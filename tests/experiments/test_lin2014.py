"""A slice of the study of Lin & Goodrich 2014, and what its folder must hold."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from sooner.campaigns.study import Study, Table, read_study
from sooner.campaigns.trial import Case, Place, Trial
from sooner.errors import DataFormatError
from sooner.experiments import published as papers
from sooner.experiments import reproduce
from sooner.experiments.compare import UNEXPLAINED, compare
from sooner.experiments.lin2014.claims import author_gaussians, ratios_of_author
from sooner.experiments.lin2014.flight import fly
from sooner.experiments.lin2014.maps import posed
from sooner.experiments.published import Reproduced, read_published, read_reproduced, reproduced_csv, study_folder
from sooner.experiments.reproduce import _merged
from sooner.problem import Plan, evaluate

FOLDER = study_folder("lin2014")
STUDY = read_study(FOLDER)
NAMES = {
    "BA": "BA",
    "LHC_GW_CONV": "LHC-GW-CONV",
    "Top2_1layer": "Top2 (1 layer)",
    "TopN_1layer": "TopN (1 layer)",
    "Top2_H": "Top2 (Hierarchy)",
    "TopN_H": "TopN (Hierarchy)",
}


def case(instance: str, planner: str, steps: int, study: Study = STUDY) -> Case:
    (cell,) = study.cells(Table(name="one", instances=[instance], planners=[planner], budgets=[steps]))
    return cell.case


def efficiency(wisar, instance, planner, steps, seed=0) -> float:
    return fly(Trial(case(instance, planner, steps), seed), Place("", data=str(wisar)))["efficiency"]


# What is on paper ----------------------------------------------------------------------------------------------------


def test_every_published_number_stands_once_and_is_a_number():
    published = read_published(FOLDER)
    assert len(published) == len({number.key for number in published}) == 142
    assert all(np.isfinite(float(number.value)) and number.page for number in published)
    counts = {table: sum(number.table == table for number in published) for table in ("Table I", "Table I Speed")}
    assert counts == {"Table I": 19, "Table I Speed": 15}


@pytest.mark.parametrize(
    ("table", "name"), [("Table I", "hikerpaul"), ("Table II", "newyork53"), ("Table III", "newyork108")]
)
def test_published_numbers_are_those_that_came_with_the_maps(wisar, table, name):
    printed = {number.key: float(number.value) for number in read_published(FOLDER)}
    stored = json.loads((wisar / f"{name}.json").read_text(encoding="utf-8"))["paper_efficiency_lb_percent"]
    for planner, row in NAMES.items():
        for steps, value in stored[planner].items():
            assert printed[table, row, steps] == value


def test_published_numbers_of_the_synthetic_map_are_those_that_came_with_it(wisar):
    printed = {number.key: float(number.value) for number in read_published(FOLDER)}
    stored = json.loads((wisar / "synthetic60.json").read_text(encoding="utf-8"))["paper_efficiency_lb_percent"]
    for corner, key in (("upper left", "upper_left_T900"), ("lower right", "lower_right_T900")):
        for planner, value in stored[key].items():
            assert printed["Table IV", f"Start from {corner}", planner.replace("_", "-")] == value


# What the authors stored ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "with_difficulty", "cdp", "percent"),
    [("yesdiff", True, 0.046900, 77.00), ("nodiff", False, 0.12039, 96.67)],
)
def test_the_authors_stored_path_scores_as_it_did(wisar, real_problem, name, with_difficulty, cdp, percent):
    with (wisar / f"newyork53_T900_author_topnh_{name}_path.csv").open(newline="", encoding="utf-8") as file:
        cells = [int(row["row"]) * 100 + int(row["col"]) for row in csv.DictReader(file)]
    judged = evaluate(real_problem("newyork53", 900, with_difficulty), Plan.of(cells))
    assert judged.value == pytest.approx(cdp, abs=6e-7 if with_difficulty else 6e-6)
    assert 100 * judged.efficiency == pytest.approx(percent, abs=0.006)


def test_the_authors_gaussians_rank_as_his_ratios_do(wisar):
    ratios = ratios_of_author(wisar)
    assert ratios == pytest.approx([gaussian["mgr"] for gaussian in author_gaussians(wisar)], rel=1e-12)
    printed = {number.row: number.value for number in read_published(FOLDER) if number.table == "Fig. 12"}
    for rank, ratio in enumerate(sorted(ratios, reverse=True), 1):
        assert float(f"{ratio:.2f}") == float(printed[f"rank {rank}"])


# A slice of the study ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("instance", "steps", "printed"),
    [
        ("HikerPaul", 600, 56.76), ("HikerPaul", 900, 55.18), ("NewYork53", 300, 38.47), ("NewYork53", 600, 56.91),
        ("NewYork53", 900, 67.38), ("NewYork108", 300, 41.38), ("NewYork108", 900, 52.61), ("upper left", 900, 96.28),
        ("end at upper left", 900, 93.60),
    ],
)  # fmt: skip
def test_lhc_gw_conv_gives_every_printed_number_that_no_chance_decides(wisar, instance, steps, printed):
    assert efficiency(wisar, instance, "LHC-GW-CONV", steps) == pytest.approx(printed, abs=0.1)


def test_from_the_lower_right_chance_decides_between_staying_and_escaping(wisar):
    found = [efficiency(wisar, "lower right", "LHC-GW-CONV", 900, seed) for seed in range(8)]
    assert min(found) == pytest.approx(44.17, abs=0.01)
    assert all(value < 45 or value > 85 for value in found)


@pytest.mark.parametrize(
    ("instance", "printed"), [("HikerPaul", 81.43), ("NewYork53", 65.39), ("NewYork108", 59.60), ("upper left", 95.82)]
)
def test_topn_through_the_hierarchy_comes_near_the_printed_mean(wisar, instance, printed):
    assert efficiency(wisar, instance, "TopN (Hierarchy)", 900 if instance == "upper left" else 300) > printed - 5


def test_a_bound_beside_the_plan_is_no_more_than_teleport_and_no_less_than_the_plan(wisar):
    settings = {
        "instance": {"map": "synthetic60", "start": [0, 0]},
        "planner": {"make": "sooner.planners.anneal:Anneal", "cpu_seconds": 0.5, "proved": True},
    }
    found = fly(Trial(Case("small", "anneal", 60, json.dumps(settings)), 0), Place("", data=str(wisar)))
    assert found["efficiency"] <= found["bound"] <= 100


# From end to end -----------------------------------------------------------------------------------------------------

SMALL = """
title = "A small study"
trial = "sooner.experiments.lin2014.flight:fly"
measure = "efficiency"
data = "wisar"
data_files = ["synthetic60_*"]
trials = 2
[instances]
"upper left" = { map = "synthetic60", start = [0, 0] }
[planners]
BA = { make = "sooner.planners.bourgault:Bourgault" }
[[tables]]
name = "Table IV"
times = "Table IV Speed"
budgets = [900]
row = "Start from {instance}"
column = "{planner}"
[[rules]]
reason = "left out of this small study"
"""


def test_a_study_runs_from_its_folder_to_its_files_and_flies_nothing_twice(wisar, tmp_path, monkeypatch):
    folder = tmp_path / "papers" / "small"
    folder.mkdir(parents=True)
    (folder / "study.toml").write_text(SMALL, encoding="utf-8")
    (folder / "published.csv").write_bytes((FOLDER / "published.csv").read_bytes())
    monkeypatch.setattr(papers, "_studies", lambda: (tmp_path / "papers",))
    out, told = tmp_path / "out", []
    found = reproduce("small", wisar, 1, 1, out, watch=told.append)
    assert read_reproduced(out)[0].key == ("Table IV", "Start from upper left", "BA")
    assert {"reproduced.csv", "comparison.md", "trials.csv", "summary.md"} <= {path.name for path in found.files}
    assert (out / "comparison.md").read_text(encoding="utf-8").startswith("# A small study")
    verdicts = {comparison.published.key: comparison.verdict for comparison in found.comparisons}
    assert verdicts["Table IV", "Start from upper left", "BA"] == "same"
    assert verdicts["Table I", "BA", "300"] == "not measured"
    assert [told[0].done, told[-1].done] == [0, 2]
    again = []
    assert {row.key: row.value for row in reproduce("small", wisar, 1, 1, out, watch=again.append).rows} == {
        row.key: row.value for row in found.rows
    }
    assert {progress.done for progress in again} == {2}


def test_a_slice_of_the_study_comes_out_as_printed(wisar, tmp_path):
    found = reproduce("lin2014", wisar, 1, 2, tmp_path, only=["Fig. 18", "Study start*"])
    verdicts = {comparison.published.key: comparison.verdict for comparison in found.comparisons}
    assert verdicts["Fig. 18", "LHC-GW-CONV, end at upper left", "900"] == "same"
    ours = {row.key: row.value for row in found.rows}
    assert ours["Study start of the synthetic scenario", "lower right", "BA"] == pytest.approx(41.91, abs=0.02)
    assert found.progress.done == found.progress.total == 12
    assert found.aside == ()


def test_rows_of_tables_that_are_not_run_again_are_kept(tmp_path):
    old, new = (
        Reproduced(table, "r", "c", value, value, value, 1, "", "") for table, value in (("A", 1.0), ("B", 2.0))
    )
    (tmp_path / "reproduced.csv").write_text(reproduced_csv([old, new]), encoding="utf-8")
    later = replace(new, value=3.0)
    assert _merged(tmp_path, [later]) == [old, later]
    assert _merged(tmp_path / "elsewhere", [later]) == [later]


def test_a_map_that_cannot_be_read_is_refused_by_name(tmp_path):
    (tmp_path / "bad_dist.csv").write_text("1,2\n3,x\n", encoding="utf-8")
    with pytest.raises(DataFormatError, match=r"bad_dist\.csv"):
        posed(tmp_path, "bad", (0, 0), 5)


# What is committed ---------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not (FOLDER / "reproduced.csv").is_file(), reason="the study has not been run yet")
def test_every_committed_number_that_differs_has_its_reason():
    found = compare(read_published(FOLDER), read_reproduced(FOLDER), STUDY.rules)
    assert [comparison.published.key for comparison in found if comparison.reason == UNEXPLAINED] == []
    page = (FOLDER / "comparison.md").read_text(encoding="utf-8")
    assert UNEXPLAINED not in page
