"""What a track looked at is what the judge says of a plan that flies the same line."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.io.tracks import Track
from sooner.missions import read_mission, score_plan
from sooner.missions.chances import pod_by_cell
from sooner.missions.debrief_looks import LEAST, crossed_cells, flown
from sooner.missions.flight_plans import flights
from sooner.motion.pace import Pace
from sooner.problem import Plan, Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, place_numbers
from sooner.sensors.swath import Swath
from tests.georeferenced import DOLOMITES, greedily, hills, located, over_cells, over_regions, rocks

HOME = "[[searcher]]\nstart = [3, 3]\nspeed_mps = 12.0\n"
FLIGHT = over_regions("start = [3, 3]\nend = [3, 3]")


def along(cells, gaps=(), ground=DOLOMITES) -> Track:
    """A track through places, (n, 2) rows and columns as fractions."""
    lat, lon = ground.places(cells).T
    return Track("", "flown.gpx", lat, lon, gaps=np.array(gaps, np.int64))


@pytest.fixture(scope="module")
def over(tmp_path_factory):
    def make(text, **rasters):
        return read_mission(located(tmp_path_factory.mktemp("over"), text, 0.5 * hills(), **rasters))

    return make


def sampled_visits(grid, line, step=1e-4):
    """Cells that a line visits for long enough, by following it in small steps."""
    found = []
    for begin, end in pairwise(line):
        count = max(int(np.hypot(*(end - begin)) / (step * grid.cell_m)), 1)
        found.append(begin + (np.arange(count) + 0.5)[:, None] / count * (end - begin))
    points = np.concatenate(found) / grid.cell_m
    rows, cols = grid.shape[0] - 1 - np.rint(points[:, 1]).astype(int), np.rint(points[:, 0]).astype(int)
    inside = (rows >= 0) & (rows < grid.shape[0]) & (cols >= 0) & (cols < grid.shape[1])
    cells = np.where(inside, rows * grid.shape[1] + cols, -1)
    begins = np.flatnonzero(np.append(True, cells[1:] != cells[:-1]))
    lengths = np.diff(np.append(begins, len(cells))) * step
    return cells[begins], lengths


PLACES = st.lists(st.tuples(st.floats(-30, 90), st.floats(-30, 60)), min_size=2, max_size=6)


@settings(max_examples=60)
@given(PLACES)
def test_cells_are_crossed_as_small_steps_cross_them(places):
    grid, line = Grid((5, 7), cell_m=10.0), np.array(places)
    visited, lengths = sampled_visits(grid, line)
    if (np.abs(lengths - LEAST) < 2e-3).any() or np.hypot(*np.diff(line, axis=0).T).min() < 0.1:
        return  # too near to call for who takes small steps
    visited = visited[lengths >= LEAST]
    visited = visited[np.append(True, visited[1:] != visited[:-1])] if len(visited) else visited
    np.testing.assert_array_equal(crossed_cells(grid, line), visited[visited >= 0])


@settings(max_examples=40)
@given(st.lists(st.sampled_from([(0, 1), (0, -1), (1, 0), (-1, 0)]), min_size=1, max_size=30))
def test_a_plan_over_cells_flown_to_the_letter_is_worth_what_the_judge_says(over, steps):
    mission = over(over_cells(HOME, sensor="glimpse = 0.6\ncorrelation = 0.3"))
    path = [(3, 3)]
    for down, right in steps:
        there = (path[-1][0] + down, path[-1][1] + right)
        path += [there] if 0 <= there[0] < 12 and 0 <= there[1] < 16 else []
    if len(path) < 2:
        return
    score = score_plan(mission, Plan.of([row * 16 + col for row, col in path]))
    found = flown(mission, DOLOMITES, along(path))
    np.testing.assert_array_equal(found.looks, score.looks)
    assert np.ravel(mission.sight.theta) @ pod_by_cell(mission, found.looks) == pytest.approx(score.evaluation.total)


@pytest.mark.parametrize("text", [over_cells(HOME), FLIGHT], ids=["cells", "regions"])
def test_to_and_fro_is_looked_at_as_often_as_it_is_flown(over, text):
    ways = np.concatenate([np.linspace([5, 2], [5, 13], 40)[:: (-1) ** way] for way in range(3)])
    found = flown(over(text), DOLOMITES, along(ways))
    assert found.looks[5 * 16 + 7] == 3
    assert found.length_m == pytest.approx(3 * 11 * 24.0)


def test_a_diagonal_looks_at_no_cell_whose_corner_it_clips(over):
    found = flown(over(over_cells(HOME)), DOLOMITES, along([[3, 3], [6.001, 6.0]]))
    assert np.flatnonzero(found.looks).tolist() == [3 * 17, 4 * 17, 5 * 17, 6 * 17]


def test_jitter_and_standing_still_are_no_looks(over):
    mission, rng = over(over_cells(HOME)), np.random.default_rng(3)
    straight = np.column_stack([np.full(300, 3.5), np.linspace(2, 12, 300)])  # along the border of two rows
    still = np.tile([3.5, 12.0], (2000, 1))
    noise = rng.normal(0.0, 0.15 / 24.0, (2300, 2))
    found = flown(mission, DOLOMITES, along(np.concatenate([straight, still]) + noise))
    assert found.looks.max() == 1
    assert found.length_m == pytest.approx(240.0, rel=0.02)


@pytest.mark.parametrize("text", [over_cells(HOME), FLIGHT], ids=["cells", "regions"])
def test_who_stands_with_gaps_in_the_log_does_not_look_again_and_again(over, text):
    found = flown(over(text), DOLOMITES, along(np.tile([[4.0, 4.0], [4.0, 4.1]], (50, 1)), gaps=range(99)))
    assert not found.looks.any()


def test_what_lies_in_a_gap_is_not_looked_at(over):
    mission = over(over_cells(HOME))
    found = flown(mission, DOLOMITES, along([[3, 1], [3, 4], [3, 9], [3, 12]], gaps=[1]))
    assert np.flatnonzero(found.looks).tolist() == [3 * 16 + col for col in (1, 2, 3, 4, 9, 10, 11, 12)]


def test_nobody_looks_at_obstacles(over):
    mission = over(over_cells(HOME, area='obstacles = "rocks.tif"'), rocks=rocks())
    found = flown(mission, DOLOMITES, along([[5, 1], [5, 12]]))
    assert np.flatnonzero(found.looks).tolist() == [5 * 16 + col for col in (1, 2, 3, 4, 8, 9, 10, 11, 12)]


def test_a_plan_over_regions_flown_to_the_letter_is_worth_no_less_than_the_judge_says(over):
    mission = over(FLIGHT)
    score = greedily(mission)
    plan = flights(score).plans[0]
    found = flown(mission, DOLOMITES, along(DOLOMITES.cells([plan.home, *plan.places])))
    theta = np.ravel(mission.sight.theta)
    credited, truly = (theta @ pod_by_cell(mission, looks) for looks in (score.looks, found.looks))
    assert credited <= truly + 1e-9
    assert truly == pytest.approx(credited, rel=0.1)


def leg_mission(mission, swath):
    """The same map, flown along legs."""
    grid = Grid(mission.problem.grid.shape, "square8", 24.0)
    moves = LegMoves(Airspace.of_cells(np.ones(grid.shape, bool), 24.0), Pace(12.0, 2.0), swath(grid), (72.0, 192.0))
    poc = mission.sight.theta
    problem = SearchProblem(grid, effort_gains(poc), (Searcher((3, 3), 600.0, moves=moves),))
    return replace(mission, problem=problem)


@pytest.mark.parametrize("law", ["even", "cube", "seen"])
def test_legs_flown_to_the_letter_are_worth_what_the_judge_says(over, law):
    def swath(grid):
        return Swath.seen(grid, 40.0) if law == "seen" else Swath.of_width(grid, 60.0, law=law)

    mission = leg_mission(over(over_cells(HOME)), swath)
    places = np.array([[72.0, 192.0], [300.0, 200.0], [310.0, 60.0], [72.0, 100.0]])
    evaluation = evaluate(mission.problem, Plan((place_numbers(places),)))
    found = flown(mission, DOLOMITES, along(np.column_stack([11 - places[:, 1] / 24, places[:, 0] / 24])))
    pod = pod_by_cell(mission, found.looks)
    np.testing.assert_allclose(pod, pod_by_cell(mission, evaluation.looks), atol=1e-4)
    assert np.ravel(mission.sight.theta) @ pod == pytest.approx(evaluation.total, abs=1e-4)
