"""Bounds over legs: above every plan there is, and each lemma of the proof by itself."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from sooner.bounds import bounds
from sooner.bounds.legs import _Ground, _Law, _profit, _sums, leg_bounds, longest_m, most_in_view
from sooner.errors import InfeasibleProblemError
from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace
from sooner.planners.leg_anneal import LegAnneal
from sooner.planners.planner import follow
from sooner.problem import Gains, Objective, Plan, Searcher, SearchProblem, evaluate
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, place_numbers
from sooner.sensors.swath import Swath
from tests.grounds import leg_world
from tests.grounds import pace as random_pace

seeds = st.integers(0, 2**32 - 1)
laws = st.sampled_from(["seen", "edged", "even", "cube"])


def fitted(problem, number, points):
    """As much of a polyline as one sortie can fly; None where not even the way home."""
    searcher = problem.searchers[number]
    for count in range(len(points), -1, -1):
        ends = [] if searcher.moves.end is None else [searcher.moves.end]
        tried = place_numbers(np.concatenate([[searcher.moves.home], points[:count], np.reshape(ends, (-1, 2))]))
        if searcher.moves.fault(problem.grid, searcher, tried) is None:
            return tried
    return None


def wandering(rng, home, extent, step):
    """Places on a random way; short steps hover about where they are, long ones cross the map."""
    return np.clip(home + np.cumsum(rng.normal(0, step, (60, 2)), axis=0), 0, extent)


@settings(max_examples=30)
@given(seed=seeds, searchers=st.integers(1, 3), step=st.sampled_from([3.0, 30.0, 300.0]))
def test_no_random_plan_passes_a_bound(seed, searchers, step):
    rng = np.random.default_rng(seed)
    try:
        problem = leg_world(rng, 10, searchers, float(rng.choice([20.0, 100.0, 400.0])))
    except InfeasibleProblemError:
        assume(False)
    if rng.random() < 0.5:
        problem = replace(problem, gains=effort_gains(sparse(rng, problem.grid.n_cells)))
    found = [each.value for each in leg_bounds(problem)]
    assert found
    assert found == sorted(found, reverse=True)
    for _ in range(3):
        ways = [
            fitted(problem, number, wandering(rng, each.moves.home, 930.0, step))
            for number, each in enumerate(problem.searchers)
        ]
        assume(all(way is not None for way in ways))
        assert evaluate(problem, Plan(tuple(ways))).value <= found[-1]


def sparse(rng, cells):
    """POC in few cells, where a way can hang about."""
    poc = rng.random(cells) * (rng.random(cells) < 0.05)
    return poc / max(poc.sum(), 1.0)


@settings(max_examples=8)
@given(seed=seeds)
def test_no_annealed_plan_passes_a_bound(seed):
    rng = np.random.default_rng(seed)
    try:
        problem = leg_world(rng, 5, 1, 200.0, side_m=300.0)
    except InfeasibleProblemError:
        assume(False)
    bound = list(leg_bounds(problem))[-1].value
    advance = follow(LegAnneal(moves=50, threads=1).plans(problem, rng))
    for tick in range(4):
        incumbent = advance(tick / 4)
        if incumbent is None:
            break
        assert incumbent.value <= bound


@given(law=laws, radius=st.floats(0.3, 3.0), accel=st.sampled_from([2.0, math.inf]), offset=st.floats(0, 1))
@settings(max_examples=25)
def test_straight_lanes_over_even_ground_come_near_but_not_past(law, radius, accel, offset):
    grid = Grid((12, 40), cell_m=10.0)
    sight = {
        "seen": Swath.seen(grid, 10 * radius),
        "edged": Swath.edged(grid, 10 * radius),
        "even": Swath.of_width(grid, 5.0, max(10 * radius, 2.5)),
        "cube": Swath.of_width(grid, 20.0, 10 * radius, "cube"),
    }[law]
    space, y = Airspace(shapely.box(-5, -5, 400, 120)), 50.0 + round(10 * offset, 1)
    moves = LegMoves(space, Pace(10.0, accel), sight, (0.0, y))
    poc = np.full(480, 1 / 480)
    problem = SearchProblem(grid, effort_gains(poc), (Searcher((6, 0), 38.0, moves=moves),))
    way = fitted(problem, 0, np.array([[300.0, y], [340.0, y], [380.0, y]]))
    value, bound = evaluate(problem, Plan((way,))).value, list(leg_bounds(problem))[-1].value
    assert value <= bound
    if law != "edged" and radius > 1.0:
        assert bound <= 3.5 * value


# ---------------------------------------------------------------- metres


@settings(max_examples=150)
@given(seed=seeds, count=st.integers(1, 6))
def test_no_way_is_longer_than_its_time_allows(seed, count):
    rng = np.random.default_rng(seed)
    grid = Grid((4, 4), cell_m=100.0)
    space, flies = Airspace.of_cells(np.ones((4, 4), bool), 100.0), random_pace(rng, grid)
    points = rng.uniform(0, 300, (count + 1, 2))
    if rng.random() < 0.5:
        points = np.concatenate([points, points[:1]])
    end = tuple(points[-1]) if rng.random() < 0.7 else None
    moves = LegMoves(space, flies, Swath.seen(grid, 1.0), tuple(points[0]), end)
    metres = np.hypot(*np.diff(points, axis=0).T).sum()
    assert metres - 0.05 <= longest_m(moves, moves.seconds(points))


@pytest.mark.parametrize(("wind", "most"), [((0.0, 0.0), 1000.0), ((6.0, 0.0), 800.0)])
def test_across_the_wind_and_back_is_the_most_in_a_wind(wind, most):
    grid = Grid((1, 1))
    moves = LegMoves(
        Airspace(shapely.box(0, 0, 9, 900)), Pace(99.0, math.inf, 10.0, wind), Swath.seen(grid, 1.0), (5, 5), (5, 5)
    )
    assert moves.seconds([(5, 5), (5, 5 + most / 2), (5, 5)]) == pytest.approx(100.0)
    assert longest_m(moves, 100.0) == pytest.approx(most, rel=1e-5)


# ---------------------------------------------------------------- cells in view


@settings(max_examples=80)
@given(seed=seeds, radius=st.floats(0.1, 5.0), step=st.floats(0.01, 5.0))
def test_no_way_has_more_cells_in_view(seed, radius, step):
    rng = np.random.default_rng(seed)
    steps = rng.normal(0, step, (30, 2)) if rng.random() < 0.5 else rng.choice([-1.0, 0.0, 1.0], (30, 2)) * step
    way = np.cumsum(steps, axis=0) + rng.uniform(0, 1, 2)
    west, south = np.floor(way.min(axis=0) - radius)
    east, north = np.ceil(way.max(axis=0) + radius)
    assume((east - west) * (north - south) < 2e5)
    x, y = np.meshgrid(np.arange(west, east + 1), np.arange(south, north + 1))
    seen = shapely.dwithin(shapely.LineString(way), shapely.points(x.ravel(), y.ravel()), radius).sum()
    length = np.hypot(*np.diff(way, axis=0).T).sum()
    assert seen <= most_in_view(radius, length)


# ---------------------------------------------------------------- effort


def of(law, strength, radius, weighed=False, plain=False, closest=0.0, cell_m=10.0):
    """The law as the proof takes it, over cells of so many strengths."""
    strength = np.asarray(strength, float)
    sight = Swath(radius, law, strength)
    return _Law.of(_Ground(np.full(len(strength), 0.1), strength, sight, cell_m, 100.0, 1, 2), weighed, plain, closest)


@settings(max_examples=60)
@given(seed=seeds, law=st.sampled_from(["even", "cube"]), weighed=st.booleans(), plain=st.booleans())
def test_no_place_has_more_in_view_at_once(seed, law, weighed, plain):
    rng = np.random.default_rng(seed)
    radius = float(rng.uniform(3.0, 60.0))
    top = 0.2 if law == "even" else radius
    closest = float(rng.choice([0.0, 3.0, 8.0])) if law == "cube" else 0.0
    proof = of(law, rng.uniform(0.05, 1.0, 5) * top, radius, weighed, plain and law == "even", closest)
    rate, granted = _sums(proof, 10.0)
    centres = np.stack(np.meshgrid(*[np.arange(-80.0, 81.0, 10.0)] * 2), axis=-1).reshape(-1, 2)
    k = rng.choice(proof.strength, len(centres))
    weight = 1 / k if weighed else 1.0
    spread = float(rng.choice([0.01, 1.0, 5.0]))
    for place in rng.normal(0, spread, (40, 2)):
        r = np.hypot(*(centres - place).T)
        q = proof.q(r)
        g = ((r <= radius) & (r >= closest)) * (r**-3.0 if law == "cube" else 1.0)
        assert (weight * k * g * np.exp(-k * q)).sum() <= rate * (1 + 1e-9)
        assert (weight * -np.expm1(-k * q)).sum() <= granted * (1 + 1e-9) + 1e-12


@settings(max_examples=80)
@given(seed=seeds, law=st.sampled_from(["even", "cube"]), k=st.floats(0.01, 3.0), plain=st.booleans())
def test_a_cell_is_found_no_surer_than_its_share_allows(seed, law, k, plain):
    rng = np.random.default_rng(seed)
    radius = 3.0
    proof = of(law, [k if law == "even" else math.sqrt(8 * math.pi * k)], radius, plain=plain and law == "even")
    way = np.cumsum(rng.normal(0, rng.choice([0.1, 1.0, 4.0]), (12, 2)), axis=0) + rng.normal(0, 1, 2)
    far = [way[0] * 3.0 / max(np.hypot(*way[0]), 1e-9), way[-1] * 3.0 / max(np.hypot(*way[-1]), 1e-9)]
    way = np.concatenate(
        [[far[0]] if np.hypot(*way[0]) < 3 else way[:0], way, [far[1]] if np.hypot(*way[-1]) < 3 else way[:0]]
    )
    effort = m = 0.0
    for start, end in pairwise(way):
        ds = math.dist(start, end) / 4000
        r = np.hypot(*(start + (np.arange(4000)[:, None] + 0.5) / 4000 * (end - start)).T)
        assume(r.min() > 0.05)
        rate = (r <= radius) * (k * r**-3.0 if law == "cube" else k)
        effort += rate.sum() * ds
        m += (rate * np.exp(-k * proof.q(r))).sum() * ds
    whole = np.minimum(np.array([k * proof.q(np.zeros(1))[0]]), 600.0)
    for price in np.geomspace(1e-4, 1.0, 30):  # p (1 - exp(-e)) - x m is no more than the profit
        assert -math.expm1(-effort) - price * m <= _profit(np.ones(1), whole, np.array([price]))[0] + 2e-3


@given(whole=st.floats(0.0, 50.0), share=st.floats(1e-6, 2.0), p=st.floats(0.01, 1.0))
def test_the_profit_is_the_most_of_a_concave_curve(whole, share, p):
    m = np.concatenate([np.linspace(0, 4, 4001), np.geomspace(4, 1e6, 4000)])
    once = 2 * -math.expm1(-whole)
    with np.errstate(over="ignore"):
        beyond = -np.expm1(-2 * whole - np.minimum((m - once) * np.exp(whole), 700.0))
    found = np.where(m <= once, 1 - (1 - m / 2) ** 2, beyond)
    best = (p * found - share * p * m).max()
    assert _profit(np.array([p]), np.array([whole]), np.array([share * p]))[0] == pytest.approx(
        max(best, 0.0), abs=2e-3 * p
    )


# ---------------------------------------------------------------- what is told, and when nothing is


def small(law="seen", **more):
    grid = Grid((10, 10), cell_m=20.0)
    sight = Swath.seen(grid, 15.0) if law == "seen" else Swath.of_width(grid, 20.0, 30.0, law)
    space = Airspace(shapely.union_all([shapely.box(0, 0, 80, 180), shapely.box(120, 0, 180, 180)]))
    moves = LegMoves(space, Pace(10.0, 2.0), sight, (20.0, 20.0), (20.0, 20.0))
    return SearchProblem(grid, effort_gains(np.full(100, 0.01)), (Searcher((8, 1), 200.0, moves=moves),), **more)


@pytest.mark.parametrize(("law", "proof"), [("seen", "swept area"), ("even", "effort swept"), ("cube", "effort swept")])
def test_a_bound_names_its_proof_and_what_it_assumes(law, proof):
    found = list(bounds(small(law)))
    assert found[-1].proof == proof
    assert "cells count by their centres" in found[-1].assumes
    assert found[-1].value <= 0.601  # a zone lies between home and the cells in the east


def test_what_lies_beyond_reach_does_not_count():
    near = replace(small(), gains=effort_gains(np.eye(100)[9]))  # the north-eastern corner
    assert [each.proof for each in bounds(near)] == ["out of reach"]
    assert [each.value for each in bounds(near)] == [0.0]


def test_metres_flown_before_anything_is_in_view_do_not_count():
    grid = Grid((10, 100), cell_m=20.0)
    moves = LegMoves(
        Airspace(shapely.box(0, 0, 2000, 180)), Pace(10.0, math.inf), Swath.seen(grid, 15.0), (20.0, 20.0), (20.0, 20.0)
    )
    far = np.zeros((10, 100))
    far[:, 60:] = 1 / 400
    problem = SearchProblem(grid, effort_gains(far), (Searcher((8, 1), 300.0, moves=moves),))
    [found] = leg_bounds(problem)
    metres = 3000.0 - 2 * (60 * 20.0 - 20.0 - 15.0)
    assert found.value == pytest.approx(math.floor(most_in_view(0.75, metres / 20)) / 400, rel=1e-3)


def test_where_nothing_is_proved_nothing_is_told():
    one = small()
    assert list(bounds(replace(one, objective=Objective(target=0.2)))) == []
    assert list(bounds(replace(one, gains=Gains.independent(np.full(100, 0.01), np.full(100, 0.3))))) == []
    other = replace(one.searcher, moves=replace(one.searcher.moves, swath=Swath.seen(one.grid, 16.0)))
    assert list(bounds(replace(one, searchers=(one.searcher, other)))) == []
    mixed = replace(one, searchers=(one.searcher, Searcher((0, 0), 5)))
    assert list(bounds(mixed)) == []
