"""The map that timings are taken on: made here, so that they can be repeated anywhere."""

import os
from pathlib import Path

import numpy as np
import pytest

from sooner.belief import Belief
from sooner.experiments.lin2014.maps import posed
from sooner.grid import Grid
from sooner.problem import Searcher, SearchProblem, detection_gains
from sooner.sensors import glimpse_from_difficulty


def made(size: int, steps: int) -> SearchProblem:
    """Forty hills of probability and three levels of difficulty in broad patches."""
    rng = np.random.default_rng(7)
    rows, cols = np.mgrid[0:size, 0:size] / size
    weights = np.full((size, size), 0.02)
    rough = np.zeros((size, size))
    for _ in range(40):
        (row, col), width = rng.random(2), rng.uniform(0.02, 0.1)
        weights += rng.uniform(0.2, 1.0) * np.exp(-((rows - row) ** 2 + (cols - col) ** 2) / (2 * width**2))
        (row, col), width = rng.random(2), rng.uniform(0.05, 0.2)
        rough += rng.normal() * np.exp(-((rows - row) ** 2 + (cols - col) ** 2) / (2 * width**2))
    difficulty = np.searchsorted(np.quantile(rough, [0.2, 0.4]), rough)
    gains = detection_gains(Belief.from_weights(weights), glimpse_from_difficulty(difficulty))
    return SearchProblem(Grid((size, size)), gains, (Searcher((size // 2, size // 2), steps),))


def real(name: str, steps: int) -> SearchProblem:
    """One of the maps of [Lin2014]."""
    folder = Path(os.environ.get("SOONER_DATA", "")) / "wisar"
    if "SOONER_DATA" not in os.environ or not folder.is_dir():
        pytest.skip("SOONER_DATA is not set to a folder with the wisar maps")
    return posed(folder, name, (50, 50), steps)


@pytest.fixture(params=["made", "HikerPaul", "NewYork108"])
def problem(request: pytest.FixtureRequest) -> SearchProblem:
    """100 x 100 cells, T = 900."""
    return made(100, 900) if request.param == "made" else real(request.param.lower(), 900)
