"""A slice of the study of Wolek et al. 2020, and what its folder must hold."""

import json
from math import isfinite
from pathlib import Path

import numpy as np
import pytest

from sooner.campaigns.results import collect
from sooner.campaigns.study import read_study
from sooner.campaigns.trial import Case, Place, Trial
from sooner.errors import DataFormatError
from sooner.experiments import reproduce
from sooner.experiments.compare import UNEXPLAINED, compare
from sooner.experiments.published import read_published, read_reproduced, study_folder
from sooner.experiments.wolek2020.claims import AUTHORS, by_seed, mean_and_error
from sooner.experiments.wolek2020.flight import SAMPLES, fly
from sooner.experiments.wolek2020.flight_test import flight_test, track_at
from sooner.experiments.wolek2020.scenes import scene, three_blocks
from sooner.simulation import Estimator

FOLDER = study_folder("wolek2020")
STUDY = read_study(FOLDER)
FLIGHT_TEST = {"map": "flight test"}


def flown(instance, planner, seed=0, seconds=None, data=""):
    settings = json.dumps({"instance": instance, "planner": planner})
    return fly(Trial(Case("i", "p", seconds, settings), seed), Place("", data=str(data)))


def without_times(answer):
    return {key: value for key, value in answer.items() if key != "timing"}


# What is on paper ----------------------------------------------------------------------------------------------------


def test_every_published_number_stands_once_and_is_a_number():
    published = read_published(FOLDER)
    assert len(published) == len({number.key for number in published})
    assert all(isfinite(float(number.value)) and number.page for number in published)


def test_table_2_is_as_printed():
    printed = [number.value for number in read_published(FOLDER) if number.key[::2] == ("Table II", "E")]
    assert printed == ["0.309", "0.366", "0.487", "0.535", "0.565", "0.585", "0.827"]


# A trial -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("planner", [{"strategy": "random", "detector": "cbht"}, {"strategy": "information"}])
def test_a_trial_is_a_function_of_its_seed(planner):
    once, again, other = (flown(FLIGHT_TEST, planner, seed, 40) for seed in (3, 3, 4))
    assert without_times(once) == without_times(again) != without_times(other)


def test_a_trial_answers_the_halves_of_e_and_a_curve_that_rises():
    answer = flown(FLIGHT_TEST, {"strategy": "information", "prior": "kriged"})
    assert answer["e"] == pytest.approx(answer["e_nodes"] + answer["e_targets"])
    assert len(answer["nodes"]) == SAMPLES + 1
    assert (np.diff(answer["nodes"]) >= 0.0).all()
    assert answer["nodes"][-1] == pytest.approx(answer["nodes_end"], abs=1e-5)


def test_a_search_in_vain_has_no_e_and_finds_no_target():
    answer = flown(FLIGHT_TEST | {"targets": 0}, {"strategy": "random"}, seconds=60)
    assert answer["e"] is answer["e_targets"] is answer["found"] is answer["found_s"] is None
    assert answer["called_falsely"] == (answer["false_calls"] > 0)


def test_a_setting_of_an_instance_that_nobody_knows_is_refused():
    with pytest.raises(DataFormatError, match="half_sell"):
        scene(Path(), FLIGHT_TEST | {"half_sell": True}, Estimator())


# The flight test -----------------------------------------------------------------------------------------------------


def test_the_flight_test_is_flown_as_the_paper_says():
    where = scene(Path(), FLIGHT_TEST, Estimator())
    assert (where.seconds, where.replan_s, len(where.agents)) == (300, 20, 4)
    graph = three_blocks()
    assert graph.n_edges - graph.n_nodes + len(np.unique(graph.components)) == 3  # blocks


def test_a_track_made_again_from_looks_is_the_one_that_was_flown():
    episode, replans = flight_test(0)
    assert [each.second for each in replans] == list(range(0, 300, 20))
    for second in (75, 299):
        assert track_at(episode, second).integrated_ratio == pytest.approx(episode.sums[second])


# What is counted -----------------------------------------------------------------------------------------------------


def test_differences_are_taken_seed_by_seed_and_map_by_map():
    found = {
        (place, planner, None): collect(place, planner, None, [(s, {"e": base + s + at}) for s in range(4)])
        for at, place in enumerate(AUTHORS)
        for planner, base in (("a", 0.5), ("b", 0.0))
    }
    assert mean_and_error(by_seed(found, AUTHORS, "a", "e", versus="b")) == pytest.approx((0.5, 0.0))
    assert by_seed(found, AUTHORS, "b", "e") == {0: 1.0, 1: 2.0, 2: 3.0, 3: 4.0}
    assert mean_and_error({0: 1.0, 1: 3.0}) == (2.0, pytest.approx(1.0))


# On the authors' maps ------------------------------------------------------------------------------------------------


def test_a_trial_on_the_authors_maps_is_settled_by_its_seed_for_every_strategy(occupancy_graphs):
    said = STUDY.file.instances["New York"]
    for name in ("random", "lawnmower"):
        once, again = (flown(said, {"strategy": name}, 1, 60, occupancy_graphs) for _ in range(2))
        assert without_times(once) == without_times(again)


@pytest.mark.slow
def test_a_slice_of_the_study_runs_and_does_not_depend_on_workers(occupancy_graphs, tmp_path):
    tables = ["Table II", "Flight test"]
    one, two = (
        reproduce("wolek2020", occupancy_graphs.parent, 1, workers, tmp_path / str(workers), tables, figures=False)
        for workers in (1, 2)
    )
    assert one.progress.done == one.progress.total == 22
    assert {row.key: row.value for row in one.rows} == {row.key: row.value for row in two.rows}
    verdicts = {each.published.key: each.verdict for each in one.comparisons}
    assert {verdict for (table, _, _), verdict in verdicts.items() if table == "Table I"} == {"same"}
    assert verdicts["Table II", "Case 7: information, known map", "E_nodes"] == "same"
    assert one.aside == ()


# What is committed ---------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not (FOLDER / "reproduced.csv").is_file(), reason="the study has not been run yet")
def test_every_committed_number_that_differs_has_its_reason():
    found = compare(read_published(FOLDER), read_reproduced(FOLDER), STUDY.rules)
    assert [comparison.published.key for comparison in found if comparison.reason == UNEXPLAINED] == []
    assert UNEXPLAINED not in (FOLDER / "comparison.md").read_text(encoding="utf-8")
