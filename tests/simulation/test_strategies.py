"""Strategies without learning: waypoints within the ground, lanes that cover it, and names in files."""

import numpy as np
import pytest

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation import Scene, World, simulate
from sooner.simulation.ground import area
from sooner.simulation.strategies import STRATEGIES, TUNED_LAWNMOWER, Lawnmower, RandomWaypoints, make_strategy
from sooner.simulation.strategies.lawnmower import rectangles
from sooner.simulation.strategies.registry import settings_of
from tests.simulation.streets import blocks

GRID = Grid((40, 40), "square8", 5.0)
SCENE = Scene(World(blocks(40)))


def test_random_waypoints_lie_on_the_ground_and_change_when_they_are_reached():
    flown = simulate(SCENE, RandomWaypoints(), 2)
    low, high = area(SCENE.grid)
    waypoints = np.array([[route[-1] for route in plan] for plan in flown.plans])
    assert ((waypoints >= low) & (waypoints <= high)).all()
    replans = flown.places_m[:-1:5]
    kept = (waypoints[1:] == waypoints[:-1]).all(axis=-1)
    near = np.linalg.norm(replans[1:] - waypoints[:-1], axis=-1) <= 12.5
    np.testing.assert_array_equal(kept, ~near)


@pytest.mark.parametrize("n_agents", [1, 2, 3, 4, 6, 7])
def test_rectangles_are_equal_and_cover_the_ground(n_agents):
    low, high = area(GRID)
    parts = rectangles(GRID, n_agents)
    areas = [np.prod(top - bottom) for bottom, top in parts]
    np.testing.assert_allclose(areas, np.prod(high - low) / n_agents)
    assert min(bottom.min() for bottom, _ in parts) == low.min()


def test_the_papers_lawnmower_has_five_lanes_of_twenty_metres():
    route = simulate(SCENE, Lawnmower(), 0).plans[0][0]
    assert route[:, 0].tolist() == [7.5, 7.5, 27.5, 27.5, 47.5, 47.5, 67.5, 67.5, 87.5, 87.5]
    assert route[:, 1].tolist() == [0.0, 95.0, 95.0, 0.0, 0.0, 95.0, 95.0, 0.0, 0.0, 95.0]


def test_the_tuned_lawnmower_has_four_of_twenty_five():
    route = simulate(SCENE, TUNED_LAWNMOWER, 0).plans[0][3]
    assert np.unique(route[:, 0]).tolist() == [110.0, 135.0, 160.0, 185.0]
    assert np.unique(route[:, 1]).tolist() == [110.0, 185.0]


def test_the_lawnmower_starts_in_the_corners():
    starts = simulate(SCENE, Lawnmower(), 0).places_m[0]
    assert starts.tolist() == [[-2.5, -2.5], [197.5, -2.5], [-2.5, 197.5], [197.5, 197.5]]


@pytest.mark.parametrize(("strategy", "share"), [(Lawnmower(), 0.99), (TUNED_LAWNMOWER, 0.92)])
def test_lanes_bring_every_cell_into_view_but_where_corners_are_cut(strategy, share):
    flown = simulate(SCENE, strategy, 0)
    apart = np.linalg.norm(SCENE.grid.centres_m[:, None] - flown.places_m.reshape(-1, 2)[None], axis=-1)
    assert (apart.min(axis=1) <= 12.5).mean() > share


def test_to_and_fro_goes_on_after_the_last_lane():
    hover, back = (simulate(SCENE, Lawnmower(1.0, 0.5, 0.5, end), 0) for end in ("hover", "back"))
    np.testing.assert_array_equal(hover.places_m[:120], back.places_m[:120])
    assert np.ptp(hover.places_m[-30:, 0], axis=0).max() < 0.1
    assert np.ptp(back.places_m[-30:, 0], axis=0).max() > 20.0


@pytest.mark.parametrize("bad", [{"reach": 0.0}, {"capture": -1.0}, {"inset": 0.7}, {"afterwards": "fly"}])
def test_impossible_lawnmowers_are_refused(bad):
    with pytest.raises(InvalidProblemError, match="came"):
        Lawnmower(**bad)


@pytest.mark.parametrize("name", STRATEGIES)
def test_every_strategy_in_the_list_can_be_made_and_told(name):
    strategy = make_strategy(name)
    known, settings = settings_of(strategy)
    assert make_strategy(known, **settings) == strategy


@pytest.mark.parametrize("name", STRATEGIES)
def test_every_strategy_in_the_list_flies_and_stays_near_the_ground(name):
    flown = simulate(SCENE, make_strategy(name), 1)
    low, high = area(SCENE.grid)
    assert (flown.places_m > low - 5.0).all()
    assert (flown.places_m < high + 5.0).all()
    assert flown.nodes_curve[-1] > 0.3


@pytest.mark.parametrize(("name", "settings"), [("x", {}), ("random", {"x": 1}), ("lawnmower", {"reach": "x"})])
def test_unknown_strategies_and_settings_are_refused(name, settings):
    with pytest.raises(InvalidProblemError, match="came"):
        make_strategy(name, **settings)
