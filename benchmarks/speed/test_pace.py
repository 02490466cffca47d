"""Timings of a thousand legs' times, as planners ask for them: nothing is asserted about the clock."""

import math

import numpy as np
import pytest

from sooner.motion import Pace, Terrain
from sooner.motion._pace_kernels import legs_s

PACES = ["still air", "length budget", "wind", "terrain"]


@pytest.fixture(scope="module")
def paces():
    hills = np.random.default_rng(0).uniform(0.0, 300.0, (100, 100))
    surface = Terrain(hills, 30.0).smoothed(90.0)
    windy = Pace(10.0, 2.0, 12.0, (3.0, 4.0))
    sloping = Pace(10.0, 2.0, 12.0, (3.0, 4.0), 3.0, 2.0, surface)
    return dict(zip(PACES, [Pace(10.0, 2.0), Pace(10.0, math.inf), windy, sloping], strict=True))


@pytest.mark.parametrize("kind", PACES)
def test_a_thousand_legs_of_one_kilometre(benchmark, paces, kind):
    rng = np.random.default_rng(1)
    starts, headings = rng.uniform(0.0, 3000.0, (1000, 2)), rng.uniform(0.0, 2 * math.pi, 1000)
    ends = starts + 1000.0 * np.column_stack([np.cos(headings), np.sin(headings)])
    benchmark(legs_s, starts, ends, *paces[kind].arrays())
