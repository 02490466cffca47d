"""The report: one page that needs nothing, whatever drones move over, with the judge's own numbers."""

import base64
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from sooner.bounds.proofs import bounds
from sooner.io.georeference import ground_m
from sooner.missions import read_mission, score_plan
from sooner.missions.flight_plans import flights
from sooner.missions.report import make_report
from sooner.missions.report.compared import patterns
from sooner.missions.report.places import richest
from sooner.missions.report.words import clock
from sooner.planners import Status, max_ticks, solve
from sooner.planners.registry import make_planner
from sooner.problem import Plan, evaluate
from tests.georeferenced import greedily, hills, located, over_cells, over_regions, rocks
from tests.missions.leg_missions import VEHICLE, leg_mission, there_and_back
from tests.missions.pages import read_page
from tests.small_mission import small_mission, written

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
DRONE = "[[searcher]]\nstart = [3, 3]\nend = [3, 3]\nspeed_mps = 12.0\naltitude_m = 80\n"
KINDS = ("cells", "cells in steps", "hexagons", "regions", "legs", "no globe", "target")
WIND = "[wind]\nspeed_mps = 3.0\nfrom_deg = 270\n"
ROUND = [[200, 900], [800, 900]], [[1400, 900], [1400, 300]]


def judged(folder, kind: str):
    """Some plan over ground of each kind."""
    if kind == "legs":
        return there_and_back(leg_mission(folder / "legs", 2, 2, True, WIND), *ROUND)
    if kind == "no globe":
        poc = "\n".join(",".join(str((r * c) % 7) for c in range(6)) for r in range(5))
        return greedily(read_mission(written(folder, small_mission((2, 2), 12), poc_csv=poc)))
    text = {
        "cells": over_cells(DRONE, area="outside = 0.1\nobstacles = 'rocks.tif'"),
        "cells in steps": over_cells("[[searcher]]\nstart = [3, 3]\n"),
        "hexagons": over_cells("[[searcher]]\nstart = [3, 3]\nspeed_mps = 9.0\n", area='grid = "hex"'),
        "regions": over_regions("start = [3, 3]", 300),
        "target": over_cells(DRONE) + "[objective]\ndetection_target = 0.05\n",
    }[kind]
    poc = 0.5 * hills() if kind == "regions" else hills()
    mission = read_mission(located(folder, text, poc, rocks=rocks()))
    if kind == "target":
        row = [3 * 16 + col for col in (3, 4, 5, 6, 7, 8, 9, 10, 9, 8, 7, 6, 5, 4, 3)]
        return score_plan(mission, Plan((np.array(row),)))
    return greedily(mission)


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """kind -> its report and page, made once."""
    made = {}

    def report(kind: str):
        if kind not in made:
            found = make_report(judged(tmp_path_factory.mktemp("report"), kind), 0.5)
            made[kind] = found, found.html()
        return made[kind]

    return report


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_is_whole_and_needs_nothing(reports, kind):
    report, content = reports(kind)
    page = read_page(content)
    assert page.count("section", "pilot") == sum(sheet.flies for sheet in report.sheets) >= 1
    assert page.count("table", "blanks") == page.count("section", "pilot")
    assert page.count("img") == 3 + page.count("section", "pilot")
    assert all(attrs["alt"] for tag, attrs in page.tags if tag == "img")
    assert len(content) < 1_000_000
    for source in page.sources:
        with Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2]))) as picture:
            assert max(picture.size) < 1200
    json.dumps(report.result(), allow_nan=False)


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_those_of_the_judge(reports, kind):
    report, content = reports(kind)
    result, score = report.result(), report.score.result()
    assert {key: result[key] for key in score} == score
    text = read_page(content).text
    told = {"probability": "{:.1f} %", "bits": "{:.3f} bits"}[score["unit"]]
    factor = 100 if score["unit"] == "probability" else 1
    assert told.format(factor * report.score.evaluation.total) in text
    if score["remaining"] is not None:
        for name in ("never_looked", "looked_but_missed", "outside"):
            assert f"{100 * score['remaining'][name]:.1f} %" in text
    for note in report.notes:
        assert note in text


@pytest.mark.parametrize("kind", KINDS)
def test_the_bound_is_proved_and_told(reports, kind):
    report, content = reports(kind)
    score, text = report.score, read_page(content).text
    if report.bound is None:
        assert "othing is proved" in text
        return
    assert report.bound.value >= score.evaluation.value - 1e-9
    assert f"Proved by {report.bound.proof}" in text
    assert report.gap is None or report.gap >= 0


