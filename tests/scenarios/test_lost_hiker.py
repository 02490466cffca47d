import numpy as np
import pytest
import shapely

from sooner.missions import read_mission
from sooner.scenarios import AREA_SCENARIOS, make_area_scenario


def written(folder, seed):
    for name, content in make_area_scenario("lost-hiker", seed).files().items():
        (folder / name).write_bytes(content)
    return folder / "mission.toml"


@pytest.mark.parametrize("name", AREA_SCENARIOS)
def test_the_same_seed_makes_the_same_bytes(name):
    assert make_area_scenario(name, 3).files() == make_area_scenario(name, 3).files()
    assert make_area_scenario(name, 3).files() != make_area_scenario(name, 4).files()


@pytest.mark.parametrize("seed", range(20))
def test_the_area_is_as_command_posts_have_it(seed):
    hiker = make_area_scenario("lost-hiker", seed)
    outline, lake, flown = map(shapely.Polygon, (hiker.outline, hiker.lake, hiker.flight_area))
    assert all(each.is_valid for each in (outline, lake, flown))
    assert outline.contains(lake)
    assert flown.contains(outline)
    assert outline.area < 0.99 * outline.convex_hull.area
    launch, last_seen, mast = map(shapely.Point, (hiker.launch, hiker.last_seen, hiker.mast))
    assert outline.distance(launch) > 150.0
    assert flown.contains(launch)
    zones = shapely.union_all([shapely.Polygon(hiker.village), mast.buffer(hiker.mast_m)])
    assert not zones.buffer(50.0).intersects(shapely.union_all([launch, last_seen]))
    assert outline.difference(lake).contains(last_seen)
    assert set(np.unique(hiker.cover)) == {1, 2, 3, 4}


@pytest.mark.parametrize("seed", [0, 13])
def test_it_is_flown_from_the_car_park_in_four_sorties(tmp_path, seed):
    mission = read_mission(written(tmp_path, seed))
    assert [(each.drone, each.battery) for each in mission.sorties] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert mission.belief is not None
    assert mission.belief.outside < 0.3
    moves = mission.problem.searchers[0].moves
    there = mission.area.points["last seen"]
    there_and_back = np.concatenate([moves.airspace.way(moves.home, there), moves.airspace.way(there, moves.home)])
    assert moves.seconds(there_and_back) < 0.5 * mission.problem.searchers[0].budget
