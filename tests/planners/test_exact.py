"""The integer program over regions against every walk there is."""

from dataclasses import replace

import numpy as np
import pytest

from sooner.bounds import RegionLP
from sooner.bounds.region_network import RegionNetwork
from sooner.planners import max_seconds, max_ticks, solve
from sooner.planners.exact import Exact, _apart
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.solve import Status
from sooner.problem import Gains, evaluate

from .region_worlds import best_by_enumeration, region_world

INNER = RegionAnneal(walks=2, moves=60)
QUICK = Exact(INNER, ticks=2, gap=1e-7)


@pytest.mark.parametrize(("legs", "ends"), [(False, False), (True, False), (False, True), (True, True)])
@pytest.mark.parametrize("seed", range(4))
def test_the_best_of_all_walks_is_found_and_proved(seed, legs, ends):
    problem = region_world(seed, n_regions=4, budget=13.0, extra=seed % 3, legs=legs, ends=ends)
    best = best_by_enumeration(problem)
    solution = solve(problem, QUICK, seed=seed)
    assert solution.best.value == pytest.approx(best, rel=1e-6)
    assert best <= solution.best.bound <= best * (1.0 + 1e-5)
    assert evaluate(problem, solution.best.plan).value == solution.best.value


def apart_world(seed):
    """Two rich regions at the ends of a row of poor ones, whose edges pay only where they touch the rich."""
    problem = region_world(seed, n_regions=5, budget=16.0, extra=0)
    moves, table = problem.searcher.moves, problem.gains.table.copy()
    rich = np.union1d(moves.atoms.of(0), moves.atoms.of(4))
    poor = np.setdiff1d(np.arange(len(table)), rich)
    table[poor] *= 0.001
    return replace(problem, gains=Gains(table, problem.gains.ratio))


@pytest.mark.parametrize("seed", range(6))
def test_what_comes_out_in_parts_is_cut_until_one_walk_can_fly_it(seed):
    problem = apart_world(seed)
    solution = solve(problem, QUICK, seed=seed)
    best = best_by_enumeration(problem)
    assert solution.best.value == pytest.approx(best, rel=1e-6)
    assert best <= solution.best.bound <= best * (1.0 + 1e-5)


def test_programs_in_parts_do_come_up(monkeypatch):
    found = []

    def counted(ground, counts):
        parts = _apart(ground, counts)
        found.extend(parts)
        return parts

    monkeypatch.setattr("sooner.planners.exact._apart", counted)
    for seed in range(6):
        solve(apart_world(seed), QUICK, seed=seed)
    assert found


def test_narrow_windows_are_widened_until_they_hold_the_best_plan():
    problem = region_world(1, n_regions=3, budget=30.0)
    values = [solve(problem, Exact(INNER, ticks=1, gap=1e-7, width=width)).best.value for width in (1, 12)]
    assert values[0] == pytest.approx(values[1], rel=1e-6)


def test_linear_program_integer_program_and_annealing_are_in_order():
    for seed in range(3):
        problem = region_world(seed, n_regions=4, budget=20.0, extra=2)
        annealed = solve(problem, INNER, max_ticks(30), seed=seed).best.value
        exact = solve(problem, Exact(INNER, ticks=5), seed=seed).best
        linear = list(RegionLP().bounds(problem))[-1].value
        assert annealed <= exact.value * (1.0 + 1e-5)
        assert exact.value <= exact.bound <= linear
        assert exact.gap < 2e-4


def test_numbers_decoded_as_walks_are_flown_as_often_and_in_time():
    for seed in range(4):
        problem = region_world(seed, n_regions=5, budget=20.0, extra=2, ends=seed % 2 == 1)
        plan = solve(problem, Exact(INNER, ticks=3), seed=seed).best.plan
        moves = problem.searcher.moves
        counts = np.bincount(plan.actions[0], minlength=moves.graph.n_regions + moves.graph.n_edges)
        degree = np.zeros(moves.graph.n_regions, np.int64)
        np.add.at(degree, moves.graph.edges, counts[moves.graph.n_regions :, None])
        here = moves.first
        for action in plan.actions[0]:
            here = moves.graph.target(int(action), here)
        odd = {moves.first, here} if moves.first != here else set()
        assert set(np.flatnonzero(degree % 2).tolist()) == odd
        assert not _apart(RegionNetwork.of(problem).ground, counts)
        assert evaluate(problem, plan).value > 0


def test_values_never_fall_and_bounds_never_rise():
    problem = region_world(2, n_regions=5, budget=20.0, legs=True)
    ticks = list(QUICK.plans(problem, np.random.default_rng(0)))
    values, bounds = [tick.value for tick in ticks], [tick.bound for tick in ticks]
    assert values == sorted(values)
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[-1] >= values[-1]


def test_the_same_seed_gives_the_same_plan():
    problem = region_world(5, n_regions=4, budget=18.0)
    one, other = (solve(problem, Exact(INNER, ticks=3), seed=7).best for _ in range(2))
    assert one == other or one.plan.actions[0].tolist() == other.plan.actions[0].tolist()
    assert one.value == other.value


def test_a_stop_rule_that_knows_the_time_is_kept():
    problem = region_world(3, n_regions=6, budget=40.0, extra=4)
    solution = solve(problem, Exact(INNER), max_seconds(10.0), seed=0)  # time enough for kernels without compilation
    assert solution.status in (Status.STOPPED, Status.FINISHED, Status.PROVED)
    assert np.isfinite(solution.best.bound)


def test_closing_early_is_safe():
    ticks = Exact(INNER, ticks=1).plans(region_world(3, n_regions=5, budget=40.0), np.random.default_rng(0))
    next(ticks)
    ticks.send(0.5)
    ticks.close()


def test_two_searchers_are_refused_with_a_sentence():
    problem = region_world(0)
    assert "one searcher" in Exact().handles(replace(problem, searchers=problem.searchers * 2))
    assert Exact().handles(problem) is None