def test_along_legs_the_bound_is_the_one_that_plan_tells(reports):
    report, _ = reports("legs")
    best = min(found.value for found in bounds(report.score.mission.problem))
    assert report.result()["bound"] == pytest.approx(best)


@pytest.mark.parametrize("kind", ["cells", "regions", "legs"])
def test_a_sheet_is_the_flight_that_is_exported(reports, kind):
    report, content = reports(kind)
    plans, text = flights(report.score).plans, read_page(content).text
    assert len(plans) == len(report.sheets)
    for sheet, plan in zip(report.sheets, plans, strict=True):
        assert [stop.at for stop in sheet.stops] == list(plan.places)
        assert [stop.leg_m for stop in sheet.stops[1:]] == pytest.approx(ground_m(plan.places).tolist())
        planned = [stop.time_s for stop in sheet.stops if stop.time_s is not None]
        assert (np.diff(planned) >= 0).all()
        at_end = planned[-1] + sheet.stops[-1].hold_s
        if kind == "regions":  # the way home, which a plan without an end does not count, comes on top
            assert at_end >= plan.duration_s * (1 - 1e-3)
        else:
            assert at_end == pytest.approx(plan.duration_s, rel=1e-3)
        assert f"{sheet.stops[-1].at[0]:.5f}, {sheet.stops[-1].at[1]:.5f}" in text


def test_a_sheet_of_a_battery_says_what_is_left_of_it(reports):
    report, content = reports("legs")
    text, first = read_page(content).text, report.sheets[0]
    assert first.airborne_s == pytest.approx(first.flying_s + first.sortie.takeoff_s + first.sortie.landing_s)
    left = round(1500 - first.airborne_s)
    assert f"lasts 25:00; {left // 60}:{left % 60:02d} of it is left at landing" in text
    assert "5:00 of it, which no plan uses" in text
    assert [sheet.departs_s for sheet in report.sheets] == [plan.departs_s for plan in flights(report.score).plans]
    assert first.departs_s == 0.0


@pytest.mark.usefixtures("no_patterns")
def test_who_waits_for_others_takes_off_later_on_its_sheet_too(tmp_path):
    path = leg_mission(tmp_path, 3, more="[separation]\nhorizontal_m = 60\n")
    report = make_report(there_and_back(path, *[[[200, 900], [800, 900]]] * 3), 0.1)
    told = flights(report.score)
    departs = [sheet.departs_s for sheet in report.sheets]
    assert departs == [plan.departs_s for plan in told.plans] == list(told.separation.delays_s)
    assert 0.0 == departs[0] < departs[1] < departs[2]
    assert [sheet["departs_s"] for sheet in report.result()["sheets"]] == departs
    assert report.later_s == pytest.approx(told.separation.ends_s - told.separation.planned_s)
    text = read_page(report.html()).text
    for seconds in departs:
        assert text.count(f"T + {clock(seconds)}") >= 2  # in the table of flights and on the sheet
    assert f"{clock(report.score.evaluation.times[-1] + departs[2])}, 3 flights, all at their ends" in text


def test_bearings_are_those_of_the_map(reports):
    report, _ = reports("legs")
    for sheet in report.sheets:
        east_north = np.diff(sheet.path, axis=0)
        wanted = np.degrees(np.arctan2(*east_north.T)) % 360
        told = np.array([stop.bearing_deg for stop in sheet.stops[1:]])
        assert np.abs((told - wanted + 180) % 360 - 180).max() < 0.1  # the frame's north is the true one here


@pytest.fixture
def no_patterns(monkeypatch):
    monkeypatch.setattr("sooner.missions.report.report.patterns", lambda mission, seconds: ())


@pytest.mark.usefixtures("no_patterns")
def test_a_flight_that_stays_on_the_ground_has_no_sheet(tmp_path):
    path = leg_mission(tmp_path, 1, 2)
    score = there_and_back(path, [[200, 900]])
    home = score.plan.actions[1][:1]
    grounded = make_report(score_plan(score.mission, Plan((score.plan.actions[0], home))), 0.1)
    page = read_page(grounded.html())
    assert page.count("section", "pilot") == 1
    assert "stays on the ground" in page.text
    assert grounded.sheets[1].airborne_s == 0.0


