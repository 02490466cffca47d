import numpy as np
import pytest

from sooner.missions import read_mission
from sooner.planners import Greedy, solve
from sooner.scenarios import SCENARIOS, make_scenario


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_same_seed_makes_the_same_search(name):
    assert make_scenario(name, 3).files() == make_scenario(name, 3).files()
    assert make_scenario(name, 3).files() != make_scenario(name, 4).files()


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_scenario_can_be_flown(name, seed):
    problem = make_scenario(name, seed).problem()
    assert 0 < solve(problem, Greedy(), seed=seed).best.value < problem.teleport.value


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_files_say_what_the_problem_says(name, tmp_path):
    scenario = make_scenario(name)
    for file, content in scenario.files().items():
        (tmp_path / file).write_bytes(content)
    read, made = read_mission(tmp_path / "mission.toml").problem, scenario.as_written().problem()
    np.testing.assert_array_equal(read.gains.table, made.gains.table)
    np.testing.assert_array_equal(read.grid.neighbours, made.grid.neighbours)
    assert read.searchers == made.searchers
