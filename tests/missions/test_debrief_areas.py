"""The next mission of an area that is drawn, or whose cells were cut finer: the same ground, and POS adds up."""

import json

import numpy as np
import pytest

from sooner.io import Folder
from sooner.io.tracks import Track
from sooner.missions import read_mission, score_plan
from sooner.missions.chances import pod_by_cell
from sooner.missions.debrief import debrief
from sooner.missions.flight_plans import check_place
from sooner.planners import max_ticks, solve
from sooner.planners.registry import DEFAULT, make_planner
from sooner.problem.leg_moves import LegMoves, places_of
from tests.georeferenced import DOLOMITES, hills, located
from tests.missions.drawn import LAT, LON, METRE_EAST, METRE_NORTH, box, drawn, mission, point, raster

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio
LEGS = 'start = "launch"\nend = "launch"\nmoves = "legs"\nspeed_mps = 10.0\naccel_mps2 = 2.0'
CELLS = 'start = "launch"\nend = "launch"\nspeed_mps = 10.0'
POINTS = 'points = "points.geojson"'
RINGS = "[area.last_known]\nplace = { lat = 46.104, lon = 11.205 }\nrings_m = [150.0, 350.0]\nquantiles = [0.5, 0.9]"
AREAS = {
    "polygon": f'{POINTS}\npolygon = "area.geojson"\noutside = 0.1\ncell_m = 25.0',
    "raster in degrees, cut": f'{POINTS}\npoc = "poc.tif"\npolygon = "area.geojson"\ncell_m = 25.0',
    "raster in degrees": f'{POINTS}\npoc = "poc.tif"\ncell_m = 25.0',
    "segments": f'{POINTS}\nsegments = "segments.geojson"\ncell_m = 25.0',
    "rings": f"{POINTS}\ncell_m = 25.0\n{RINGS}",
    "zone": f'{POINTS}\npolygon = "area.geojson"\nno_fly = "zone.geojson"\nmargin_m = 15.0\ncell_m = 25.0',
}


def flown(*metres) -> Track:
    """A track through places, metres from the corner."""
    east, north = np.array(metres, float).T
    return Track("", "flown.gpx", LAT + north * METRE_NORTH, LON + east * METRE_EAST)


@pytest.fixture
def files(tmp_path):
    drawn(tmp_path / "area.geojson", ("area", box(0, 0, 810, 905, (605, 610, 700, 703))))
    drawn(tmp_path / "zone.geojson", ("zone", box(500, 100, 600, 200)))
    drawn(tmp_path / "points.geojson", ("launch", point(400, 450)))
    drawn(
        tmp_path / "segments.geojson",
        ("one", box(0, 0, 410, 905), {"poc": 0.5}),
        ("two", box(410, 0, 810, 905), {"poc": 0.3}),
    )
    raster(tmp_path / "poc.tif", np.random.default_rng(4).random((22, 20)))
    return tmp_path


@pytest.mark.parametrize(
    ("area", "searcher"), [*((area, LEGS) for area in AREAS), ("raster in degrees, cut", CELLS), ("zone", CELLS)]
)
def test_pos_adds_up_over_debriefs_of_an_area(files, area, searcher):
    legs, area = "legs" in searcher, AREAS[area]
    budget, sensor = ("seconds = 300", "glimpse = 0.8\nradius_m = 40.0") if legs else ("steps = 40", "glimpse = 0.8")
    before = read_mission(mission(files, area, searcher, sensor, budget))
    one, two = flown((400, 450), (100, 100), (700, 150)), flown((700, 150), (100, 120), (650, 800), (5, 890))
    both, first = debrief(before, [one, two]), debrief(before, [one])
    assert 0.01 < first.found < both.found < 0.9
    following = read_mission(first.write(Folder(files / "out"))["next"])
    assert following.problem.grid.cell_m == pytest.approx(before.problem.grid.cell_m)
    assert following.belief.outside == pytest.approx(first.outside, abs=1e-5)
    second = debrief(following, [two])
    assert second.so_far.pos == pytest.approx(both.found, abs=2e-5)
    assert second.outside == pytest.approx(both.outside, abs=2e-5)
    assert second.after.max() == pytest.approx(both.after.max(), rel=1e-3)
    homes = [home_of(each) for each in (before, following)]
    np.testing.assert_allclose(*homes, atol=2e-7)
    if legs:
        spaces = [each.problem.searchers[0].moves.airspace.free.area for each in (before, following)]
        assert spaces[1] == pytest.approx(spaces[0], rel=1e-6)


