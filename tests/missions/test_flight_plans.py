"""What aircraft are told is the line that the judge times, and what it does not say is told beside it."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import DataFormatError
from sooner.grid import rows_and_cols
from sooner.io.georeference import Georeference
from sooner.missions import read_mission, score_plan
from sooner.missions.flight_plans import flights
from sooner.missions.over_regions import dynamics_of
from sooner.problem import Plan
from sooner.problem.regions import RegionMoves
from tests.georeferenced import DOLOMITES, greedily, hills, located, over_cells, over_regions, rocks

HOME = "[[searcher]]\nstart = [3, 3]\nspeed_mps = 12.0\n"


def cells_of(plan, ground=DOLOMITES):
    return ground.cells(plan.places)


def flown(mission, *cells):
    """The flights of a plan over cells, [row, col] each."""
    width = mission.problem.grid.shape[1]
    score = score_plan(mission, Plan.of(*([row * width + col for row, col in path] for path in cells)))
    return flights(score)


def passed(corners):
    """Every place at a whole step along a polyline of cells."""
    places = [corners[0]]
    for begin, end in pairwise(corners):
        steps = int(np.abs(end - begin).max().round())
        places += [begin + (end - begin) * k / steps for k in range(1, steps + 1)]
    return np.array(places)


@settings(max_examples=40)
@given(st.lists(st.sampled_from([(0, 1), (0, -1), (1, 0), (-1, 0), (0, 0)]), min_size=1, max_size=30))
def test_the_line_passes_the_same_cells_in_the_same_order(tmp_path_factory, steps):
    mission = read_mission(located(tmp_path_factory.mktemp("line"), over_cells(HOME), hills()))
    path = [(3, 3)]
    for down, right in steps:
        there = (path[-1][0] + down, path[-1][1] + right)
        path.append(there if 0 <= there[0] < 12 and 0 <= there[1] < 16 else path[-1])
    (plan,) = flown(mission, path).plans
    moved = [path[0], *(there for here, there in pairwise(path) if here != there)]
    np.testing.assert_allclose(passed(cells_of(plan)), moved, atol=1e-4)
    waited = len(path) - len(moved)
    assert sum(each.hold_s for each in plan.waypoints) == pytest.approx(2.0 * waited)
    for (before, after), each in zip(pairwise(np.diff(cells_of(plan), axis=0)), plan.waypoints[1:-1], strict=True):
        assert each.hold_s or not np.allclose(before / np.abs(before).max(), after / np.abs(after).max(), atol=1e-3)
    assert plan.duration_s == pytest.approx(2.0 * (len(path) - 1))


def test_a_wait_is_a_hold_where_it_happens(tmp_path):
    mission = read_mission(located(tmp_path, over_cells(HOME), hills()))
    (plan,) = flown(mission, [(3, 3), (3, 3), (3, 4), (3, 5), (3, 5), (3, 5), (3, 6)]).plans
    assert [each.hold_s for each in plan.waypoints] == [2.0, 4.0, 0.0]
    np.testing.assert_allclose(cells_of(plan), [[3, 3], [3, 5], [3, 6]], atol=1e-4)


def test_corners_that_a_plan_over_cells_does_not_count_are_told_of(tmp_path):
    mission = read_mission(located(tmp_path, over_cells(HOME + "end = [4, 4]"), hills()))
    note = flown(mission, [(3, 3), (3, 4), (4, 4)]).notes[0]
    assert "drone 0: the plan's 4 s count no time for corners, of which it has 1; " in note
    assert note.endswith("takes 14 s")  # two legs of 24 m, 2 sqrt(24 / 2) s each
    straight = read_mission(located(tmp_path, over_cells(HOME + "end = [3, 5]"), hills()))
    assert not [note for note in flown(straight, [(3, 3), (3, 4), (3, 5)]).notes if "corners" in note]


def test_a_wait_needs_a_speed(tmp_path):
    mission = read_mission(located(tmp_path, over_cells("[[searcher]]\nstart = [3, 3]\n"), hills()))
    with pytest.raises(DataFormatError, match="speed_mps: nothing came, and the plan hovers"):
        flown(mission, [(3, 3), (3, 3)])
    (plan,) = flown(mission, [(3, 3), (3, 4)]).plans
    assert plan.speed_mps is plan.duration_s is None


CRS = {
    "EPSG:32632": (720_000.0, 5_150_000.0),
    "EPSG:32759": (370_000.0, 5_200_000.0),
    "EPSG:27700": (225_000.0, 775_000.0),
    "EPSG:2154": (990_000.0, 6_540_000.0),
    "EPSG:3035": (4_400_000.0, 2_600_000.0),
    "EPSG:5070": (-1_450_000.0, 1_950_000.0),
    "EPSG:3857": (1_250_000.0, 5_850_000.0),
}


@pytest.mark.parametrize("crs", CRS)
def test_wherever_on_the_globe_the_flight_lies_where_its_cells_lie(tmp_path, crs):
    ground = Georeference(crs, CRS[crs], 24.0, 24.0)
    mission = read_mission(located(tmp_path, over_cells(HOME), hills(), ground))
    told = flown(mission, [(3, 3), (3, 4), (4, 4), (4, 5)])
    off_m = 24.0 * np.hypot(*(cells_of(told.plans[0], ground) - [[3, 3], [3, 4], [4, 4], [4, 5]]).T)
    assert off_m.max() < 0.1
    true = [note for note in told.notes if "m on the ground here" in note]
    assert bool(true) == (crs == "EPSG:3857")


# ---------------------------------------------------------------- how it ends, how high


@pytest.mark.parametrize(
    ("end", "path", "finish", "landings"),
    [
        ("end = [3, 3]", [(3, 3), (3, 4), (3, 3)], "return", 0),
        ("end = [3, 5]", [(3, 3), (3, 4), (3, 5)], "land", 1),
        ('end = [3, 5]\nkind = "fixed_wing"', [(3, 3), (3, 4), (3, 5)], "loiter", 1),
        ("", [(3, 3), (3, 4), (3, 5)], "return", 0),
    ],
)
def test_a_flight_ends_where_its_mission_says(tmp_path, end, path, finish, landings):
    mission = read_mission(located(tmp_path, over_cells(HOME + end), hills()))
    told = flown(mission, path)
    assert (told.plans[0].finish, len(told.plans[0].landings)) == (finish, landings)
    assert any("does not count the 48 m, about 4 s, home" in note for note in told.notes) == (end == "")


def test_the_way_home_goes_round_obstacles(tmp_path):
    area = 'obstacles = "rocks.tif"'
    mission = read_mission(located(tmp_path, over_cells(HOME, area=area), hills(), rocks=rocks()))
    path = [(3, 3), *((3, col) for col in range(4, 9)), (4, 8), (5, 8), (6, 8)]
    told = flown(mission, path)
    (plan,) = told.plans
    cells = cells_of(plan)
    np.testing.assert_allclose(cells[:3], [[3, 3], [3, 8], [6, 8]], atol=1e-4)
    assert len(cells) > 3
    for begin, end in zip(cells[2:], [*cells[3:], cells[0]], strict=True):
        for share in np.linspace(0.0, 1.0, 200):
            row, col = np.rint(begin + share * (end - begin)).astype(int)
            assert not rocks()[row, col]
    assert any("home" in note for note in told.notes)


def test_home_is_where_the_mission_puts_it(tmp_path):
    ((lat, lon),) = DOLOMITES.places([[3.2, 2.9]])
    start = f"[[searcher]]\nstart = {{ lat = {lat:.7f}, lon = {lon:.7f} }}\nspeed_mps = 12.0\n"
    (plan,) = flown(read_mission(located(tmp_path, over_cells(start), hills())), [(3, 3), (3, 4)]).plans
    assert plan.home == pytest.approx((lat, lon), abs=1e-7)
    np.testing.assert_allclose(cells_of(plan)[0], [3, 3], atol=1e-4)


def test_a_landing_is_where_the_mission_puts_it(tmp_path):
    ((lat, lon),) = DOLOMITES.places([[3.3, 5.4]])
    end = f"end = {{ lat = {lat:.7f}, lon = {lon:.7f} }}\n"
    (plan,) = flown(read_mission(located(tmp_path, over_cells(HOME + end), hills())), [(3, 3), (3, 4), (3, 5)]).plans
    assert plan.finish == "land"
    assert plan.places[-1] == plan.landings[0] == pytest.approx((lat, lon), abs=1e-7)


@pytest.mark.parametrize(
    ("own", "height", "told"),
    [("", 60.0, "nobody says how high"), ("altitude_m = 85", 85.0, None)],
)
def test_a_flight_is_as_high_as_somebody_says(tmp_path, own, height, told):
    made = flown(read_mission(located(tmp_path, over_cells(HOME + own), hills())), [(3, 3), (3, 4)])
    assert {each.altitude_m for each in made.plans[0].waypoints} == {height}
    assert any("how high" in note for note in made.notes) == (told is not None)


def test_a_camera_says_how_high(tmp_path):
    camera = "camera = { fov_deg = 60, altitude_m = 70.0, pixels = 4000, exposure_s = 0.0005 }"
    text = over_regions("start = [3, 3]\n").replace("radius_m = 40.0", camera)
    for own, height, notes in (("", 70.0, 0), ("altitude_m = 90.0\n", 90.0, 1)):
        mission = read_mission(located(tmp_path, text.replace("[[searcher]]\n", f"[[searcher]]\n{own}"), 0.9 * hills()))
        made = flights(greedily(mission))
        assert made.plans[0].waypoints[0].altitude_m == height
        assert sum("worked out for 70 m" in note for note in made.notes) == notes


def test_drones_at_one_height_are_told_of(tmp_path):
    two = HOME.replace("speed", "altitude_m = 60\nspeed") + HOME.replace("speed", "altitude_m = 80\nspeed")
    paths = [(3, 3), (3, 4)], [(3, 3), (4, 3)]
    made = flown(read_mission(located(tmp_path, over_cells(two), hills())), *paths)
    assert [plan.name for plan in made.plans] == ["Ridge, drone 0", "Ridge, drone 1"]
    assert not [note for note in made.notes if "same height" in note]
    made = flown(read_mission(located(tmp_path, over_cells(two.replace("80", "60")), hills())), *paths)
    assert [note for note in made.notes if "same height" in note]


# ---------------------------------------------------------------- over regions


@pytest.mark.parametrize("end", ["", "end = [3, 3]\n", "end = [10, 14]\n"])
def test_over_regions_the_line_is_the_one_that_is_timed(tmp_path, end):
    area = 'obstacles = "rocks.tif"'
    text = over_regions(f"start = [3, 3]\n{end}", area=area)
    mission = read_mission(located(tmp_path, text, 0.05 + 0.9 * hills() / 2, rocks=rocks()))
    score = greedily(mission)
    (plan,) = flights(score).plans
    moves = mission.problem.searcher.moves
    assert isinstance(moves, RegionMoves)
    line = rows_and_cols(mission.problem.grid, moves.path(score.plan.actions[0]))
    cells = cells_of(plan)
    assert _length(cells[: _until(cells, line[-1])]) == pytest.approx(_length(line), abs=1e-3)
    for place in line:
        assert min(_off(place, begin, end) for begin, end in pairwise(cells)) < 1e-3
    assert plan.speed_mps == dynamics_of(mission.settings, 0).v_max == 10.0
    assert plan.duration_s <= score.durations[0] + 1e-6


def _until(cells, last):
    """How many waypoints there are up to the last time that the line's end is passed."""
    return int(np.flatnonzero(np.hypot(*(cells - last).T) < 1e-3)[-1]) + 1


