"""Joint search and rollouts: values as a plain recomputation gives them, climbing, beliefs, and one seed one search."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.belief import CellStates
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation import Agent, Estimator, Scene, Team, World, simulate
from sooner.simulation.ground import area, perimeter_places
from sooner.simulation.strategies import Joint, Rollouts
from sooner.simulation.strategies._coverage_kernels import add_up, heavy_cell, improve, lay, move, worth
from sooner.simulation.strategies.joint import (
    bodies,
    chosen_starts,
    dice,
    lane_layouts,
    pack,
    route_value,
    shared_lanes,
)
from sooner.simulation.strategies.presence import Presence
from tests.simulation.streets import blocks

GRID = Grid((24, 30), "square8", 5.0)
SHAPE = np.array(GRID.shape, np.int64)
LOW, HIGH = area(GRID)
SECONDS = 90
SCENE = Scene(World(blocks(24)), seconds=120)
seeds = st.integers(0, 2**32 - 1)


def places(rng, n):
    return LOW + rng.random((n, 2)) * (HIGH - LOW)


def plain_places(agent, place, route, capture):
    """Where an agent is at seconds 1 to SECONDS - 1, by Euler's rule in steps of 0.25 s."""
    p, v, left, track = np.array(place), np.zeros(2), list(route), []
    for step in range(4 * (SECONDS - 1)):
        while len(left) and np.hypot(*(left[0] - p)) <= capture * agent.radius_m:
            left.pop(0)
        aim = left[0] if left else route[-1]
        thrust = 10.0 * (aim - p) - 5.0 * v
        thrust *= min(1.0, agent.a_max / np.hypot(*thrust))
        p, v = p + 0.25 * v, v + 0.25 * (thrust - agent.a_max / agent.v_max * v)
        if step % 4 == 3:
            track.append(p)
    return np.array(track)


def plain_value(agents, starts, routes, weights, capture):
    first = np.full(GRID.n_cells, SECONDS)
    for agent, start, route in zip(agents, starts, routes, strict=True):
        track = plain_places(agent, start, route, capture)
        apart = np.linalg.norm(GRID.centres_m[:, None] - track[None], axis=-1) <= agent.radius_m
        seen = np.where(apart.any(axis=1), apart.argmax(axis=1) + 1, SECONDS)
        first = np.minimum(first, seen)
    return float((weights * (SECONDS - first)).sum())


@settings(deadline=None, max_examples=30)
@given(seeds, st.integers(1, 3), st.integers(8, 14))
def test_the_value_is_that_of_a_plain_recomputation(seed, n_agents, n_waypoints):
    rng = np.random.default_rng(seed)
    agents = tuple(Agent(v_max=rng.uniform(2, 5), radius_m=rng.uniform(6, 14)) for _ in range(n_agents))
    routes = tuple(places(rng, n_waypoints) for _ in agents)
    starts, weights = places(rng, n_agents), rng.random(GRID.n_cells)
    value = route_value(GRID, agents, starts, routes, weights, SECONDS)
    assert value == pytest.approx(plain_value(agents, starts, routes, weights, 0.5), rel=1e-9)


@settings(deadline=None, max_examples=30)
@given(seeds, st.integers(1, 12))
def test_a_changed_route_is_worth_what_flying_it_from_the_start_gives(seed, length):
    rng = np.random.default_rng(seed)
    body, start = bodies(Team((Agent(),)), GRID, 0.5, 1.0)[0], np.append(places(rng, 1)[0], [0.0, 0.0])
    weights, others = rng.random(GRID.n_cells), rng.integers(1, SECONDS + 1, GRID.n_cells).astype(np.int32)
    route, other = np.zeros((16, 2)), np.zeros((16, 2))
    route[:length] = places(rng, length)

    def laid(way, n):
        first, trail = np.empty(GRID.n_cells, np.int32), np.empty((SECONDS, 4))
        kept = first, trail, np.empty(SECONDS, np.int64), np.empty(SECONDS), np.empty(18, np.int64)
        return lay(start, body, way, n, SECONDS, SHAPE, 5.0, weights, others, *kept), kept

    _, kept = laid(route, length)
    thrown, marks, waits = dice(rng), np.full(GRID.n_cells, -1), np.empty(GRID.n_cells)
    add_up(weights, others, kept[0], waits)
    for mark in range(20):
        n, change = move(thrown, route, length, SHAPE, 5.0, LOW, HIGH, waits, other)
        assert (other[:change] == route[:change]).all()
        value = worth(change, body, other, n, SECONDS, SHAPE, 5.0, weights, others, *kept, marks, mark)
        assert value == pytest.approx(laid(other, n)[0], rel=1e-9)


