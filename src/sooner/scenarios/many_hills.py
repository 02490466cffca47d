"""Many hills: two score places where the person may be, of all sizes, half an hour of flight and home again."""

from __future__ import annotations

import numpy as np

from sooner.scenarios.scenario import Scenario
from sooner.scenarios.terrain import hill

__all__ = ["many_hills"]


def many_hills(seed: int = 0, size: int = 100) -> Scenario:
    """A map of `size` x `size` cells with 40 hills; every look detects four times in five."""
    rng = np.random.default_rng(seed)
    shape = (size, size)
    weights = np.full(shape, 0.002)
    for _ in range(40):
        centre = rng.uniform(0, size, 2)
        spread = size * np.exp(rng.uniform(np.log(0.012), np.log(0.06), 2))
        height = rng.uniform(0.15, 1.0) * rng.uniform(0.3, 1.0)
        weights += height * hill(shape, (centre[0], centre[1]), (spread[0], spread[1]), rng.uniform(0, np.pi))
    home = (size // 2, size // 2)
    return Scenario(
        f"Many hills, {size} x {size}",
        weights,
        start=home,
        end=home,
        seconds=1800 * size / 100,
        glimpse=0.8,
        outside=0.05,
    )
