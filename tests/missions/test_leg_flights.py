"""Sorties along legs as aircraft are told them: the judged line, above the ground, in the judged time."""

import json
from itertools import pairwise

import numpy as np
import pytest
import rasterio
import rasterio.warp
import shapely

from sooner.errors import DataFormatError
from sooner.io.flights.aircraft import Aircraft
from sooner.io.flights.qgroundcontrol import qgroundcontrol_plan
from sooner.missions import read_mission, score_plan
from sooner.missions.chances import chances
from sooner.missions.exported import export
from sooner.missions.flight_plans import flights
from sooner.missions.planning import plan_mission
from sooner.motion import Terrain
from sooner.planners import solve
from sooner.planners.registry import make_planner
from sooner.problem import Plan
from sooner.problem.leg_moves import places_of
from tests.missions.drawn import box, drawn, place, raster
from tests.missions.leg_missions import AREA, LAUNCH, VEHICLE, leg_mission, there_and_back
from tests.oracles.flown_file import Limits, fly_file

ROUND = [[200, 900], [800, 900], [800, 100]]
FAR = [[1400, 900], [1400, 300]]
WIND = "[wind]\nspeed_mps = 6\nfrom_deg = 250"


def metres_of(mission, plan):
    """(n, 2): where its waypoints lie, by the projection and not by the code that wrote them."""
    return mission.area.frame.metres(plan.places)


def off_line(points, line):
    """Metres of each point from a polyline."""
    return shapely.distance(shapely.LineString(line), shapely.points(points))


@pytest.mark.parametrize("hilly", [False, True])
def test_waypoints_lie_on_the_judged_line_and_hold_all_its_turns(tmp_path, hilly):
    score = there_and_back(leg_mission(tmp_path, 2, 2, hilly), ROUND, FAR)
    told = flights(score)
    names = [f"Ridge, drone {drone}, battery {battery}" for drone in (0, 1) for battery in (0, 1)]
    assert [plan.name for plan in told.plans] == names
    for plan, actions in zip(told.plans, score.plan.actions, strict=True):
        line, found = places_of(actions), metres_of(score.mission, plan)
        assert off_line(found, line).max() < 0.01
        assert off_line(line, found).max() < 0.01
        assert plan.finish == "return"
        assert plan.home == pytest.approx(plan.places[-1], abs=1e-7)
        assert (len(found) > len(line)) == hilly


def test_a_drone_with_one_battery_is_called_by_its_number_alone(tmp_path):
    told = flights(there_and_back(leg_mission(tmp_path, 2), ROUND))
    assert [plan.name for plan in told.plans] == ["Ridge, drone 0", "Ridge, drone 1"]
    assert [plan.name for plan in flights(there_and_back(leg_mission(tmp_path), ROUND)).plans] == ["Ridge"]


@pytest.mark.parametrize("hilly", [False, True])
@pytest.mark.parametrize("wind", ["", WIND])
@pytest.mark.parametrize("end", ["", 'end = "farm"\n'])
def test_they_take_what_the_judge_says(tmp_path, hilly, wind, end):
    drones, batteries = (2, 1) if end else (1, 2)
    score = there_and_back(leg_mission(tmp_path, drones, batteries, hilly, wind, searcher=end), ROUND, FAR)
    told = flights(score)
    assert len(told.plans) == 2
    for plan, seconds in zip(told.plans, score.durations, strict=True):
        assert plan.duration_s == seconds
        path = tmp_path / "flight.plan"
        path.write_bytes(qgroundcontrol_plan(plan, Aircraft()))
        blown = score.mission.problem.searchers[0].moves.pace.wind
        done = fly_file(path, Limits(2.0, 2.5, 1.5, 15.0, blown, (0.5, 10.0)))
        assert done.between_s == pytest.approx(seconds, rel=0.015)  # 3 % is what is promised
        vehicle, heights = score.mission.sorties[0].vehicle, [each.altitude_m for each in plan.waypoints]
        ends = vehicle.climb_s(heights[0]) - vehicle.takeoff_s + vehicle.landing_s(heights[-1])  # to home's height
        assert done.whole_s - done.between_s == pytest.approx(ends, rel=0.03)
        assert done.top["off"] < 3.0


def test_take_off_and_landing_are_told_apart_and_later_sorties_leave_later(tmp_path):
    score = there_and_back(leg_mission(tmp_path, 1, 2), ROUND)
    vehicle = score.mission.sorties[0].vehicle
    first, second = flights(score).plans
    assert (first.takeoff_s, first.landing_s) == (vehicle.climb_s(60.0), vehicle.landing_s(60.0))
    assert first.departs_s == 0.0
    assert second.departs_s == pytest.approx(1500 * 0.8 + 60)  # the whole first battery, and the swap