def _length(cells):
    return float(np.hypot(*np.diff(cells, axis=0).T).sum())


def _off(place, begin, end):
    leg = end - begin
    share = np.clip((place - begin) @ leg / (leg @ leg), 0.0, 1.0)
    return float(np.hypot(*(place - begin - share * leg)))


def test_arcs_that_an_aircraft_does_not_fly_take_longer_and_say_so(tmp_path):
    theta = np.full((60, 60), 0.5)
    rounded = over_regions("start = [3, 3]\n", seconds=900, regions='turns = "rounded"')
    score = greedily(read_mission(located(tmp_path, rounded, theta)))
    made = flights(score)
    late = made.plans[0].duration_s - score.durations[0]
    assert late > 1.0
    assert any(f"takes {late:.0f} s more" in note for note in made.notes)


def test_a_drone_flies_no_faster_than_its_sensors_let_it(tmp_path):
    text = over_regions("start = [3, 3]\n").replace("radius_m = 40.0", "radius_m = 40.0\nrange_m = 16.0")
    mission = read_mission(located(tmp_path, text, 0.9 * hills()))
    (plan,) = flights(greedily(mission)).plans
    assert plan.speed_mps == pytest.approx(8.0)  # stops within 16 m at 2 m/s2


# ---------------------------------------------------------------- refused


