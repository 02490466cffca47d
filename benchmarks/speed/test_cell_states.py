"""Timings of a replan: kriging, information, tasks. Nothing is asserted about the clock."""

import numpy as np
import pytest

from sooner.belief import InformationTable, StreetKriging, street_directions
from sooner.scenarios.street_grid import street_grid
from sooner.sensors import GradedSensor
from sooner.simulation import Estimator, Scene, World, simulate
from sooner.simulation.strategies import Information
from sooner.simulation.strategies.strategy import Situation

TIMES = {"rounds": 200, "iterations": 1, "warmup_rounds": 5}
WORLD = World(street_grid("gridiron", seed=1))
PAPER = GradedSensor().p_levels


@pytest.fixture(params=[0, 16, 32], ids=["start", "third", "two-thirds"])
def situation(request) -> Situation:
    """What a team knows at a replan of a search with a kriged prior."""
    seen = []

    class Watched(Information):
        def session(self, now, rng):
            session = super().session(now, rng)
            routes = session.routes

            def watched(then):
                seen.append(then)
                if len(seen) > request.param:
                    raise StopIteration
                return routes(then)

            session.routes = watched
            return session

    with pytest.raises(StopIteration):
        simulate(Scene(WORLD, estimator=Estimator(prior="kriged")), Watched(), seed=1)
    return seen[-1]


def test_information(benchmark, situation):
    states, table = situation.states, InformationTable(PAPER, PAPER)
    table.table  # noqa: B018  computed once
    benchmark.pedantic(table.information, (states.void, states.unoccupied, states.occupied), **TIMES)


def test_kriging_from_nothing(benchmark, situation):
    """Without a warm start; in flight half the rounds are left."""
    states, method = situation.states, StreetKriging()
    angles = WORLD.edge_angles[states.nodes[WORLD.edge_cells].all(axis=1)]
    benchmark.pedantic(
        lambda: method.session(WORLD.graph.grid).expected_void(states.void, states.explored, angles), **TIMES
    )


def test_kriging_by_the_full_system(benchmark, situation):
    states = situation.states
    angles = WORLD.edge_angles[states.nodes[WORLD.edge_cells].all(axis=1)]
    settings = WORLD.graph.grid, states.void, states.explored, *street_directions(angles)
    benchmark.pedantic(StreetKriging().dense, settings, rounds=3, iterations=1)


def test_a_replan(benchmark, situation):
    """From where the last replan left the sites; the first one from anywhere."""
    session = Information().session(situation, np.random.default_rng(1))
    session.routes(situation)
    benchmark.pedantic(session.routes, (situation,), **TIMES)


@pytest.mark.parametrize("utility", ["maximum", "swept"])
def test_a_search(benchmark, utility):
    """Four agents, 240 s, 48 replans."""
    scene, strategy = Scene(WORLD, estimator=Estimator(prior="kriged")), Information(utility=utility)
    benchmark.pedantic(simulate, (scene, strategy, 1), rounds=5, warmup_rounds=1)
