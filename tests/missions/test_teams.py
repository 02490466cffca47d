"""Missions of several drones: unlike ones, ones that plan for themselves, and places told by coordinates."""

import json

import numpy as np
import pytest

from sooner.errors import DataFormatError
from sooner.missions import plan_mission, read_mission, score_plan
from sooner.missions.planning import plan_file, read_plan_file
from tests.io.test_rasters import geotiff
from tests.missions.test_over_regions import ground  # noqa: F401  a fixture

pytestmark = pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # within rasterio

SECOND = """
[[searcher]]
start = [20, 37]
moves = "regions"
speed_mps = SPEED
accel_mps2 = 4.0
"""


def with_second(path, speed=5.0, more=""):
    path.write_text(path.read_text().replace("[budget]", SECOND.replace("SPEED", str(speed)) + "[budget]") + more)
    return path


def test_unlike_drones_each_fly_at_their_own_speed_and_share_what_is_learnt(ground, tmp_path):  # noqa: F811
    alike = '[regions]\ncut = "plain"\nspacing_m = 8.0\n'
    slow = read_mission(ground(more=alike)).problem.searcher.moves.graph
    mission = read_mission(with_second(ground(more=alike), 10.0))
    one, two = (searcher.moves for searcher in mission.problem.searchers)
    searches = slice(slow.n_regions)
    np.testing.assert_allclose(one.graph.seconds[searches], slow.seconds[searches])
    assert (two.graph.seconds[searches] < slow.seconds[searches]).all()
    np.testing.assert_array_equal(one.atoms.of_cell, two.atoms.of_cell)
    planned = plan_mission(mission, "greedy", seconds=5.0)
    best, score = planned.solution.best, planned.score
    assert 0 < best.value <= best.bound < np.inf
    assert mission.sight.worth(score.looks).sum() == pytest.approx(best.value, rel=1e-9)
    (tmp_path / "plan.csv").write_bytes(plan_file(mission, score.plan))
    assert score_plan(mission, read_plan_file(mission, tmp_path / "plan.csv")).evaluation.value == best.value


def test_drones_that_fly_alike_share_a_graph(ground):  # noqa: F811
    path = ground()
    path.write_text(path.read_text().replace("accel_mps2 = 2.0", "accel_mps2 = 4.0"))
    one, two = (searcher.moves for searcher in read_mission(with_second(path)).problem.searchers)
    assert one.graph is two.graph


def test_drones_with_links_plan_for_themselves_and_tell_what_they_heard(ground):  # noqa: F811
    central = plan_mission(read_mission(with_second(ground())), "greedy", seconds=5.0)
    assert central.result(None)["links"] is None
    perfect = plan_mission(read_mission(with_second(ground(), more="[links]\n")), "greedy", seconds=5.0)
    assert perfect.solution.best.plan == central.solution.best.plan
    told = json.loads(json.dumps(perfect.result(None), allow_nan=False))["links"]
    assert (told["sent"], told["lost"], told["knows"]) == (8, 0, [[0, 1], [0, 1]])
    lost = plan_mission(read_mission(with_second(ground(), more="[links]\nloss = 1.0")), "greedy", seconds=5.0)
    assert lost.result(None)["links"]["knows"] == [[0], [1]]
    assert lost.solution.best.value <= perfect.solution.best.value
    far = plan_mission(read_mission(with_second(ground(), more="[links]\nrange_m = 10")), "greedy", seconds=5.0)
    assert far.result(None)["links"]["messages"] == []


def test_links_before_take_off_know_no_delay(ground):  # noqa: F811
    with pytest.raises(DataFormatError, match=r"links\.delay_s: it came; expected it left out"):
        read_mission(with_second(ground(), more="[links]\ndelay_s = 2\n"))


def test_links_of_one_drone_are_refused(ground):  # noqa: F811
    with pytest.raises(DataFormatError, match=r"links: it came, and one \[\[searcher\]\]"):
        read_mission(ground(more="[links]\nloss = 0.1"))


def placed(tmp_path, start, obstacle=None):
    from rasterio.warp import transform

    row, col = start
    (lon,), (lat,) = transform("EPSG:32632", "EPSG:4326", [500_000 + 20 * (col + 0.5)], [5_100_000 - 20 * (row + 0.5)])
    geotiff(tmp_path / "poc.tif", np.ones((6, 8), np.float32))
    rock = np.zeros((6, 8), np.uint8)
    rock[obstacle or (0, 0)] = 1
    geotiff(tmp_path / "rock.tif", rock)
    (tmp_path / "mission.toml").write_text(
        '[area]\npoc = "poc.tif"\nobstacles = "rock.tif"\n[sensor]\nglimpse = 0.5\n'
        f"[[searcher]]\nstart = {{ lat = {lat!r}, lon = {lon!r} }}\nend = [2, 2]\n[budget]\nsteps = 8\n"
    )
    return tmp_path / "mission.toml"


def test_a_start_may_be_told_by_latitude_and_longitude(tmp_path):
    assert read_mission(placed(tmp_path, (4, 2))).problem.searcher.start == (4, 2)


@pytest.mark.parametrize(
    ("start", "obstacle", "told"),
    [
        ((4, 9), None, r"lat 46\.\d+, lon 9\.\d+, which is \[4, 9\], came; expected a cell of the map"),
        ((4, 3), (4, 3), r"which is \[4, 3\], came, and an obstacle stands there"),
    ],
)
def test_a_place_that_is_no_cell_to_start_from_is_refused_with_the_cell(tmp_path, start, obstacle, told):
    with pytest.raises(DataFormatError, match=told):
        read_mission(placed(tmp_path, start, obstacle))


def test_half_a_place_is_refused(tmp_path):
    path = placed(tmp_path, (4, 2))
    path.write_text(path.read_text().partition("lat")[0] + "lat = 46.0 }\n[budget]\nsteps = 8\n")
    with pytest.raises(DataFormatError, match=r"searcher\[0\]\.start\.lon: nothing came"):
        read_mission(path)


def test_a_target_over_regions_is_reached_sooner_than_by_the_most_by_the_end(ground):  # noqa: F811
    more = '\n[regions]\ncut = "aware"\n'
    most = plan_mission(read_mission(ground("belief", "detection", more="early = false" + more)), seconds=3.0)
    total = most.score.evaluation.total
    target = round(total / 3, 3)
    planned = plan_mission(
        read_mission(ground("belief", "detection", more=f"detection_target = {target}{more}")), seconds=3.0
    )
    told = planned.result(None)
    assert told["objective"] == f"detection {target:g} soonest"
    assert told["value"] == -planned.score.evaluation.time_to(target)
    assert told["value"] >= -most.score.evaluation.time_to(target)
    assert told["value"] <= planned.solution.best.bound <= 0  # told as null where nothing above 0 is proved


def test_a_team_is_asked_for_a_target_over_regions_but_not_with_links(ground):  # noqa: F811
    path = with_second(ground("belief", "detection", more="detection_target = 0.1"))
    best = plan_mission(read_mission(path), "greedy", seconds=3.0).solution.best
    assert -240 < best.value <= best.bound <= 0
    path = with_second(ground("belief", "detection", more="detection_target = 0.1"), more="\n[links]\nloss = 0.1\n")
    with pytest.raises(DataFormatError, match=r"links: it came beside objective\.detection_target"):
        read_mission(path)
