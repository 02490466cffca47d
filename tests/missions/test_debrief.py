"""A debrief: Bayes by cell, POS that adds up, gaps, and the next mission."""

import json
import tomllib
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import DataFormatError, ImpossibleObservationError, UnsupportedProblemError
from sooner.io import Folder, read_raster
from sooner.missions import read_mission, score_plan
from sooner.missions.debrief import debrief
from sooner.missions.debrief_again import digest
from sooner.missions.debrief_next import Searched, toml
from sooner.missions.debrief_plan import _large
from sooner.planners import max_ticks, solve
from sooner.planners.registry import DEFAULT, make_planner
from sooner.problem import Plan
from tests.georeferenced import DOLOMITES, hills, located, over_cells, over_regions, rocks
from tests.missions.test_debrief_looks import along

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
HOME = "[[searcher]]\nstart = [3, 3]\nend = [3, 3]\nspeed_mps = 12.0\n"
AREA = 'obstacles = "rocks.tif"\noutside = 0.1'
LINES = st.lists(
    st.lists(st.tuples(st.floats(0, 11), st.floats(0, 15)), min_size=2, max_size=8), min_size=2, max_size=3
)


@pytest.fixture(scope="module")
def ridge(tmp_path_factory):
    def make(text=None, **more):
        text = over_cells(HOME, 60, area=AREA) if text is None else text
        return read_mission(located(tmp_path_factory.mktemp("ridge"), text, 0.5 * hills(), rocks=rocks(), **more))

    return make


@settings(max_examples=30)
@given(LINES)
def test_the_posterior_is_bayes_and_flights_in_any_order_teach_the_same(ridge, lines):
    mission = ridge()
    tracks = [along(line) for line in lines]
    try:
        told = debrief(mission, tracks)
    except DataFormatError as error:
        assert "look at nothing" in str(error)  # noqa: PT017
        return
    before = mission.belief.poc.ravel()
    joint = before * (1.0 - told.pod)
    np.testing.assert_allclose(told.after.ravel(), joint / (joint.sum() + mission.belief.outside), rtol=1e-12)
    assert told.after.sum() + told.outside == pytest.approx(1.0)
    assert told.found == pytest.approx(1.0 - joint.sum() - mission.belief.outside)
    assert sum(told.adds) == pytest.approx(told.found)
    assert min(told.adds) >= -1e-15
    turned = debrief(mission, tracks[::-1])
    np.testing.assert_array_equal(turned.after, told.after)
    assert told.outside >= mission.belief.outside


def test_pos_adds_up_over_debriefs(ridge, tmp_path):
    """POS_1 + (1 - POS_1) POS_2 is what one debrief of both flights says; so is where the person may be."""
    mission = ridge()
    one, two = along([[3, 3], [3, 12], [6, 12]]), along([[6, 12], [3, 12], [3, 8], [10, 3]])
    both = debrief(mission, [one, two])
    first = debrief(mission, [one])
    first.write(Folder(tmp_path / "first"))
    following = read_mission(tmp_path / "first" / "next" / "mission.toml")
    second = debrief(following, [two])
    assert second.searched == Searched("Ridge", first.found, 1, (digest(one),))
    assert first.found + (1.0 - first.found) * second.found == pytest.approx(both.found, rel=1e-6)
    assert second.so_far.pos == pytest.approx(both.found, rel=1e-6)
    np.testing.assert_allclose(second.after, both.after, rtol=1e-5)
    assert second.outside == pytest.approx(both.outside, rel=1e-6)
    second.write(Folder(tmp_path / "second"))
    third = read_mission(tmp_path / "second" / "next" / "mission.toml")
    assert third.name == "Ridge, after 2 flights"
    np.testing.assert_allclose(third.belief.poc, both.after, rtol=1e-5)


def test_a_track_that_comes_again_is_counted_once(ridge, tmp_path):
    mission = ridge()
    one, two = along([[3, 3], [3, 12], [6, 12]]), along([[6, 12], [3, 12], [3, 8], [10, 3]])
    once, twice = debrief(mission, [one]), debrief(mission, [one, replace(one, name="Team 4", source="copy.gpx")])
    assert twice.found == once.found
    np.testing.assert_array_equal(twice.after, once.after)
    assert [note for note in twice.notes if note not in once.notes] == [
        "copy.gpx: a track (Team 4) has the places and times of one in flown.gpx; it is counted once"
    ]
    twice.write(Folder(tmp_path / "out"))
    following = read_mission(tmp_path / "out" / "next" / "mission.toml")
    with pytest.raises(DataFormatError, match=r"flown.gpx: no track came but those .* counted; expected a flight that"):
        debrief(following, [one])
    both = debrief(following, [one, two])
    assert both.so_far.flights == 2
    assert both.found == debrief(following, [two]).found
    assert any("was counted in a debrief before this one" in note for note in both.notes)


