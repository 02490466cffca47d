"""Straight lines between told heights stay near the surface and above the ground; few places are told."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InvalidProblemError
from sooner.motion import Terrain
from sooner.motion.following import followed


def terrain(seed, rough):
    """Smooth hills, and rough ground on them."""
    rng = np.random.default_rng(seed)
    rows, cols = np.indices((30, 40))
    hills = sum(
        h * np.exp(-((rows - r) ** 2 + (cols - c) ** 2) / (2 * w**2))
        for r, c, w, h in rng.uniform([0, 0, 3, 20], [30, 40, 8, 150], (5, 4))
    )
    return Terrain(hills + rough * rng.random((30, 40)), 20.0)


def between(points, along, heights, count=4000):
    """Places and heights all along, a few centimetres to a metre apart."""
    flown = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.union1d(np.linspace(0.0, flown[-1], count), along)
    places = np.column_stack([np.interp(at, flown, points[:, axis]) for axis in (0, 1)])
    return places, np.interp(at, along, heights)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 3.0, 40.0]), st.sampled_from([1.0, 2.0, 10.0]))
def test_lines_keep_near_the_surface_and_above_the_ground(seed, rough, off_m):
    ground = terrain(seed, rough)
    surface = ground.smoothed(40.0)
    points = np.random.default_rng(seed).uniform([-50, -50], [850, 650], (5, 2))  # beyond the map as well
    along, heights = followed(points, surface, ground, 60.0, off_m)
    assert (np.diff(along) > 0).all()
    places, flown = between(points, along, heights)
    assert (flown - ground.heights_at(places)).min() >= 60.0 - 1e-6
    assert np.abs(flown - surface.heights_at(places) - 60.0).max() <= off_m + 1e-6


@given(st.integers(0, 2**32 - 1))
def test_where_the_surface_is_the_ground_itself_it_is_flown_a_little_higher(seed):
    ground = terrain(seed, 5.0)
    points = np.random.default_rng(seed).uniform([0, 0], [780, 580], (3, 2))
    along, heights = followed(points, ground, ground, 30.0)
    places, flown = between(points, along, heights)
    assert (flown - ground.heights_at(places)).min() >= 30.0 - 1e-6
    assert (flown - ground.heights_at(places)).max() <= 2.0 + 30.0 + 5.0


def test_corners_are_told_and_flat_ground_needs_nothing_else():
    flat = Terrain(np.full((9, 9), 7.0), 20.0)
    points = np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 33.0], [17.0, 120.0]])
    along, heights = followed(points, flat, flat, 50.0)
    np.testing.assert_allclose(along, [0.0, 100.0, 133.0, 133.0 + np.hypot(83.0, 87.0)])
    np.testing.assert_allclose(heights, 57.0)
    assert followed(points[:1], flat, flat, 50.0)[1].tolist() == [57.0]


def test_a_wider_tolerance_needs_fewer_places():
    ground = terrain(5, 3.0)
    counts = [len(followed([[0, 0], [780, 580]], ground.smoothed(40.0), ground, 60.0, off)[0]) for off in (0.5, 2, 8)]
    assert counts[0] > counts[1] > counts[2] >= 2
    with pytest.raises(InvalidProblemError, match="off_m = 0"):
        followed([[0, 0], [1, 1]], ground, ground, 60.0, 0.0)
