import pytest

from sooner.missions import read_mission
from sooner.missions.over_waypoints import read_street_mission
from sooner.scenarios import AREA_SCENARIOS, SCENARIOS, STREET_SCENARIOS


@pytest.mark.parametrize("name", [*SCENARIOS, *AREA_SCENARIOS])
def test_a_scenario_is_written_ready_to_plan(sooner, tmp_path, name):
    ended = sooner("scenario", name, "--out", tmp_path / "out")
    assert ended.status == 0
    assert ended.out == f"mission  {tmp_path / 'out' / 'mission.toml'}\n"
    assert read_mission(tmp_path / "out" / "mission.toml").problem.searchers[0].budget >= 100


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_search_over_streets_is_written_ready_to_fly(sooner, tmp_path, seed):
    assert sooner("scenario", "street-grid", "--out", tmp_path, "--seed", seed).status == 0
    scene = read_street_mission(tmp_path / "mission.toml").scene
    assert (scene.seconds, len(scene.agents), scene.world.n_targets) == (240, 4, 1)


def test_scenarios_are_listed(sooner):
    listed = [line.split()[0] for line in sooner("scenario").out.splitlines()]
    assert listed == [*SCENARIOS, *AREA_SCENARIOS, *STREET_SCENARIOS]


def test_an_unknown_scenario_is_refused(sooner, tmp_path):
    ended = sooner("scenario", "moon", "--out", tmp_path / "out")
    assert ended.status == 2
    assert "'moon' came; expected one of many-hills" in ended.err
    assert not (tmp_path / "out").exists()


def test_an_edited_mission_is_not_replaced(sooner, tmp_path):
    sooner("scenario", "bimodal", "--out", tmp_path)
    assert sooner("scenario", "bimodal", "--out", tmp_path, "--seed", "2").status == 0
    (tmp_path / "mission.toml").write_text("mine")
    ended = sooner("scenario", "bimodal", "--out", tmp_path)
    assert ended.status == 2
    assert "mission.toml" in ended.err
    assert (tmp_path / "mission.toml").read_text() == "mine"
