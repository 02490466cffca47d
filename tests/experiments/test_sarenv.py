"""SAREnv's measure, read again cell by cell, and the ground that ways truly sweep."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import DataFormatError, InvalidProblemError
from sooner.experiments.sarenv import Sarenv, load_sarenv, scores, swept_bound, swept_shares

SOUTH_WEST = (500_015.0, 5_000_015.0)


def ground(seed=0, shape=(14, 17), cell_m=30.0, radius_m=33.137):
    rng = np.random.default_rng(seed)
    height, width = shape
    victims = rng.uniform(0, 1, (40, 2)) * (width * cell_m, height * cell_m)
    centre = ((width - 1) * cell_m / 2, (height - 1) * cell_m / 2)
    return Sarenv("made up", rng.exponential(1e-3, shape), cell_m, radius_m, centre, victims)


def some_ways(seed, drones=2, places=5):
    rng = np.random.default_rng(seed)
    return [rng.uniform(-60, 560, (places, 2)) for _ in range(drones)]


def read_again(scenario, ways):
    """Likelihood and time-discounted score, as SAREnv's evaluator describes them, one cell at a time."""
    height, width = scenario.heat.shape
    seen, discounted, flown = set(), 0.0, 0.0
    for way in ways:
        legs = np.hypot(*np.diff(way, axis=0).T)
        passed, length = np.concatenate([[0.0], np.cumsum(legs)]), legs.sum()
        for along in np.linspace(0, length, int(np.ceil(length / 15)) + 1):
            leg = min(np.searchsorted(passed, along, side="right"), len(legs)) - 1
            at = way[leg] + (way[leg + 1] - way[leg]) * (along - passed[leg]) / legs[leg]
            for row in range(height):
                for col in range(width):
                    centre = col * scenario.cell_m, (height - 1 - row) * scenario.cell_m
                    if np.hypot(*(centre - at)) <= scenario.radius_m:
                        seen.add((row, col))
                        discounted += scenario.heat[row, col] * 0.999 ** (flown + along)
        flown += length
    return sum(scenario.heat[cell] for cell in seen), discounted


@pytest.mark.parametrize("seed", range(3))
def test_the_measure_is_that_of_cell_by_cell(seed):
    scenario, ways = ground(seed), some_ways(seed)
    found = scores(scenario, ways)
    assert (found.likelihood, found.time_discounted) == pytest.approx(read_again(scenario, ways), rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_the_swept_ground_is_that_of_a_fine_raster(seed):
    scenario, ways = ground(seed), some_ways(seed)
    height, width = scenario.heat.shape
    fine = 20  # points along the side of a cell, 1.5 m apart
    x = (np.arange(width * fine) + 0.5) / fine * scenario.cell_m - scenario.cell_m / 2
    y = (np.arange(height * fine) + 0.5) / fine * scenario.cell_m - scenario.cell_m / 2
    points = np.stack(np.meshgrid(x, y), axis=-1)
    near = np.zeros(points.shape[:2], bool)
    for way in ways:
        for a, b in pairwise(way):
            along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            near |= np.hypot(*np.moveaxis(points - a - along[..., None] * (b - a), -1, 0)) <= scenario.radius_m
    coarse = near.reshape(height, fine, width, fine).mean(axis=(1, 3))[::-1]
    shares = swept_shares(scenario, ways)
    assert np.abs(shares - coarse).max() < 3 / fine  # a border through a cell, known to a point's width
    assert scores(scenario, ways).swept == pytest.approx((coarse * scenario.heat).sum(), rel=2e-3)


def test_a_straight_way_sweeps_a_stadium_and_finds_who_is_in_it():
    scenario = Sarenv(
        "flat", np.full((20, 20), 1e-3), 30.0, 33.137, (0, 0), np.array([[300, 330], [300, 340], [90, 300]])
    )
    found = scores(scenario, [np.array([[100.0, 300.0], [400.0, 300.0]])])
    area = 2 * 33.137 * 300 + np.pi * 33.137**2
    assert found.area_km2 * 1e6 == pytest.approx(area, rel=1e-4)
    assert found.swept == pytest.approx(area / 900 * 1e-3, rel=1e-4)
    assert found.victims_percent == pytest.approx(200 / 3)
    assert found.length_km == pytest.approx(0.3)


def test_the_later_drones_are_discounted_by_what_others_flew():
    scenario, ways = ground(4), some_ways(4)
    one, other = (scores(scenario, [way]) for way in ways)
    both = scores(scenario, ways)
    assert both.time_discounted == pytest.approx(
        one.time_discounted + 0.999 ** (1000 * one.length_km) * other.time_discounted
    )
    assert both.likelihood <= one.likelihood + other.likelihood


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), places=st.integers(2, 8), drones=st.integers(1, 3))
def test_no_ways_sweep_more_than_the_bound(seed, places, drones):
    scenario, ways = ground(seed), some_ways(seed, drones, places)
    found = scores(scenario, ways)
    assert found.swept <= swept_bound(scenario, 1000 * found.length_km, drones) * (1 + 1e-9)
    assert found.area_km2 * 1e6 <= 2 * 33.137 * 1000 * found.length_km + drones * np.pi * 33.137**2


