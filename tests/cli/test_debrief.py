"""`sooner debrief`."""

import json

import numpy as np
import pytest

from tests.georeferenced import DOLOMITES, hills, located, over_cells
from tests.io.tracks.files import gpx, tlog

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
HOME = "[[searcher]]\nstart = [3, 3]\nend = [3, 3]\nspeed_mps = 12.0\naltitude_m = 80\n"
PLAN = "row,col\n3,3\n3,4\n3,5\n4,5\n4,4\n4,3\n3,3\n"


def fixes(*cells):
    """From cell to cell, two seconds each."""
    return [(lat, lon, 2.0 * k, 80.0) for k, (lat, lon) in enumerate(DOLOMITES.places(cells).tolist())]


@pytest.fixture
def ridge(tmp_path):
    (tmp_path / "mine.csv").write_text(PLAN)
    (tmp_path / "one.gpx").write_text(gpx(fixes((3, 3), (3, 4), (3, 5), (4, 5))))
    (tmp_path / "two.tlog").write_bytes(tlog(fixes((4, 4), (4, 3), (3, 3))))
    return located(tmp_path, over_cells(HOME, area="outside = 0.1"), hills())


def test_a_flight_is_told_and_the_next_mission_plans(sooner, ridge):
    here = ridge.parent
    ended = sooner("debrief", ridge, here / "one.gpx", "--plan", here / "mine.csv")
    assert ended.status == 0
    for told in (
        "Ridge: 1 flight",
        "72 m, 0:06, adds",
        "POS of these flights",
        "of the plan's line was flown",
        "ha in 1",
    ):
        assert told in ended.out
    out = here / "mission-debrief"
    assert sorted(path.name for path in out.iterdir() if not path.name.startswith(".")) == [
        *("debrief.json", "debrief.png", "gaps.geojson", "next", "poc-after.tif", "pod.tif")
    ]
    assert f"sooner plan {out / 'next' / 'mission.toml'}" in ended.out
    planned = sooner("plan", out / "next" / "mission.toml", "--seconds", "0.2", "--json", "--quiet")
    assert planned.json["mission"] == "Ridge, after 1 flight"


def test_json_tells_everything_and_pos_adds_up(sooner, ridge):
    here = ridge.parent
    both = sooner("debrief", ridge, here / "one.gpx", here / "two.tlog", "--json", "--out", here / "both").json
    assert [track["file"] for track in both["tracks"]] == [str(here / "one.gpx"), str(here / "two.tlog")]
    assert sum(track["adds"] for track in both["tracks"]) == pytest.approx(both["found"])
    assert both["plan"] is None
    stored = json.loads((here / "both" / "debrief.json").read_text())
    assert stored == {key: value for key, value in both.items() if key != "files"}
    first = sooner("debrief", ridge, here / "one.gpx", "--json", "--out", here / "first").json
    second = sooner("debrief", first["next"], here / "two.tlog", "--json", "--out", here / "second").json
    assert second["so_far"] == {"before": first["found"], "found": pytest.approx(both["found"], rel=1e-6), "flights": 2}
    assert "with all 2 flights so far" in sooner("debrief", first["next"], here / "two.tlog").out


def test_gaps_in_the_log_are_told_and_their_length_is_the_users(sooner, ridge):
    track = fixes((3, 3), (3, 4), (3, 5), (4, 5))
    late = [(lat, lon, when + 20.0 * (k > 1), up) for k, (lat, lon, when, up) in enumerate(track)]
    (ridge.parent / "late.gpx").write_text(gpx(late))
    told = sooner("debrief", ridge, ridge.parent / "late.gpx", "--json")
    assert told.json["tracks"][0]["gaps"] == 1
    assert "what lies between counts as not flown" in told.err
    assert sooner("debrief", ridge, ridge.parent / "late.gpx", "--json", "--gap", 30).json["tracks"][0]["gaps"] == 0


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("<gpx/>", "no fix came that can be true"),
        (gpx([(0.5, 9.0, 0, 0), (0.5, 9.0001, 1, 0)]), "look at nothing of this map; expected a flight over"),
        (gpx([(89.9, -170.0, 0, 0), (89.9, -169.9, 1, 0)]), "a"),
    ],
)
def test_what_is_refused_leaves_nothing(sooner, ridge, content, told):
    (ridge.parent / "bad.gpx").write_text(content)
    ended = sooner("debrief", ridge, ridge.parent / "one.gpx", ridge.parent / "none.gpx")
    assert ended.status == 2
    assert "there is no such file" in ended.err
    ended = sooner("debrief", ridge, ridge.parent / "bad.gpx")
    assert ended.status == 2
    assert told in ended.err
    assert not (ridge.parent / "mission-debrief").exists()


def test_options_that_cannot_be_are_refused_by_name(sooner, ridge):
    ended = sooner("debrief", ridge, ridge.parent / "one.gpx", "--gap", "nan")
    assert ended.status == 2
    assert "--gap: nan came; expected seconds above 0" in ended.err
    (ridge.parent / "jump.csv").write_text("3,3\n5,5\n3,3\n")
    ended = sooner("debrief", ridge, ridge.parent / "one.gpx", "--plan", ridge.parent / "jump.csv")
    assert ended.status == 2
    assert "they are not neighbours" in ended.err


def test_what_somebody_else_wrote_is_left_alone(sooner, ridge):
    (ridge.parent / "mission-debrief" / "next").mkdir(parents=True)
    (ridge.parent / "mission-debrief" / "next" / "mission.toml").write_text("mine")
    ended = sooner("debrief", ridge, ridge.parent / "one.gpx")
    assert ended.status == 2
    assert "sooner did not write it" in ended.err
    assert not (ridge.parent / "mission-debrief" / "debrief.json").exists()
    assert sooner("debrief", ridge, ridge.parent / "one.gpx", "--force").status == 0


def test_a_line_without_times_is_told_as_flown_at_the_missions_speed(sooner, ridge):
    line = [[lon, lat] for lat, lon in DOLOMITES.places([(3, 3), (3, 8)]).tolist()]
    (ridge.parent / "a.geojson").write_text(json.dumps({"type": "LineString", "coordinates": line}))
    told = sooner("debrief", ridge, ridge.parent / "a.geojson", "--json")
    assert told.json["tracks"][0]["duration_s"] == pytest.approx(10.0, rel=1e-2)
    assert np.isclose(told.json["tracks"][0]["length_m"], 120.0, rtol=1e-2)
