"""Shared fixtures: real maps, where SOONER_DATA says they are."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from sooner.belief import Belief
from sooner.grid import Grid
from sooner.problem import Searcher, SearchProblem, detection_gains
from sooner.sensors import glimpse_from_difficulty

# The same examples in every run, so that what is green stays green; HYPOTHESIS_PROFILE=explore looks for new ones.
settings.register_profile("same", deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
settings.register_profile("explore", deadline=None, suppress_health_check=list(HealthCheck))
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))


@pytest.fixture(scope="session")
def wisar() -> Path:
    """Folder of the real maps of [Lin2014]."""
    folder = Path(os.environ.get("SOONER_DATA", "")) / "wisar"
    if "SOONER_DATA" not in os.environ or not folder.is_dir():
        pytest.skip("SOONER_DATA is not set to a folder with the wisar maps")
    return folder


@pytest.fixture(scope="session")
def occupancy_graphs() -> Path:
    """Folder of the street maps of [Wolek2020]."""
    folder = Path(os.environ.get("SOONER_DATA", "")) / "occupancy_graphs"
    if "SOONER_DATA" not in os.environ or not folder.is_dir():
        pytest.skip("SOONER_DATA is not set to a folder with the occupancy graphs")
    return folder


@pytest.fixture(scope="session")
def real_problem(wisar):
    """(name, steps, with_difficulty) -> the paper's problem."""

    def make(name: str, steps: int, difficulty: bool = True, **searcher) -> SearchProblem:
        belief = Belief.from_weights(np.loadtxt(wisar / f"{name}_dist.csv", delimiter=","))
        glimpse = glimpse_from_difficulty(np.loadtxt(wisar / f"{name}_diff.csv", delimiter=",")) if difficulty else 1.0
        start = searcher.pop("start", (50, 50))
        return SearchProblem(
            Grid(belief.shape), detection_gains(belief, glimpse), (Searcher(start, steps, **searcher),)
        )

    return make