def written(folder, heat, **other):
    height, width = heat.shape
    west, south = SOUTH_WEST[0] - 15, SOUTH_WEST[1] - 15
    told = {
        "name": "made_up",
        "crs": "EPSG:32632",
        "center_xy": [west + width * 15, south + height * 15],
        "detection_radius_m": 33.137,
        "crop": {"medium": {"bounds_xy": [west, south, west + 30 * width, south + 30 * height]}},
        "baselines_medium": [{"algorithm": "Spiral"}],
    } | other
    (folder / "made_up.json").write_text(json.dumps(told))
    victims = np.array([[west + 45, south + 15]])
    np.savez(folder / "made_up.npz", heatmap_medium=heat, victims_xy_medium=victims)
    return folder


def test_rows_of_the_file_count_from_the_south(tmp_path):
    heat = np.zeros((3, 4))
    heat[0, 1] = 0.5  # south row, second column
    scenario = load_sarenv(written(tmp_path, heat), "made_up")
    assert scenario.heat[2, 1] == 0.5
    assert scenario.victims.tolist() == [[30.0, 0.0]]
    assert (scenario.cell_m, scenario.centre, scenario.south_west) == (30.0, (45.0, 30.0), SOUTH_WEST)
    assert scenario.baselines == ({"algorithm": "Spiral"},)
    assert scores(scenario, [np.array([[30.0, -5.0], [30.0, 5.0]])]).likelihood == 0.5


@pytest.mark.parametrize(
    ("heat", "other", "told"),
    [
        (np.array([[np.nan, 1.0]]), {}, "heatmap_medium"),
        (np.array([[-1.0, 2.0]]), {}, "heatmap_medium"),
        (np.ones((2, 2)), {"crop": {}}, "medium"),
        (np.ones((2, 2)), {"center_xy": "here"}, "no number"),
        (np.ones((2, 2)), {"detection_radius_m": float("nan")}, "nan m came"),
        (np.ones((2, 2)), {"crop": {"medium": {"bounds_xy": [1, 2, 3]}}}, "came"),
    ],
)
def test_other_files_are_refused(tmp_path, heat, other, told):
    with pytest.raises(DataFormatError, match=told):
        load_sarenv(written(tmp_path, heat, **other), "made_up")


def test_files_that_are_not_there_or_no_json_are_refused(tmp_path):
    with pytest.raises(DataFormatError):
        load_sarenv(tmp_path, "made_up")
    written(tmp_path, np.ones((2, 2)))
    (tmp_path / "made_up.json").write_text("[")
    with pytest.raises(DataFormatError, match="JSON"):
        load_sarenv(tmp_path, "made_up")


@pytest.mark.parametrize("way", [[[0.0, 0.0]], [[0.0, np.nan], [1.0, 1.0]], [0.0, 1.0]])
def test_ways_that_are_none_are_refused(way):
    with pytest.raises(InvalidProblemError, match="way"):
        scores(ground(), [np.array(way)])
