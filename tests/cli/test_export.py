"""`sooner export`, and `sooner plan --format`."""

import json
import re
from pathlib import Path

import pytest
import rasterio

from sooner.io.leg_plans import leg_plan_csv
from sooner.missions.exported import EXPORTS
from tests.georeferenced import hills, located, over_cells
from tests.missions.leg_missions import VEHICLE, leg_mission, there_and_back

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
HOME = "[[searcher]]\nstart = [3, 3]\nend = [3, 3]\nspeed_mps = 12.0\naltitude_m = 80\n"
PLAN = "row,col\n3,3\n3,4\n3,5\n4,5\n4,4\n4,3\n3,3\n"
ALL = ",".join(EXPORTS)


@pytest.fixture
def ridge(tmp_path):
    (tmp_path / "mine.csv").write_text(PLAN)
    return located(tmp_path, over_cells(HOME), hills())


def test_every_format_is_written_beside_the_plan(sooner, ridge):
    ended = sooner("export", ridge, ridge.parent / "mine.csv", "--format", ALL)
    assert ended.status == 0
    assert "Ridge: 5 waypoints, 144 m, 0:12, 80 m above home" in ended.out
    files = ["plan", "waypoints", "kmz", "kml", "gpx", "geojson", "cot"]
    for name in [*(f"flight.{suffix}" for suffix in files), "poc-before.tif", "poc-after.tif", "pod.tif"]:
        assert (ridge.parent / name).stat().st_size > 0
        assert str(ridge.parent / name) in ended.out


def test_json_tells_files_flights_and_notes(sooner, ridge):
    out = ridge.parent / "out"
    told = sooner(
        "export", ridge, ridge.parent / "mine.csv", "--format", "gpx", "--format", "kml", "--out", out, "--json"
    )
    assert [each["format"] for each in told.json["files"]] == ["gpx", "kml"]
    assert [each["bytes"] for each in told.json["files"]] == [
        (out / f"flight.{n}").stat().st_size for n in ("gpx", "kml")
    ]
    (searcher,) = told.json["searchers"]
    assert (searcher["waypoints"], searcher["altitude_m"], searcher["finish"]) == (5, 80.0, "return")
    (note,) = told.json["notes"]
    assert "count no time for corners, of which it has 3" in note


def test_maps_are_those_of_the_judge(sooner, ridge):
    sooner("export", ridge, ridge.parent / "mine.csv", "--format", "geotiff")
    judged = sooner("evaluate", ridge, ridge.parent / "mine.csv", "--json").json
    read = {}
    for name in ("poc-before", "poc-after", "pod"):
        with rasterio.open(ridge.parent / f"{name}.tif") as source:
            read[name] = source.read(1)
            assert source.crs.to_epsg() == 32632
    assert (read["poc-before"] * read["pod"]).sum() == pytest.approx(judged["cdp"], rel=1e-6)
    assert read["poc-after"].sum() == pytest.approx(1.0 - judged["cdp"], rel=1e-6)


def test_each_drone_has_its_own_file_where_a_file_holds_one_flight(sooner, tmp_path):
    mission = located(tmp_path, over_cells(HOME + HOME.replace("80", "95")), hills())
    lines = [f"{drone},{step},3,{3 + step % 2}" for drone in (0, 1) for step in range(3)]
    (tmp_path / "two.csv").write_text("searcher,step,row,col\n" + "\n".join(lines) + "\n")
    assert sooner("export", mission, tmp_path / "two.csv", "--format", "qgc,gpx").status == 0
    heights = [json.loads((tmp_path / f"flight-{drone}.plan").read_text()) for drone in (0, 1)]
    assert [each["mission"]["items"][0]["Altitude"] for each in heights] == [80, 95]
    assert (tmp_path / "flight.gpx").exists()
    assert not (tmp_path / "flight.plan").exists()


def test_the_same_plan_makes_the_same_files(sooner, ridge):
    made = []
    for out in ("a", "b"):
        sooner("export", ridge, ridge.parent / "mine.csv", "--format", ALL, "--out", ridge.parent / out)
        made.append({file.name: file.read_bytes() for file in (ridge.parent / out).iterdir()})
    assert made[0] == made[1]


def test_an_aircraft_is_named(sooner, ridge):
    plan = ridge.parent / "mine.csv"
    assert sooner("export", ridge, plan, "--format", "qgc", "--autopilot", "px4").status == 0
    assert json.loads((ridge.parent / "flight.plan").read_text())["mission"]["firmwareType"] == 12
    for option, told in (("--autopilot", "ardupilot, px4"), ("--dji", "m300, m350")):
        ended = sooner("export", ridge, plan, "--format", "qgc", option, "nobody")
        assert ended.status == 2
        assert f"{option}: 'nobody' came; expected one of {told}" in ended.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "--format: nothing came; expected one or more of qgc, waypoints, dji"),
        (["--format", "shp"], "--format: 'shp' came; expected one or more of"),
        (["--format", "qgc,"], "--format: '' came"),
    ],
)
def test_a_format_that_nobody_knows_is_refused(sooner, ridge, arguments, told):
    ended = sooner("export", ridge, ridge.parent / "mine.csv", *arguments)
    assert ended.status == 2
    assert told in ended.err
    assert not (ridge.parent / "flight.plan").exists()