def test_a_mission_that_lies_nowhere_is_refused(tmp_path):
    np.savetxt(tmp_path / "poc.csv", hills(), delimiter=",")
    text = over_cells(HOME).replace('"poc.tif"', '"poc.csv"\ncell_m = 24.0')
    mission = read_mission(located(tmp_path, text, hills()))
    with pytest.raises(DataFormatError, match=r"area\.poc: a raster without a georeference came; expected a GeoTIFF"):
        flown(mission, [(3, 3), (3, 4)])


def test_hexagons_do_not_lie_on_a_raster(tmp_path):
    mission = read_mission(located(tmp_path, over_cells(HOME, area='grid = "hex"'), hills()))
    with pytest.raises(DataFormatError, match=r"area\.grid: 'hex' came"):
        flown(mission, [(3, 3), (3, 4)])


def test_a_flight_over_the_date_line_is_refused_by_name(tmp_path):
    ground = Georeference("EPSG:32760", (732_000.0, 8_120_000.0), 24_000.0, 24_000.0)  # Taveuni, Fiji
    mission = read_mission(located(tmp_path, over_cells(HOME), hills(), ground))
    assert len(flown(mission, [(3, 3), (3, 2)]).plans) == 1
    with pytest.raises(DataFormatError, match=r"searcher\[0\]: a flight with longitudes from .* the date line"):
        flown(mission, [(3, 3), (3, 4)])


def test_a_height_that_nothing_flies_at_is_refused_by_name(tmp_path):
    camera = "camera = { fov_deg = 1, altitude_m = 20000.0, pixels = 4000, exposure_s = 0.000001 }"
    text = over_regions("start = [3, 3]\n").replace("radius_m = 40.0", camera)
    mission = read_mission(located(tmp_path, text, 0.9 * hills()))
    with pytest.raises(DataFormatError, match=r"searcher\[0\]: an altitude of 20000.0 came; expected -10000 to "):
        flights(greedily(mission))
