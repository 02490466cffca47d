"""PyVRP's tours become legal flights."""

import numpy as np
import pytest

from sooner.belief import Belief
from sooner.experiments.orienteering import Orienteering, fly
from sooner.grid import Grid
from sooner.planners import solve
from sooner.problem import CellMoves, Plan, Searcher, SearchProblem, detection_gains, evaluate


def hills(steps, end=None, obstacles=None, kind="copter"):
    rows, cols = np.mgrid[0:9, 0:9]
    weights = np.exp(-((rows - 1) ** 2 + (cols - 7) ** 2) / 3) + 2 * np.exp(-((rows - 7) ** 2 + (cols - 6) ** 2) / 3)
    grid = Grid((9, 9), obstacles=obstacles)
    gains = detection_gains(Belief.from_weights(weights), 0.7)
    return SearchProblem(grid, gains, (Searcher((4, 0), steps, end, CellMoves(kind)),))


@pytest.fixture
def wall():
    obstacles = np.zeros((9, 9), bool)
    obstacles[2:7, 4] = True
    return obstacles


@pytest.mark.parametrize("end", [None, (0, 0)])
@pytest.mark.parametrize("blocked", [False, True])
def test_the_plan_is_legal_and_beats_flying_nowhere(end, blocked, wall):
    pytest.importorskip("pyvrp")
    problem = hills(24, end, wall if blocked else None)
    best = solve(problem, Orienteering(tour_seconds=0.3)).best
    assert best.value == evaluate(problem, best.plan).value
    assert best.value > 0.4 * problem.teleport.value


def test_links_are_shortest_and_pay_most():
    problem = hills(8)
    path = fly(problem, [problem.grid.index((8, 4))])
    assert len(path) == 9
    link = {tuple(problem.grid.cell(cell)) for cell in path}
    assert {(8, 4), (7, 3)} <= link or {(8, 4), (7, 4)} <= link  # in from the hill's side, not along the edge


def test_what_does_not_fit_in_the_battery_is_left_out():
    problem = hills(6)
    far, near = problem.grid.index((8, 8)), problem.grid.index((5, 2))
    path = fly(problem, [far, near])
    assert near in path
    assert evaluate(problem, Plan.of(path)).value > 0


def test_a_fixed_wing_is_refused_with_a_sentence():
    assert "shortest ways" in Orienteering().handles(hills(6, kind="fixed_wing"))
