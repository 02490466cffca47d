"""Timings of what a simulated second asks of streets: nothing is asserted about the clock."""

import numpy as np
import pytest

from sooner.belief import TrackBeforeDetect
from sooner.scenarios import STREET_KINDS, street_grid
from sooner.streets import TargetStates, TargetWalk

SHARES = [0.25, 0.5, 1.0]  # of the nodes, detected


@pytest.fixture(scope="module")
def states():
    """The states of a gridiron: 410 nodes, 1,258 states, 3,962 transitions."""
    return TargetStates(street_grid("gridiron", 0))


@pytest.mark.parametrize("share", SHARES)
def test_a_second_of_a_track(benchmark, states, share):
    """80 looks at nodes, one motion update, every node's ratio."""
    rng, graph = np.random.default_rng(0), states.graph
    track = TrackBeforeDetect().begun(states, TargetWalk().weights(states))
    track.explore(np.arange(int(share * graph.n_nodes)))
    cells, told = rng.choice(graph.cells, 80).astype(np.int32), np.exp(rng.normal(-8.0, 4.0, 80))
    nobody, ratios = np.empty(0, np.int64), np.zeros(graph.n_nodes)
    benchmark(track.second, nobody, cells, told, ratios)


def test_transition_probabilities_of_a_walk(benchmark, states):
    benchmark(TargetWalk().weights, states)


def test_a_walk_of_four_minutes(benchmark, states):
    rng = np.random.default_rng(0)
    benchmark(TargetWalk().walked, states, 0, 240, rng)


@pytest.mark.parametrize("kind", STREET_KINDS)
def test_streets_are_generated(benchmark, kind):
    benchmark.pedantic(street_grid, (kind, 1), rounds=3, warmup_rounds=1)