def test_cells_are_tried_as_often_as_they_wait_long_by_weight():
    weights, never = np.zeros(GRID.n_cells), np.full(GRID.n_cells, SECONDS, np.int32)
    weights[[7, 400]] = 0.2, 1.0
    first, waits, thrown = never.copy(), np.empty(GRID.n_cells), dice(np.random.default_rng(0))
    first[400] = 16  # it waits 16, and the other 0.2 * 90 = 18
    add_up(weights, never, first, waits)
    share = 18.0 / 34.0  # of the heavier; two draws miss it with (16 / 34)^2
    drawn = np.array([heavy_cell(thrown, waits) for _ in range(4000)])
    assert set(drawn.tolist()) == {7, 400}
    assert (drawn == 7).mean() == pytest.approx(1.0 - (1.0 - share) ** 2, abs=0.04)


@settings(deadline=None, max_examples=10)
@given(seeds)
def test_climbing_never_lowers_the_value_and_tells_it(seed):
    rng = np.random.default_rng(seed)
    agents = (Agent(), Agent(v_max=5.0, radius_m=8.0))
    routes, starts, weights = tuple(places(rng, 6) for _ in agents), places(rng, 2), rng.random(GRID.n_cells)
    packed, lengths = pack(routes, 20)
    still = np.hstack([starts, np.zeros((2, 2))])
    told = improve(
        still, bodies(Team(agents), GRID, 0.5, 1.0), packed, lengths, SECONDS, SHAPE, 5.0, LOW, HIGH, weights, 5, 40,
        10, dice(rng),
    )  # fmt: skip
    after = tuple(route[:n] for route, n in zip(packed, lengths, strict=True))
    assert told == pytest.approx(route_value(GRID, agents, starts, after, weights, SECONDS), rel=1e-9)
    assert told >= route_value(GRID, agents, starts, routes, weights, SECONDS) * (1.0 - 1e-9)


@pytest.mark.parametrize("n_agents", [1, 2, 3, 4, 6])
def test_every_layout_shares_out_the_ground(n_agents):
    for layout in lane_layouts(GRID, (Agent(),) * n_agents):
        assert sum(inside.astype(int) for inside, _ in layout).tolist() == [1] * GRID.n_cells
        assert all(((way >= LOW) & (way <= HIGH)).all() for _, ways in layout for way in ways)


@pytest.mark.parametrize("n_agents", [1, 2, 3, 4, 7])
@pytest.mark.parametrize("grid", [GRID, Grid((2, 3), "square8", 5.0), Grid((1, 1), "square8", 5.0)])
def test_chosen_starts_lie_on_the_perimeter(grid, n_agents):
    agents = tuple(Agent(radius_m=8.0 + n) for n in range(n_agents))
    starts, (low, high) = chosen_starts(grid, agents), area(grid)
    assert starts.shape == (n_agents, 2)
    assert ((starts >= low) & (starts <= high)).all()
    assert (np.minimum(starts - low, high - starts).min(axis=1) < 1e-9).all()