def test_a_mission_without_a_place_on_the_globe_is_refused(sooner, mission, tmp_path):
    (tmp_path / "mine.csv").write_text("2,2\n2,3\n")
    ended = sooner("export", mission, tmp_path / "mine.csv", "--format", "gpx")
    assert ended.status == 2
    assert "area.poc: a raster without a georeference came; expected a GeoTIFF with its place on the globe" in ended.err
    ended = sooner("plan", mission, "--seconds", "1", "--format", "gpx")
    assert ended.status == 2
    assert not (tmp_path / "mission-plan").exists()


def test_a_plan_that_the_mission_does_not_allow_is_refused(sooner, ridge):
    (ridge.parent / "jump.csv").write_text("3,3\n5,5\n3,3\n")
    ended = sooner("export", ridge, ridge.parent / "jump.csv", "--format", "gpx")
    assert ended.status == 2
    assert "they are not neighbours" in ended.err
    assert not (ridge.parent / "flight.gpx").exists()


def test_what_somebody_else_wrote_is_left_alone(sooner, ridge):
    (ridge.parent / "flight.gpx").write_text("mine")
    ended = sooner("export", ridge, ridge.parent / "mine.csv", "--format", "qgc,gpx")
    assert ended.status == 2
    assert "sooner did not write it" in ended.err
    assert not (ridge.parent / "flight.plan").exists()
    assert sooner("export", ridge, ridge.parent / "mine.csv", "--format", "qgc,gpx", "--force").status == 0


def test_a_name_that_means_harm_is_only_a_name(sooner, tmp_path):
    hostile = '<script>alert("x")</script> & \\n ' + "y" * 10_000
    text = over_cells(HOME).replace('"Ridge"', json.dumps(hostile))
    (tmp_path / "mine.csv").write_text(PLAN)
    assert sooner("export", located(tmp_path, text, hills()), tmp_path / "mine.csv", "--format", ALL).status == 0
    for suffix in ("gpx", "kml", "cot"):
        assert "<script>" not in (tmp_path / f"flight.{suffix}").read_text()
    assert sorted(path.suffix for path in tmp_path.iterdir() if path.name.startswith("flight.")) == sorted(
        [".plan", ".waypoints", ".kmz", ".kml", ".gpx", ".geojson", ".cot"]
    )


def test_plan_writes_what_it_is_asked_for_beside_its_plan(sooner, ridge):
    ended = sooner(
        *("plan", ridge, "--seconds", "0.2", "--planner", "greedy"),
        *("--format", "qgc,csv", "--format", "geotiff", "--json"),
    )
    assert ended.status == 0
    told = ended.json["exported"]
    assert [each["format"] for each in told["files"]] == ["qgc", *["geotiff"] * 3]
    out = ridge.parent / "mission-plan"
    assert json.loads((out / "flight.plan").read_text())["fileType"] == "Plan"
    with rasterio.open(out / "pod.tif") as source:
        assert 0.6 - 1e-6 <= source.read(1).max() <= 1.0
    assert (out / "plan.csv").exists()


def test_a_plan_is_kept_that_no_file_can_fly(sooner, tmp_path):
    mission = located(tmp_path, over_cells("[[searcher]]\nstart = [3, 3]\n", 1), hills())
    ended = sooner("plan", mission, "--seconds", "0.2", "--planner", "greedy", "--format", "dji")
    assert ended.status == 2
    assert "has no speed, which dji expects" in ended.err
    assert "finds the person" in ended.out
    assert (tmp_path / "mission-plan" / "plan.csv").exists()


def test_the_lesson_lists_every_format():
    lesson = (Path(__file__).parents[2] / "docs" / "lessons" / "09_files_that_fly.md").read_text(encoding="utf-8")
    for name, about in EXPORTS.items():
        assert re.search(rf"^\| `{name}` \| [^|]* \| {re.escape(about)} \|$", lesson, re.MULTILINE), name


def test_help_names_every_format(sooner):
    told = sooner("export", "--help").out
    assert all(name in told for name in EXPORTS)


def test_every_export_holds_each_sortie(sooner, tmp_path):
    path = leg_mission(tmp_path, 1, 2, True, vehicle=VEHICLE + 'autopilot = "px4"\ndji = "m3t"\n')
    score = there_and_back(path, [[200, 900], [800, 900]], [[1400, 900], [1400, 300]])
    (tmp_path / "plan.csv").write_bytes(leg_plan_csv(score.plan, score.mission.problem, score.mission.ground))
    everything = "qgc,waypoints,dji,kml,gpx,caltopo,cot,geotiff"
    ended = sooner("export", path, tmp_path / "plan.csv", "--format", everything, "--out", tmp_path / "out", "--json")
    assert ended.status == 0
    made = {file.name for file in (tmp_path / "out").iterdir() if not file.name.startswith(".")}
    single = {f"flight-{n}.{suffix}" for n in (0, 1) for suffix in ("plan", "waypoints", "kmz", "cot")}
    assert made == single | {"flight.kml", "flight.gpx", "flight.geojson", "poc-before.tif", "poc-after.tif", "pod.tif"}
    flown = ended.json["searchers"]
    assert [each["name"] for each in flown] == ["Ridge, drone 0, battery 0", "Ridge, drone 0, battery 1"]
    assert flown[0]["takeoff_s"] > 20
    assert flown[1]["departs_s"] > 1000
    assert b'"firmwareType": 12' in (tmp_path / "out" / "flight-0.plan").read_bytes()
    overruled = sooner("export", path, tmp_path / "plan.csv", "--format", "qgc", "--autopilot", "ardupilot")
    assert overruled.status == 0
    assert b'"firmwareType": 3' in (tmp_path / "flight-0.plan").read_bytes()
