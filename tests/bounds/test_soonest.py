"""No plan reaches the target sooner than the bound says."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings

from sooner.bounds import ConnectedSubgraph, bounds, soonest_bounds
from sooner.grid import Grid
from sooner.problem import Gains, Objective, Searcher, SearchProblem
from tests.oracles.walks import soonest
from tests.strategies import problems

QUICK = ConnectedSubgraph(separate_every=1, smallest_cut=0.0, iterations=10)


@settings(max_examples=100, deadline=None)
@given(problems(most_steps=5, target=True))
def test_no_plan_is_sooner(problem):
    best = -soonest(problem)
    for known in (-np.inf, best):
        found = list(itertools.islice(soonest_bounds(problem, known, QUICK, ticks=5), 60))
        assert all(bound.value >= best for bound in found)
        assert all(later.value <= sooner.value for sooner, later in itertools.pairwise(found))


def test_a_target_beyond_a_gap_is_proved_late():
    weights = np.zeros(12)
    weights[[0, 11]] = 0.5
    gains = Gains.independent(weights, np.ones(12))
    problem = SearchProblem(Grid((1, 12)), gains, (Searcher((0, 0), 20),), Objective(target=0.9))
    found = list(itertools.islice(bounds(problem, -11.0), 4000))[-1]
    assert found.value == pytest.approx(-11.0)
    assert "subgraph" in found.proof