def test_a_surface_above_home_takes_longer_to_climb_to_which_the_plan_keeps_time_for(tmp_path):
    path = leg_mission(tmp_path, 1, 2, True)
    pit = np.full((45, 70), 640.0, np.float32)
    pit[40:43, 5:8] = 600.0  # home lies in it
    raster(tmp_path / "heights.tif", pit, 25.0)
    score = there_and_back(path, ROUND)
    told, vehicle = flights(score), score.mission.sorties[0].vehicle
    first, second = told.plans
    climbs = first.waypoints[0].altitude_m
    assert climbs > 80.0
    assert first.takeoff_s == pytest.approx(vehicle.climb_s(climbs), abs=0.01)
    assert first.landing_s == pytest.approx(vehicle.landing_s(climbs), abs=0.01)
    budget = score.mission.problem.searchers[0].budget
    assert budget + first.takeoff_s + first.landing_s == pytest.approx(1500.0 * 0.8, abs=0.1)
    assert second.departs_s == pytest.approx(1500.0 * 0.8 + 60.0, abs=0.1)
    assert told.notes == ()


@pytest.mark.parametrize("crs", [None, "EPSG:32632", "EPSG:3035", "EPSG:2154", "EPSG:4326"])
def test_places_come_back_to_the_judged_line_whatever_the_raster(tmp_path, crs):
    """Raster -> plan -> .plan -> metres of the frame by PROJ itself: below 0.1 m."""
    path = leg_mission(tmp_path)
    if crs is not None:
        poc = np.outer(np.arange(1.0, 46.0), np.arange(1.0, 71.0)).astype(np.float32)
        if crs == "EPSG:4326":
            raster(tmp_path / "poc.tif", poc, 25.0)
        else:
            _projected(tmp_path / "poc.tif", poc, crs)
        path.write_text(path.read_text().replace("cell_m = 25.0", 'cell_m = 25.0\npoc = "poc.tif"'))
    score = there_and_back(path, ROUND)
    ground = score.mission.ground
    items = json.loads(qgroundcontrol_plan(flights(score).plans[0], Aircraft()))["mission"]["items"]
    lat, lon = np.array([item["params"][4:6] for item in items if item["command"] == 16]).T
    east, north = rasterio.warp.transform("EPSG:4326", ground.crs, lon.tolist(), lat.tolist())
    unit_m = ground.cell_m / ground.side
    south_west = np.array(ground.corner) * unit_m + [
        ground.cell_m / 2,
        (0.5 - score.mission.problem.grid.shape[0]) * ground.cell_m,
    ]
    found = np.column_stack([east, north]) * unit_m - south_west
    line = places_of(score.plan.actions[0])
    assert np.abs(found - line).max() < 0.1


def _projected(path, values, crs):
    """A raster in metres of another projection around the area."""
    (east,), (north,) = rasterio.warp.transform("EPSG:4326", crs, [11.1985], [46.1105])
    at = rasterio.Affine(30.0, 0, east, 0, -30.0, north)
    profile = {"driver": "GTiff", "height": 70, "width": 90, "count": 1, "dtype": "float32"}
    with rasterio.open(path, "w", **profile, crs=crs, transform=at) as file:
        file.write(np.pad(values, ((0, 25), (0, 20)), mode="edge"), 1)


# ---------------------------------------------------------------- terrain


def test_terrain_is_followed_within_two_metres_and_never_lower_than_asked(tmp_path):
    mission_file = leg_mission(tmp_path, 1, 1, True, searcher="altitude_m = 70\n")
    score = there_and_back(mission_file, [[100, 950], [1400, 900], [200, 100], [1450, 150]])
    (plan,) = flights(score).plans
    area = score.mission.area
    ground = Terrain(area.elevation, area.ground.cell_m)
    surface = score.mission.problem.searchers[0].moves.pace.terrain
    points, shares = metres_of(score.mission, plan), np.linspace(0.0, 1.0, 200)[:, None]
    heights = np.array([each.altitude_m for each in plan.waypoints]) + plan.home_altitude_m
    for (a, b), (low, high) in zip(pairwise(points), pairwise(heights), strict=True):
        along, flown = a + shares * (b - a), low + shares[:, 0] * (high - low)
        assert (flown - ground.heights_at(along)).min() >= 70.0 - 1e-3
        assert np.abs(flown - surface.heights_at(along) - 70.0).max() < 2.0 + 0.1
    assert len(plan.waypoints) < 80


def test_home_is_as_high_as_the_raster_says(tmp_path):
    path = leg_mission(tmp_path, 1, 1, True)
    (plan,) = flights(there_and_back(path, ROUND)).plans
    with rasterio.open(tmp_path / "heights.tif") as source:
        ((lat, lon),) = [plan.home]
        row, col = source.index(lon, lat)
        assert plan.home_altitude_m == pytest.approx(float(source.read(1)[row, col]), abs=3.0)
    assert plan.waypoints[0].altitude_m >= 60.0


