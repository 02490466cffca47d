"""Rugged ridge: a bent ridge with side valleys, forest that hides, and rocks that stand in the way."""

from __future__ import annotations

import numpy as np

from sooner.scenarios.scenario import Scenario
from sooner.scenarios.terrain import hill, smooth_noise

__all__ = ["rugged_ridge"]


def rugged_ridge(seed: int = 0, size: int = 100) -> Scenario:
    """A map of `size` x `size` cells with difficulty levels 0 (open), 1 (trees) and 2 (dense forest), and rocks."""
    rng = np.random.default_rng(seed)
    shape = (size, size)
    rows, cols = np.mgrid[0:size, 0:size] / size
    bend = 0.55 + 0.16 * np.sin(2 * np.pi * (cols * rng.uniform(0.7, 1.1) + rng.uniform()))
    ridge = np.exp(-0.5 * ((rows - bend) / 0.07) ** 2)
    rough = smooth_noise(shape, rng, (size / 20, size / 50))
    last_seen = (size * rng.uniform(0.35, 0.65), size * rng.uniform(0.35, 0.65))
    weights = ridge * np.exp(0.9 * rough) * (0.15 + hill(shape, last_seen, (size / 5, size / 4)))
    forest = smooth_noise(shape, rng, (size / 12, size / 25)) - 0.6 * ridge
    difficulty = np.digitize(forest, np.quantile(forest, (0.35, 0.75)))
    rocks = smooth_noise(shape, rng, (size / 25,)) > 2.1
    home = (size // 2, size // 2)
    rocks[home[0] - 2 : home[0] + 3, home[1] - 2 : home[1] + 3] = False
    weights[rocks] = 0.0
    return Scenario(
        f"Rugged ridge, {size} x {size}",
        weights,
        start=home,
        end=home,
        seconds=1800 * size / 100,
        difficulty=difficulty,
        obstacles=rocks,
    )