def test_lanes_from_chosen_starts_bring_the_ground_into_view_sooner_than_from_those_drawn():
    agents, cells = (Agent(),) * 4, np.ones(GRID.n_cells)
    body = bodies(Team(agents), GRID, 0.5, 1.0)

    def value(starts):
        still = np.hstack([starts, np.zeros_like(starts)])
        routes, _ = shared_lanes(GRID, agents, body, cells, 120, still)
        return route_value(GRID, agents, starts, routes, cells, 120)

    drawn = [perimeter_places(GRID, 4, np.random.default_rng(seed)) for seed in range(8)]
    assert value(chosen_starts(GRID, agents)) > 1.02 * np.mean([value(starts) for starts in drawn])


def test_starts_that_are_chosen_do_not_hang_on_the_seed_and_those_drawn_do():
    chosen, drawn = Joint(start="chosen"), Joint()
    np.testing.assert_array_equal(SCENE.starts(chosen, 1), SCENE.starts(chosen, 2))
    assert not np.array_equal(SCENE.starts(drawn, 1), SCENE.starts(drawn, 2))


@pytest.mark.parametrize("prior", ["uniform", "kriged", "known"])
def test_streets_that_go_on_serve_every_prior(prior):
    scene = Scene(World(blocks(24)), estimator=Estimator(prior=prior), seconds=40)
    with_streets, without = (simulate(scene, Joint(streets=streets, first_rounds=2), 3) for streets in (True, False))
    assert np.array_equal(with_streets.places_m, without.places_m) == (prior == "known")


@settings(deadline=None, max_examples=20)
@given(seeds, st.integers(1, 40))
def test_the_targets_probabilities_total_one_and_move_as_the_plain_rule_says(seed, looks):
    rng = np.random.default_rng(seed)
    void = rng.random(GRID.n_cells)
    states = CellStates(void, 1.0 - void, np.zeros(GRID.n_cells), void < 0.5, np.zeros(GRID.n_cells, bool))
    presence = Presence(GRID, states)
    assert (presence.shares * (1.0 - void)).sum() == pytest.approx(1.0)
    cells, ratios = rng.choice(GRID.n_cells, looks, replace=False).astype(np.int32), np.exp(rng.normal(0.0, 4.0, looks))
    r = presence.shares.copy()
    presence.watch(cells, ratios)
    r[cells] *= ratios
    framed = np.pad((1.0 - void).reshape(GRID.shape), 1)
    beside = [(a, b) for a in range(3) for b in range(3) if (a, b) != (1, 1)]
    rows, cols = GRID.shape
    around = sum(framed[a : a + rows, b : b + cols] for a, b in beside)
    sent = np.pad((r * (1.0 - void)).reshape(GRID.shape) / np.maximum(around, 0.3), 1)
    r = 0.5 * r + 0.5 * sum(sent[a : a + rows, b : b + cols] for a, b in beside).ravel()
    np.testing.assert_allclose(presence.shares, r / (r * (1.0 - void)).sum())
    assert (presence.shares * (1.0 - void)).sum() == pytest.approx(1.0)


@pytest.mark.parametrize("strategy", [Joint(first_rounds=3), Rollouts(rollouts=40)])
def test_one_seed_one_search(strategy):
    first, again, other = (simulate(SCENE, strategy, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first.places_m, again.places_m)
    assert not np.array_equal(first.places_m, other.places_m)


def test_climbing_is_ahead_of_lanes_alone():
    lanes, climbed = (simulate(SCENE, Joint(first_rounds=n, rounds=0), 5).e_nodes for n in (0, 20))
    assert climbed > lanes


@pytest.mark.parametrize(
    ("kind", "bad"),
    [
        (Joint, {"start": "corner"}),
        (Joint, {"capture": 0.0}),
        (Joint, {"reach": np.nan}),
        (Joint, {"target": -1.0}),
        (Joint, {"rounds": -1}),
        (Joint, {"waypoints": 1}),
        (Rollouts, {"horizon_s": 0.0}),
        (Rollouts, {"target": np.inf}),
        (Rollouts, {"waypoints": 0}),
        (Rollouts, {"rollouts": -1}),
    ],
)
def test_impossible_settings_are_refused(kind, bad):
    with pytest.raises(InvalidProblemError, match="came"):
        kind(**bad)