def test_a_valley_beneath_home_is_flown_below_it(tmp_path):
    path = leg_mission(tmp_path, 1, 1, True)
    slope = np.broadcast_to(np.linspace(900.0, 500.0, 70, dtype=np.float32), (45, 70))
    raster(tmp_path / "heights.tif", slope, 25.0)
    (plan,) = flights(there_and_back(path, FAR)).plans
    assert min(each.altitude_m for each in plan.waypoints) < -200.0
    assert plan.height.startswith("-")


def test_nobody_says_how_high_the_ground_is(tmp_path):
    told = flights(there_and_back(leg_mission(tmp_path, 2), ROUND))
    assert {each.altitude_m for plan in told.plans for each in plan.waypoints} == {60.0}
    assert [plan.home_altitude_m for plan in told.plans] == [None, None]
    assert sum("how high the ground is" in note for note in told.notes) == 1
    assert not [
        note for note in flights(there_and_back(leg_mission(tmp_path, 1, 1, True), ROUND)).notes if "high the" in note
    ]


# ---------------------------------------------------------------- speed


def test_a_head_wind_and_slopes_are_told_as_speeds(tmp_path):
    strong = "[wind]\nspeed_mps = 9\nfrom_deg = 0"
    still, windy, hilly = (
        flights(there_and_back(leg_mission(tmp_path / name, 1, 1, high, wind), ROUND)).plans[0]
        for name, high, wind in (("a", False, ""), ("b", False, strong), ("c", True, ""))
    )
    assert {each.speed_mps for each in still.waypoints} == {None}
    north = next(each for each in windy.waypoints if each.speed_mps is not None)
    assert north.speed_mps == pytest.approx(6.0, abs=0.6)  # 15 through the air, 9 against it, a little across
    rises = np.diff([each.altitude_m for each in hilly.waypoints])
    across = np.hypot(*np.diff(np.array(hilly.places) * [111_154.0, 77_300.0], axis=0).T)
    speeds = np.array([12.0 if each.speed_mps is None else each.speed_mps for each in hilly.waypoints[1:]])
    assert (rises / across * speeds).max() <= 2.5 * 1.02
    assert (-rises / across * speeds).max() <= 1.5 * 1.02


def test_a_camera_keeps_the_flight_slow_enough(tmp_path):
    blurred = VEHICLE + "[camera]\nfov_deg = 60.0\npixels = 6000\nexposure_s = 0.00032\n"
    path = leg_mission(tmp_path, vehicle=blurred)
    path.write_text(path.read_text().replace("radius_m = 60.0", ""))
    score = there_and_back(path, ROUND)
    vehicle = score.mission.sorties[0].vehicle
    (plan,) = flights(score).plans
    assert plan.speed_mps == vehicle.cruise_mps(60.0) < 12.0


def test_a_drone_without_a_camera_does_not_see_with_another_ones(tmp_path):
    seeing = VEHICLE + "[camera]\nfov_deg = 60.0\npixels = 6000\nexposure_s = 0.00032\n"
    path = leg_mission(tmp_path, drones=2, vehicle=seeing)
    (tmp_path / "blind.toml").write_text(VEHICLE)
    blind = 'vehicle = "blind.toml"'.join(path.read_text().rsplit('vehicle = "vehicle.toml"', 1))
    path.write_text(blind.replace("radius_m = 60.0", ""))
    with pytest.raises(DataFormatError, match=r"searcher\[1\].vehicle: blind.toml without \[camera\] came beside one"):
        read_mission(path)
    path.write_text(blind)
    assert len(read_mission(path).problem.searchers) == 2


def test_batteries_are_changed_where_the_drone_starts(tmp_path):
    there = leg_mission(tmp_path, batteries=2, searcher='end = "farm"\n')
    with pytest.raises(DataFormatError, match=r"searcher\[0\].end: a place other than the start came beside 2 batt"):
        read_mission(there)
    assert len(read_mission(leg_mission(tmp_path, batteries=2, searcher='end = "launch"\n')).problem.searchers) == 2


def test_ground_that_nothing_joins_to_a_start_is_told_with_its_share(tmp_path):
    path = leg_mission(tmp_path)
    two = [box(0, 0, 900, 600)["coordinates"], box(1200, 0, 1500, 600)["coordinates"]]
    apart = {"type": "MultiPolygon", "coordinates": two}
    drawn(tmp_path / "area.geojson", ("search", apart), ("launch", LAUNCH))
    (note,) = [each for each in read_mission(path).notes if "no way leads" in each]
    assert float(note.split("%")[0]) == pytest.approx(25.0, abs=0.5)  # 300 m of 900 m + 300 m, no-fly ground counted
    path.write_text(path.read_text().replace("radius_m = 60.0", "radius_m = 400.0"))
    assert 5.0 < float(next(each for each in read_mission(path).notes if "no way leads" in each).split("%")[0]) < 20.0
    drawn(tmp_path / "area.geojson", ("search", AREA), ("launch", LAUNCH))
    assert not [each for each in read_mission(path).notes if "no way leads" in each]


