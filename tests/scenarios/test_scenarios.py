import numpy as np
import pytest

from sooner.bounds import bounds
from sooner.missions import read_mission
from sooner.planners import solve
from sooner.planners.registry import make_planner
from sooner.problem.regions import RegionMoves
from sooner.scenarios import SCENARIOS, make_scenario


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_same_seed_makes_the_same_search(name):
    assert make_scenario(name, 3).files() == make_scenario(name, 3).files()
    assert make_scenario(name, 3).files() != make_scenario(name, 4).files()


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_scenario_can_be_flown(name, seed):
    problem = make_scenario(name, seed).problem()
    assert 0 < solve(problem, make_planner("greedy"), seed=seed).best.value < next(iter(bounds(problem))).value


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_files_say_what_the_problem_says(name, tmp_path):
    scenario = make_scenario(name)
    for file, content in scenario.files().items():
        (tmp_path / file).write_bytes(content)
    read, made = read_mission(tmp_path / "mission.toml").problem, scenario.as_written().problem()
    np.testing.assert_allclose(read.gains.table, made.gains.table, rtol=1e-12)
    np.testing.assert_array_equal(read.grid.neighbours, made.grid.neighbours)
    for one, other in zip(read.searchers, made.searchers, strict=True):
        assert (one.start, one.end, one.budget) == (other.start, other.end, other.budget)
        if isinstance(one.moves, RegionMoves):
            np.testing.assert_array_equal(one.moves.graph.seconds, other.moves.graph.seconds)
        else:
            assert one.moves == other.moves