def test_the_same_way_at_another_time_is_another_flight(ridge):
    track = replace(
        along([[3, 3], [3, 12]]), times_s=np.array([0.0, 20.0]), started=datetime(2026, 5, 3, 12, tzinfo=UTC)
    )
    later = replace(track, started=datetime(2026, 5, 3, 13, tzinfo=UTC))
    assert debrief(ridge(), [track, later]).so_far.flights == 2


def annealed(mission):
    """The default planner's plan, by ticks and not by the clock."""
    return score_plan(mission, solve(mission.problem, make_planner(DEFAULT), stop=max_ticks(5), seed=1).best.plan)


def test_the_next_plan_goes_where_the_flight_did_not(tmp_path):
    """A third of the plan is left out: the gap is found, and the next plan looks at it."""
    spread = np.ones((20, 20))
    mission = read_mission(located(tmp_path, over_cells(HOME, 240, sensor="glimpse = 0.9"), spread))
    planned = annealed(mission)
    path = np.column_stack(np.divmod(planned.plan.actions[0], 20))
    told = debrief(mission, [along(path[: 2 * len(path) // 3])], planned)
    beside = told.compared
    assert beside.share_flown == pytest.approx(2 / 3, abs=0.1)
    assert beside.found == pytest.approx(planned.evaluation.total)
    assert beside.farthest_m < 1.0
    assert told.found < 0.8 * beside.found
    gap = beside.missed
    assert gap.sum() > 50
    told.write(Folder(tmp_path / "out"))
    following = annealed(read_mission(tmp_path / "out" / "next" / "mission.toml"))
    looks = following.looks
    flown = told.looks > 0
    assert (looks[gap] > 0).mean() > 0.8
    assert (looks[flown] > 0).mean() < 0.4
    assert told.found + (1 - told.found) * following.evaluation.total > beside.found


def test_a_plan_that_was_flown_has_no_gap_and_one_that_was_not_is_all_gap(ridge):
    mission = ridge()
    actions = np.array([3 * 16 + 3, 3 * 16 + 4, 2 * 16 + 4, 2 * 16 + 3, 3 * 16 + 3])
    score = score_plan(mission, Plan((actions,)))
    whole = debrief(mission, [along(np.column_stack(np.divmod(actions, 16)))], score).compared
    assert whole.gaps == ()
    assert (whole.gap_m2, whole.share_flown) == (0.0, 1.0)
    elsewhere = debrief(mission, [along([[10, 3], [10, 12]])], score).compared
    assert np.flatnonzero(elsewhere.missed).tolist() == sorted(set(actions.tolist()))
    assert elsewhere.share_flown == 0.0
    assert elsewhere.farthest_m == pytest.approx(24.0 * np.hypot(7, 8), rel=1e-3)
    np.testing.assert_allclose(DOLOMITES.cells([elsewhere.farthest_at]), [[10, 12]], atol=1e-3)


def test_of_a_plan_that_flies_nothing_no_line_is_told(ridge, tmp_path):
    mission = ridge()
    told = debrief(mission, [along([[3, 3], [3, 12]])], score_plan(mission, Plan((np.array([3 * 16 + 3]),))))
    said = told.write(Folder(tmp_path / "out"))["plan"]
    assert (said["share_flown"], said["farthest_m"], said["farthest_at"]) == (None, None, None)


def test_gaps_smaller_than_a_look_are_left_out(ridge):
    mission = ridge()
    short = np.zeros((12, 16), bool)
    short[2, 3:6] = short[5:7, 4:7] = short[9, 9] = True
    large = _large(mission.problem.grid, short.ravel(), 4 * 24.0**2).reshape(short.shape)
    assert np.flatnonzero(large.any(axis=1)).tolist() == [5, 6]
    assert large.sum() == 6
    assert not _large(mission.problem.grid, np.zeros(192, bool), 1.0).any()


def test_gaps_are_polygons_of_the_cells_that_were_missed(ridge, tmp_path):
    mission = ridge()
    ring = [(2, 2), (2, 3), (2, 4), (3, 4), (4, 4), (4, 3), (4, 2), (3, 2), (3, 3)]  # with a hole once (3, 3) is flown
    around = [(3, 3), (3, 2), *ring[:8]]
    score = score_plan(mission, Plan((np.array([row * 16 + col for row, col in [*around, (3, 3)]]),)))
    told = debrief(mission, [along([[3.0, 2.6], [3.0, 3.4]]), along([[9, 12], [11, 12]])], score)
    (gap,) = told.compared.gaps
    assert gap.area_m2 == told.compared.gap_m2 == 8 * 24.0**2
    assert gap.poc == pytest.approx(told.after.ravel()[told.compared.missed].sum())
    border, hole = (DOLOMITES.cells(each) for each in gap.rings)
    polygon = shapely.Polygon(border, [hole])
    assert polygon.area == pytest.approx(8.0, abs=1e-6)
    assert shapely.Polygon(hole).centroid.distance(shapely.Point(3, 3)) < 1e-6
    told.write(Folder(tmp_path / "out"))
    said = json.loads((tmp_path / "out" / "gaps.geojson").read_text())
    (feature,) = said["features"]
    rings = feature["geometry"]["coordinates"]
    assert [shapely.LinearRing(each).is_ccw for each in rings] == [True, False]  # as RFC 7946 asks
    assert feature["properties"]["class"] == "Shape"


def test_the_next_mission_is_the_same_but_for_where_the_person_may_be(ridge, tmp_path):
    mission = ridge()
    told = debrief(mission, [along([[3, 3], [3, 12]])])
    written = told.write(Folder(tmp_path / "out"))
    following = read_mission(written["next"])
    before, after = mission.settings, following.settings
    assert after.area.outside == pytest.approx(told.outside)
    assert (after.searcher, after.budget, after.sensor) == (before.searcher, before.budget, before.sensor)
    np.testing.assert_array_equal(following.problem.grid.obstacles, mission.problem.grid.obstacles)
    np.testing.assert_allclose(following.belief.poc, told.after, rtol=1e-6)
    pod = read_raster(tmp_path / "out" / "pod.tif").values
    np.testing.assert_allclose(pod.ravel(), told.pod, rtol=1e-6)
    left = read_raster(tmp_path / "out" / "poc-after.tif").values
    np.testing.assert_allclose(left, told.after * (1 - told.found), rtol=1e-5, atol=1e-12)
    assert (tmp_path / "out" / "debrief.png").read_bytes().startswith(b"\x89PNG")


def test_over_evidence_every_look_said_no(ridge, tmp_path):
    mission = ridge(over_regions("start = [3, 3]\nend = [3, 3]", 500))
    told = debrief(mission, [along([[3, 3], [3, 12]])])
    theta, looks = np.ravel(mission.sight.theta), told.looks
    odds = theta / (1 - theta) * (0.15 / 0.85) ** looks
    np.testing.assert_allclose(told.after.ravel(), odds / (1 + odds), rtol=1e-12)
    assert told.result()["so_far"] is None
    written = told.write(Folder(tmp_path / "out"))
    assert read_mission(written["next"]).problem.searchers[0].budget == 500


def test_a_target_out_of_reach_is_left_out_of_the_next_mission(ridge, tmp_path):
    text = over_cells(HOME, 60, area=AREA, sensor="glimpse = 1.0") + "[objective]\ndetection_target = 0.85\n"
    sweep = [[row, col] for row in range(12) for col in ((0, 15) if row % 2 == 0 else (15, 0))]
    written = debrief(ridge(text), [along(sweep)]).write(Folder(tmp_path / "out"))
    assert any("cannot be reached any more" in note for note in written["notes"])
    assert read_mission(written["next"]).settings.objective.detection_target is None


def test_where_nothing_is_left_there_is_no_next_mission(tmp_path):
    text = over_cells(HOME, 60, area="outside = 0.1", sensor="glimpse = 1.0")
    poc = np.zeros((12, 16))
    poc[5, 5:9] = 1.0
    told = debrief(read_mission(located(tmp_path, text, poc)), [along([[5, 4], [5, 10]])])
    written = told.write(Folder(tmp_path / "out"))
    assert written["next"] is None
    assert "there is no next mission" in written["notes"][-1]
    assert not (tmp_path / "out" / "next").exists()


def test_another_height_than_the_sensor_is_counted_at_is_told(ridge):
    mission = ridge(over_cells(HOME + "altitude_m = 60\n", 60, area=AREA))
    track = along([[3, 3], [3, 12]])
    for height, above, told in ((60.0, "home", False), (120.0, "home", True), (1500.0, "sea", False)):
        object.__setattr__(track, "altitude_m", np.full(2, height))
        object.__setattr__(track, "above", above)
        assert any("above home half of the time" in note for note in debrief(mission, [track]).notes) == told


# ---------------------------------------------------------------- refusals


def test_nobody_found_where_all_would_have_been_cannot_be(tmp_path):
    text = over_cells(HOME, 60, sensor="glimpse = 1.0")
    poc = np.zeros((12, 16))
    poc[5, 5:9] = 1.0 / 3.0
    mission = read_mission(located(tmp_path, text, poc))
    with pytest.raises(
        ImpossibleObservationError, match=r"for sure, and nobody was found; expected area.outside above 0"
    ):
        debrief(mission, [along([[5, 4], [5, 10]])])


def test_too_many_flights_are_refused(ridge):
    with pytest.raises(DataFormatError, match="1,001 flights came; expected at most 1,000"):
        debrief(ridge(), [along([[3, 3], [3, 12]])] * 1001)


def test_a_flight_over_another_map_is_refused(ridge):
    with pytest.raises(DataFormatError, match=r"flown.gpx: tracks came that look at nothing of this map; expected a"):
        debrief(ridge(), [along([[500, 500], [520, 500]])])


def test_a_mission_that_lies_nowhere_is_refused(mission):
    with pytest.raises(DataFormatError, match=r"area.poc: a raster without a georeference"):
        debrief(read_mission(mission()), [along([[0, 0], [2, 2]])])


def test_where_targets_come_and_go_there_is_no_debrief(ridge):
    text = over_regions("start = [3, 3]").replace("detect = 0.85\nfalse_alarm = 0.15", 'model = "beta"')
    mission = read_mission(located(Path(ridge().path.parent), text, 0.1 + 0.5 * hills()))
    with pytest.raises(UnsupportedProblemError, match="looks that detect"):
        debrief(mission, [along([[3, 3], [3, 12]])])


@pytest.mark.parametrize(
    "said",
    [
        "{",
        "[]",
        '{"mission": "mission.toml", "name": "a", "pos": 1.5, "flights": 1}',
        "9" * 5000,
        '{"mission": "mission.toml", "name": "a", "pos": 0.5, "flights": 1, "tracks": [1]}',
    ],
)
def test_what_was_searched_is_read_with_care(tmp_path, said):
    mission = read_mission(located(tmp_path, over_cells(HOME), hills()))
    (tmp_path / "searched.json").write_text(said)
    with pytest.raises(DataFormatError, match="expected what `sooner debrief` wrote there"):
        debrief(mission, [along([[3, 3], [3, 12]])])


def test_what_was_searched_of_another_mission_does_not_count(tmp_path):
    mission = read_mission(located(tmp_path, over_cells(HOME), hills()))
    (tmp_path / "searched.json").write_text('{"mission": "other.toml", "name": "a", "pos": 0.5, "flights": 1}')
    assert debrief(mission, [along([[3, 3], [3, 12]])]).searched.pos == 0.0


TEXTS = st.text(st.characters(codec="utf-8"), max_size=8)
PLAIN = st.one_of(TEXTS, st.integers(-(2**60), 2**60), st.floats(allow_nan=False), st.booleans())
VALUES = st.recursive(PLAIN, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3))


@settings(max_examples=40)
@given(st.dictionaries(TEXTS, VALUES | st.lists(st.dictionaries(TEXTS, VALUES, max_size=3), min_size=1, max_size=3)))
def test_a_mission_file_is_written_as_it_was_read(said):
    if any(isinstance(value, list) and len({isinstance(each, dict) for each in value}) > 1 for value in said.values()):
        return  # TOML's tables that come several times are all tables
    assert tomllib.loads(toml(said).decode()) == said