# ---------------------------------------------------------------- how it ends


def test_a_landing_elsewhere_is_where_the_mission_puts_it(tmp_path):
    (plan,) = flights(there_and_back(leg_mission(tmp_path, searcher='end = "farm"\n'), ROUND)).plans
    assert plan.finish == "land"
    lon, lat = place(1300, 80)
    assert plan.landings == (plan.places[-1],)
    assert plan.places[-1] == pytest.approx((lat, lon), abs=1e-6)


def test_a_plan_without_an_end_flies_home_round_what_is_forbidden(tmp_path):
    path = leg_mission(tmp_path)
    text = path.read_text().replace('vehicle = "vehicle.toml"\nbatteries = 1\n', "speed_mps = 10.0\naccel_mps2 = 2.0\n")
    path.write_text(text + "[budget]\nseconds = 900\n")
    score = there_and_back(path, [[900, 500]])
    moves = score.mission.problem.searchers[0].moves
    assert moves.end is None
    actions = score.plan.actions[0][:2]
    told = flights(score_plan(score.mission, Plan((actions,))))
    (plan,) = told.plans
    line = metres_of(score.mission, plan)
    assert plan.finish == "return"
    assert moves.airspace.holds(line)
    assert any("does not count the" in note for note in told.notes)


def test_a_sortie_that_stays_on_the_ground_has_no_file_and_nobody_waits_for_it(tmp_path):
    score = there_and_back(leg_mission(tmp_path, 2, 2), ROUND)
    still = score.plan.actions[0][:1]
    idle = score_plan(score.mission, Plan((score.plan.actions[0], still, still, score.plan.actions[3])))
    made = export(idle, ["qgc", "dji", "kml", "geotiff"])
    assert [plan.stays for plan in made.flights.plans] == [False, True, True, False]
    assert sorted(made.files) == sorted(made.formats)
    assert [name for name in made.files if name.endswith(".plan")] == ["flight-0.plan", "flight-3.plan"]
    assert [plan.departs_s for plan in made.flights.plans][3] == pytest.approx(1260.0)
    assert sum("on the ground" in note for note in made.flights.notes) == 2
    nobody = score_plan(score.mission, Plan((still, still, still, still)))
    with pytest.raises(DataFormatError, match="a plan that goes nowhere came"):
        export(nobody, ["qgc"])


# ---------------------------------------------------------------- fences


def test_fences_are_the_drawn_polygons(tmp_path):
    score = there_and_back(leg_mission(tmp_path), ROUND)
    told = flights(score)
    frame = score.mission.area.frame
    shapes = [(shapely.Polygon(frame.metres(fence.corners)), fence.inclusion) for fence in told.plans[0].fences]
    (inside, stays), *others = shapes
    assert stays
    assert not any(inclusion for _, inclusion in others)
    assert inside.symmetric_difference(shapely.Polygon(score.mission.area.polygon.exterior)).area < 1.0
    out = shapely.union_all([shape for shape, _ in others])
    forbidden = shapely.union_all(
        [score.mission.area.no_fly, *map(shapely.Polygon, score.mission.area.polygon.interiors)]
    )
    assert out.symmetric_difference(forbidden).area < 1.0
    assert not told.notes or "fences" not in " ".join(told.notes)


# ---------------------------------------------------------------- maps and files


def test_maps_of_a_flight_along_legs_add_up(tmp_path):
    path = leg_mission(tmp_path)
    path.write_text(path.read_text().replace("radius_m = 60.0", "sweep_width_m = 50"))
    score = there_and_back(path, ROUND)
    layers = chances(score)
    assert (layers["poc-before"] * layers["pod"]).sum() == pytest.approx(score.evaluation.total, rel=1e-9)
    np.testing.assert_allclose(layers["pod"].ravel(), 1.0 - np.exp(-score.looks))
    assert layers["poc-after"].sum() == pytest.approx(1.0 - score.evaluation.total, rel=1e-9)


def test_a_plan_without_gaps_is_given_nothing_up_for_fewer_places(tmp_path):
    mission = read_mission(leg_mission(tmp_path / "mission"))
    alone = solve(mission.problem, make_planner("no-gap")).best
    planned = plan_mission(mission, "no-gap", seconds=60.0)
    assert planned.score.evaluation.total == pytest.approx(alone.value, rel=1e-8)
    assert sum(map(len, planned.score.plan.actions)) == sum(map(len, alone.plan.actions))
