"""A hiker who walks on while we search: the belief drifts, and early plans grow old."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sooner.motion import drift_transition
from sooner.problem import Drift, Gains, SearchProblem
from sooner.scenarios.scenario import Scenario
from sooner.scenarios.terrain import hill

__all__ = ["drifting_hiker"]


def drifting_hiker(seed: int = 0, move: float = 0.25, size: int = 50, steps: int = 300) -> SearchProblem:
    """A few hills of belief whose person leaves the cell with probability `move` in a step, mostly one way.

    Parameters
    ----------
    seed : int
    move : float       0 is a person who stays: the same problem with nothing to learn from asking again
    size : int         rows and columns
    steps : int        length of the flight
    """
    rng = np.random.default_rng(seed)
    shape = (size, size)
    weights = np.full(shape, 1e-4)
    for _ in range(6):
        (row, col), (high, wide) = rng.uniform(0.1, 0.9, 2) * size, rng.uniform(0.04, 0.12, 2) * size
        weights += rng.uniform(0.3, 1.0) * hill(shape, (row, col), (high, wide), rng.uniform(0, np.pi))
    middle = (size // 2, size // 2)
    still = Scenario("Drifting hiker", weights, start=middle, seconds=2.0 * steps, glimpse=0.7).problem()
    heading = rng.uniform(0, 2 * np.pi)
    if move == 0.0:
        return still
    glimpse = np.full(still.grid.n_cells, 0.7)
    drift = Drift(still.gains.first / 0.7, glimpse, drift_transition(still.grid, move, heading, persistence=1.0))
    return replace(still, gains=Gains.independent(drift.poc, glimpse), drift=drift)
