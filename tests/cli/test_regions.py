"""A mission over regions as a stranger plans it."""

import json

import pytest

from sooner.planners.registry import PLANNERS


@pytest.fixture
def mission(sooner, tmp_path):
    assert sooner("scenario", "rough-ground", "--out", tmp_path).status == 0
    return tmp_path / "mission.toml"


def test_a_scenario_over_regions_is_planned_told_and_scored_the_same(sooner, mission):
    ended = sooner("plan", mission, "--planner", "depth-first", "--seconds", "3")
    assert ended.status == 0
    assert "learns" in ended.out
    assert "linear program over regions" in ended.out
    assert "of iterative greedy, no bound" in ended.out
    assert "ground teams then search" in ended.out
    assert " bits" in ended.err
    folder = mission.parent / "mission-plan"
    told = json.loads((folder / "plan.json").read_text())
    assert (folder / "plan.csv").read_text().startswith("searcher,action,kind,region,row,col,time_s\n0,0,start,")
    assert (folder / "plan.png").read_bytes().startswith(b"\x89PNG")
    assert told["unit"] == "bits"
    assert told["time_unit"] == "seconds"
    assert told["reference_name"] == "iterative greedy"
    (searcher,) = told["searchers"]
    assert searcher["duration_s"] == told["duration_s"] <= 1500.0
    assert searcher["cells"][0] == searcher["cells"][-1]
    assert 0 < told["ground_effort"]["after"] < told["ground_effort"]["before"]
    scored = sooner("evaluate", mission, folder / "plan.csv", "--json").json
    for key in ("value", "duration_s", "efficiency", "early_share", "ground_effort", "to_find"):
        assert scored[key] == told[key]
    assert "% of that after" in sooner("evaluate", mission, folder / "plan.csv").out


def test_a_plan_that_says_it_is_quicker_than_it_is_is_refused(sooner, mission):
    sooner("plan", mission, "--planner", "greedy", "--seconds", "1", "--quiet")
    plan = mission.parent / "mission-plan" / "plan.csv"
    lines = plan.read_text().splitlines()
    plan.write_text("\n".join([*lines[:-1], lines[-1].rpartition(",")[0] + ",900.0"]))
    ended = sooner("evaluate", mission, plan)
    assert ended.status == 2
    assert "return ends at 900.0 s; expected" in ended.err


def test_a_planner_over_cells_is_refused_and_those_over_regions_are_named(sooner, mission):
    ended = sooner("plan", mission, "--planner", "topn")
    assert ended.status == 2
    assert "topn cannot plan this: it plans moves over cells; for moves over regions there are: anneal" in ended.err


def test_planners_say_for_which_moves_they_are(sooner):
    told = sooner("planners", "--json").json
    assert {entry["name"]: tuple(entry["moves"]) for entry in told["planners"]} == {
        name: entry.moves for name, entry in PLANNERS.items()
    }
