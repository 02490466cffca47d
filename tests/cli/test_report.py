"""`sooner report`."""

import json

import pytest

from sooner.io.leg_plans import leg_plan_csv
from tests.georeferenced import hills, located, over_cells
from tests.missions.leg_missions import leg_mission, there_and_back
from tests.missions.pages import read_page

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
HOME = "[[searcher]]\nstart = [3, 3]\nend = [3, 3]\nspeed_mps = 12.0\naltitude_m = 80\n"
PLAN = "row,col\n3,3\n3,4\n3,5\n4,5\n4,4\n4,3\n3,3\n"


@pytest.fixture
def ridge(tmp_path):
    (tmp_path / "mine.csv").write_text(PLAN)
    return located(tmp_path, over_cells(HOME), hills())


def test_the_page_is_written_beside_the_plan(sooner, ridge):
    ended = sooner("report", ridge, ridge.parent / "mine.csv", "--seconds", "0.2")
    assert ended.status == 0
    assert "Ridge: 1 flight\n" in ended.out
    assert f"report   {ridge.parent / 'report.html'}" in ended.out
    page = read_page((ridge.parent / "report.html").read_bytes())
    assert page.count("section", "pilot") == 1
    assert sooner("report", ridge, ridge.parent / "mine.csv", "--seconds", "0.2").status == 0  # over its own


def test_json_has_the_numbers_of_plan(sooner, ridge):
    planned = sooner("plan", ridge, "--planner", "greedy", "--seconds", "0.2", "--json").json
    told = sooner("report", ridge, planned["plan_file"], "--seconds", "0.2", "--json").json
    shared = set(planned) & set(told) - {"bound", "gap", "bound_proof", "bound_assumes", "plan_file"}
    assert {"value", "cdp", "remaining", "time_to", "to_find"} <= shared
    assert {key: told[key] for key in shared} == {key: planned[key] for key in shared}
    assert told["bound"] >= told["value"]
    assert told["report"] == str(ridge.parent / "mission-plan" / "report.html")
    assert told["bytes"] == (ridge.parent / "mission-plan" / "report.html").stat().st_size


def test_a_plan_along_legs_stands_beside_patterns(sooner, tmp_path):
    score = there_and_back(leg_mission(tmp_path), [[200, 900], [800, 900]])
    (tmp_path / "plan.csv").write_bytes(leg_plan_csv(score.plan, score.mission.problem, score.mission.ground))
    file = tmp_path / "out" / "ridge.html"
    ended = sooner("report", tmp_path / "mission.toml", tmp_path / "plan.csv", "--seconds", "0.2", "--out", file)
    assert ended.status == 0
    assert "the best pattern, " in ended.out
    assert "note: " in ended.err
    assert "What planning buys" in read_page(file.read_bytes()).text


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--seconds", "0"], "--seconds: 0 came; expected a finite number above 0"),
        (["--out", ""], "--out: '.' came, which is a folder; expected the name of a file, as report.html"),
    ],
)
def test_what_cannot_be_is_refused(sooner, ridge, more, told):
    ended = sooner("report", ridge, ridge.parent / "mine.csv", *more)
    assert ended.status == 2
    assert told in ended.err
    assert not (ridge.parent / "report.html").exists()


def test_a_folder_is_no_file(sooner, ridge):
    ended = sooner("report", ridge, ridge.parent / "mine.csv", "--out", ridge.parent)
    assert ended.status == 2
    assert "which is a folder; expected the name of a file" in ended.err


def test_a_plan_that_the_mission_does_not_allow_is_refused(sooner, ridge):
    (ridge.parent / "jump.csv").write_text("3,3\n5,5\n3,3\n")
    ended = sooner("report", ridge, ridge.parent / "jump.csv")
    assert ended.status == 2
    assert "they are not neighbours" in ended.err
    assert not (ridge.parent / "report.html").exists()


def test_what_somebody_else_wrote_is_left_alone(sooner, ridge):
    (ridge.parent / "report.html").write_text("mine")
    ended = sooner("report", ridge, ridge.parent / "mine.csv", "--seconds", "0.2")
    assert ended.status == 2
    assert (ridge.parent / "report.html").read_text() == "mine"
    assert sooner("report", ridge, ridge.parent / "mine.csv", "--seconds", "0.2", "--force").status == 0


def test_a_map_without_a_place_on_the_globe_has_a_report_too(sooner, mission):
    (mission.parent / "mine.csv").write_text("2,2\n2,3\n")
    ended = sooner("report", mission, mission.parent / "mine.csv", "--seconds", "0.2", "--json")
    assert ended.status == 0
    assert any("no latitudes and longitudes" in note for note in ended.json["notes"])
    assert json.dumps(ended.json["places"][0]["lat"]) == "null"