def test_patterns_are_judged_like_the_plan(reports):
    report, content = reports("legs")
    problem = report.score.mission.problem
    assert [each.value for each in report.patterns] == sorted((each.value for each in report.patterns), reverse=True)
    names = {each.name for each in report.patterns}
    assert {"parallel-track", "expanding-square", "sector", "creeping-line"} <= names
    whole = solve(problem, make_planner("sector"), stop=max_ticks(1)).best.plan
    (sector,) = (each for each in report.patterns if each.name == "sector")
    assert sector.value >= evaluate(problem, whole).total
    assert all(name in read_page(content).text for name in names)
    assert reports("cells")[0].patterns == ()


@pytest.mark.parametrize("kind", ["cells", "regions", "legs", "no globe"])
def test_the_richest_places_are_those_of_brute_force(reports, kind):
    score = reports(kind)[0].score
    places, grid = richest(score), score.mission.problem.grid
    left = np.where(grid.passable, score.left, 0.0).reshape(grid.shape)
    side, remaining = places[0].side, left.copy()
    for place in places:
        best = max(
            remaining[r : r + side, c : c + side].sum()
            for r in range(grid.shape[0] - side + 1)
            for c in range(grid.shape[1] - side + 1)
        )
        here = np.s_[place.row : place.row + side, place.col : place.col + side]
        assert remaining[here].sum() == pytest.approx(best, rel=1e-9)
        assert place.left == pytest.approx(left[here].sum())
        remaining[here] = 0.0
        if place.at is not None:
            row, col = score.mission.ground.cells([place.at])[0]
            assert (row, col) == pytest.approx((place.row + (side - 1) / 2, place.col + (side - 1) / 2), abs=1e-6)


@pytest.mark.usefixtures("no_patterns")
def test_names_that_mean_harm_are_only_names(tmp_path):
    hostile = '</title><script>alert("x")</script><img src="http://evil.example/" onerror=x> & \\u00e9 ' + "y" * 5000
    vehicle = VEHICLE.replace('"Test"', json.dumps('"><script>bad()</script>'))
    path = leg_mission(tmp_path, 1, 1, vehicle=vehicle)
    path.write_text(path.read_text().replace('"Ridge"', json.dumps(hostile)))
    page = read_page(make_report(there_and_back(path, ROUND[0]), 0.1).html())
    assert hostile.split()[0] in page.text
    assert '"><script>bad()</script>' in page.text
    assert page.count("img") == 4


def test_a_large_map_and_a_long_flight_make_no_large_file(tmp_path):
    path = located(tmp_path, over_cells("[[searcher]]\nstart = [3, 3]\nspeed_mps = 12.0\n", 3000), hills(500, 600))
    rows = np.repeat(np.arange(3, 33), 100)
    cols = np.concatenate([np.arange(3, 103) if k % 2 == 0 else np.arange(102, 2, -1) for k in range(30)])
    content = make_report(score_plan(read_mission(path), Plan((rows * 600 + cols,))), 0.1).html()
    read_page(content)
    assert len(content) < 1_000_000


@pytest.mark.parametrize(
    ("sensor", "more", "told"),
    [
        (
            "detect = 0.8\nfalse_alarm = 0.1",
            "",
            ["finds, as expected", "targets are still on", "says yes where"],
        ),
        ('model = "beta"', '[objective]\nkind = "information"\n', ["learns", "still to learn", "Targets come and go"]),
    ],
)
def test_what_is_searched_for_is_called_by_its_name(tmp_path, sensor, more, told):
    text = small_mission((1, 1), 8).replace('poc = "poc.csv"\ncell_m = 24.0', 'evidence = "theta.csv"')
    text = text.replace("glimpse = 0.5", sensor).replace("speed_mps = 12.0\n", "") + more
    theta = "0.5,0.5,0.2,0.3\n0.5,0.5,0.97,0.5\n0.1,0.9,0.5,0.5\n"
    score = greedily(read_mission(written(tmp_path, text, theta_csv=theta)))
    shown = read_page(make_report(score, 0.1).html()).text
    assert all(each in shown for each in [*told, "the mission says no speed", "cells from the middle", "8 steps"])
    assert "the person" not in shown


def test_who_presses_ctrl_c_gets_no_report(reports, monkeypatch):
    mission = reports("legs")[0].score.mission

    def interrupted(*_, **__):
        return replace(solve(mission.problem, make_planner("sector"), stop=max_ticks(1)), status=Status.INTERRUPTED)

    monkeypatch.setattr("sooner.missions.report.compared.solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        patterns(mission, 1.0)


def test_the_same_report_is_the_same_page(reports):
    report, content = reports("cells")
    assert report.html() == content
