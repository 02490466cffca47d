import numpy as np
import opensimplex
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from opensimplex.internals import _init

from sooner.errors import InvalidProblemError
from sooner.scenarios.simplex_noise import _permutation, elevation, simplex_noise

seeds = st.integers(-(2**70), 2**70)
places = st.floats(-1000, 1000)


@pytest.mark.parametrize("seed", [0, 1, 42, -7, 2**63 - 1, 2**63, 10**30])
def test_a_seed_shuffles_as_in_opensimplex(seed):
    assert _permutation(seed).tolist() == _init(seed)[0].tolist()


@pytest.mark.parametrize("reach", [1, 30, 1600])
@pytest.mark.parametrize("seed", [1, 99])
def test_the_noise_is_that_of_opensimplex_to_twelve_digits(seed, reach):
    x, y = np.random.default_rng(seed).uniform(-reach, reach, (2, 5000))
    theirs = opensimplex.OpenSimplex(seed)
    expected = [theirs.noise2(*place) for place in zip(x, y, strict=True)]
    np.testing.assert_allclose(simplex_noise(x, y, seed), expected, rtol=0, atol=1e-12)


def test_no_lattice_point_within_reach_is_left_out():
    """Against the sum over 11 x 11 lattice points around, whatever triangle a point lies in."""
    x, y = np.random.default_rng(3).uniform(-2, 2, (2, 3000))
    permutation, squish = _permutation(5), (3**0.5 - 1) / 2
    octagon = np.array([(5, 2), (2, 5), (-5, 2), (-2, 5), (5, -2), (2, -5), (-5, -2), (-2, -5)])
    total = np.zeros(x.size)
    for i in range(-5, 6):
        for j in range(-5, 6):
            gx, gy = octagon[permutation[(permutation[i % 256] + j) % 256] // 2 % 8]
            dx, dy = x - i - (i + j) * squish, y - j - (i + j) * squish
            total += np.maximum(0, 2 - dx**2 - dy**2) ** 4 * (gx * dx + gy * dy) / 47
    np.testing.assert_allclose(simplex_noise(x, y, 5), total, rtol=0, atol=1e-13)


@given(seeds, places, places)
def test_noise_lies_between_minus_one_and_one_and_repeats(seed, x, y):
    noise = simplex_noise(x, y, seed)
    assert -1.0 <= noise <= 1.0
    assert noise == simplex_noise(x, y, seed) == simplex_noise(x, y, seed + 2**64)


@given(seeds, places, places, st.floats(0, 2 * np.pi), st.floats(0, 0.1))
def test_noise_is_continuous(seed, x, y, heading, apart):
    """No bump is steeper than 2.4, and no more than four overlap."""
    there = simplex_noise(x + apart * np.cos(heading), y + apart * np.sin(heading), seed)
    assert abs(there - simplex_noise(x, y, seed)) <= 9.6 * apart + 1e-11


def test_noise_is_zero_on_average_and_at_every_origin():
    x, y = np.random.default_rng(1).uniform(-500, 500, (2, 100_000))
    assert abs(simplex_noise(x, y, 1).mean()) < 0.01
    assert [float(simplex_noise(0, 0, seed)) for seed in range(20)] == [0.0] * 20


@settings(max_examples=20)
@given(seeds, st.integers(1, 20), st.integers(1, 20), st.floats(0.01, 1), st.floats(-1, 1))
def test_elevation_is_the_weighted_sum_of_bands(seed, rows, cols, frequency, weight):
    y, x = np.mgrid[0:rows, 0:cols]
    bands = simplex_noise(frequency * x, frequency * y, seed) + weight * simplex_noise(0.3 * x, 0.3 * y, seed)
    made = elevation((rows, cols), (frequency, 0.3), (1.0, weight), seed)
    np.testing.assert_allclose(made, bands, rtol=0, atol=1e-12)


def test_points_take_the_shape_that_they_are_broadcast_to():
    assert simplex_noise(np.zeros((3, 1)), np.zeros(4), 1).shape == (3, 4)
    assert simplex_noise([], [], 1).shape == (0,)


@pytest.mark.parametrize("place", [np.nan, np.inf, -1e13])
def test_places_without_noise_are_refused(place):
    with pytest.raises(InvalidProblemError, match="coordinates"):
        simplex_noise([0.0, place], 0.0, 1)


@pytest.mark.parametrize(
    ("frequencies", "weights", "said"),
    [
        ((1.0,), (1.0, 2.0), "1 frequencies and 2 weights"),
        ((np.nan,), (1,), "frequencies"),
        ((1,), (np.inf,), "weights"),
    ],
)
def test_bands_that_make_no_sense_are_refused(frequencies, weights, said):
    with pytest.raises(InvalidProblemError, match=said):
        elevation((2, 2), frequencies, weights, 1)