def home_of(said):
    """Latitude and longitude of where the first searcher starts."""
    searcher, ground = said.problem.searchers[0], check_place(said)
    place = searcher.start
    if isinstance(searcher.moves, LegMoves):
        east, north = np.array(searcher.moves.home) / ground.cell_m
        place = said.problem.grid.shape[0] - 1 - north, east
    return ground.places([place])[0]


def test_cells_that_were_cut_finer_stay_so_and_so_do_other_rasters(tmp_path):
    text = """
name = "Ridge"
[area]
poc = "poc.tif"
obstacles = "rocks.tif"
[sensor]
glimpse = "forest.tif"
radius_m = 20.0
[[searcher]]
start = [3, 3]
end = [10, 12]
moves = "legs"
speed_mps = 10.0
accel_mps2 = 2.0
[budget]
seconds = 300
"""
    rocks, forest = np.zeros((12, 16)), np.linspace(0.1, 0.9, 12 * 16).reshape(12, 16)
    rocks[6, 8] = 1
    before = read_mission(located(tmp_path, text, hills(), rocks=rocks, forest=forest))
    parts = before.problem.grid.shape[0] // 12
    assert parts > 1
    lat, lon = DOLOMITES.places([[3, 3], [3, 12], [9, 12]]).T
    told = debrief(before, [Track("", "flown.gpx", lat, lon)])
    following = read_mission(told.write(Folder(tmp_path / "out"))["next"])
    assert following.problem.grid.shape == before.problem.grid.shape
    np.testing.assert_allclose(following.belief.poc, told.after, rtol=1e-6)
    one, other = (each.problem.searchers[0].moves for each in (before, following))
    assert (other.home, other.end) == (one.home, one.end)
    assert other.airspace.free.area == pytest.approx(one.airspace.free.area)
    np.testing.assert_allclose(other.swath.strength, one.swath.strength, rtol=1e-5)


def test_the_next_sortie_goes_where_the_last_one_did_not(files):
    """Along legs too: a third of the plan is left out, and the next plan looks there."""
    before = read_mission(mission(files, AREAS["polygon"], LEGS, "glimpse = 0.9\nradius_m = 60.0", "seconds = 400"))
    planned = annealed(before)
    places = places_of(planned.plan.actions[0])
    along_m = np.append(0.0, np.cumsum(np.hypot(*np.diff(places, axis=0).T)))
    passed = np.arange(0.0, along_m[-1] * 2 / 3, 5.0)
    east, north = (np.interp(passed, along_m, places[:, axis]) for axis in (0, 1))
    ground, side = check_place(before), before.problem.grid.cell_m
    lat, lon = ground.places(np.column_stack([before.problem.grid.shape[0] - 1 - north / side, east / side])).T
    told = debrief(before, [Track("", "flown.gpx", lat, lon)], planned)
    beside, flown_over = told.compared, told.pod > 0.5
    assert beside.share_flown == pytest.approx(2 / 3, abs=0.1)
    assert beside.found == pytest.approx(planned.evaluation.total)
    assert beside.farthest_m < 1.0
    following = annealed(read_mission(told.write(Folder(files / "out"))["next"]))
    pod = pod_by_cell(following.mission, following.looks)
    gap, over = (cells_at(following.mission, before, mask) for mask in (beside.missed, flown_over))
    assert beside.missed.sum() > 50
    assert beside.least_m2 == pytest.approx(np.pi * 60.0**2)
    assert min(gap.area_m2 for gap in beside.gaps) >= beside.least_m2
    assert sum(gap.area_m2 for gap in beside.gaps) == pytest.approx(beside.gap_m2)
    assert pod[gap].mean() > 2.0 * pod[over].mean()
    assert told.found + (1 - told.found) * following.evaluation.total > beside.found


def annealed(said):
    """The default planner's plan, by ticks and not by the clock."""
    return score_plan(said, solve(said.problem, make_planner(DEFAULT), stop=max_ticks(5), seed=1).best.plan)


def cells_at(there, here, mask):
    """Cells of one mission where those of another lie, as their grids may begin elsewhere."""
    rows, cols = np.nonzero(mask.reshape(here.problem.grid.shape))
    found = check_place(there).cells(check_place(here).places(np.column_stack([rows, cols]))).round().astype(int)
    height, width = there.problem.grid.shape
    inside = (found >= 0).all(axis=1) & (found[:, 0] < height) & (found[:, 1] < width)
    return found[inside] @ [width, 1]


def test_an_area_that_only_segments_told_is_drawn(files):
    before = read_mission(mission(files, AREAS["segments"], LEGS, "glimpse = 0.8\nradius_m = 40.0", "seconds = 300"))
    debrief(before, [flown((400, 450), (100, 100))]).write(Folder(files / "out"))
    said = json.loads((files / "out" / "next" / "area.geojson").read_text())
    assert said["features"][0]["properties"]["title"] == "search area"
