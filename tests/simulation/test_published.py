"""A slice of Table II of [Wolek2020] on its authors' maps: without learning, by both detectors."""

import numpy as np
import pytest

from sooner.io import read_street_map
from sooner.scenarios import street_grid
from sooner.simulation import HALF_CELL, Estimator, Scene, World, simulate
from sooner.simulation.strategies import make_strategy

MAPS = ("authors_map1_randalls_island", "authors_map2_silver_spring", "authors_map3_nyc")
TRIALS = 25


@pytest.fixture(scope="module")
def worlds(occupancy_graphs):
    return [World(read_street_map(occupancy_graphs / f"{name}.graph.json").graph) for name in MAPS]


def flown(worlds, name, estimator, offset=(0.0, 0.0)):
    scenes = [Scene(world, estimator=estimator, target_offset=offset) for world in worlds]
    return [simulate(scene, make_strategy(name), seed) for scene in scenes for seed in range(TRIALS)]


@pytest.mark.slow
@pytest.mark.parametrize("offset", [(0.0, 0.0), HALF_CELL])
@pytest.mark.parametrize(
    ("name", "detector", "published"),
    [("random", "cbht", 0.309), ("lawnmower", "cbht", 0.366), ("random", "lrdt", 0.487), ("lawnmower", "lrdt", 0.535)],
)
def test_strategies_that_do_not_learn_come_near_the_published_table(worlds, name, detector, published, offset):
    scores = [each.e for each in flown(worlds, name, Estimator(detector), offset)]
    error = np.std(scores, ddof=1) / np.sqrt(len(scores))
    assert np.mean(scores) == pytest.approx(published, abs=0.03 + 2.5 * error)


@pytest.mark.slow
def test_cases_stand_in_the_published_order(worlds):
    cases = [("random", "cbht"), ("lawnmower", "cbht"), ("random", "lrdt"), ("lawnmower", "lrdt")]
    means = [np.mean([each.e for each in flown(worlds, name, Estimator(detector))]) for name, detector in cases]
    means.append(np.mean([each.e for each in flown(worlds, "tuned_lawnmower", Estimator())]))
    assert means == sorted(means)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["gridiron", "suburb", "park"])
def test_tracking_beats_testing_cells_on_generated_streets(kind):
    worlds = [World(street_grid(kind, seed)) for seed in range(2)]
    tested, tracked = (
        np.mean([each.e_targets for each in flown(worlds, "tuned_lawnmower", Estimator(detector))])
        for detector in ("cbht", "lrdt")
    )
    assert tracked > 1.5 * tested
