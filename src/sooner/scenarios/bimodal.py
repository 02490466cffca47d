"""Bimodal: two places, and which to search first is the question."""

from __future__ import annotations

import numpy as np

from sooner.scenarios.scenario import Scenario
from sooner.scenarios.terrain import hill

__all__ = ["bimodal"]


def bimodal(seed: int = 0, size: int = 60) -> Scenario:
    """A map of `size` x `size` cells with a broad hill and a sharp one, seen three times in four."""
    rng = np.random.default_rng(seed)
    shape = (size, size)
    place = size * (np.array([[0.27, 0.28], [0.7, 0.72]]) + rng.uniform(-0.04, 0.04, (2, 2)))
    broad = hill(shape, (place[0, 0], place[0, 1]), (0.11 * size, 0.14 * size), rng.uniform(0, np.pi))
    sharp = hill(shape, (place[1, 0], place[1, 1]), (0.06 * size, 0.05 * size), rng.uniform(0, np.pi))
    weights = broad + 1.6 * sharp + 1e-4
    return Scenario(
        f"Bimodal, {size} x {size}", weights, start=(size // 2, size // 4), seconds=1200 * size / 60, glimpse=0.75
    )
