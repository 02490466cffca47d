"""Timings at a fixed number of ticks; nothing is asserted about the clock. See README.md beside this file."""

import numpy as np
import pytest

from conftest import made
from sooner.planners import Greedy, max_ticks, solve
from sooner.planners.registry import make_planner
from sooner.problem import Gains, SearchProblem, evaluate, teleport

TIMES = {"rounds": 5, "iterations": 1, "warmup_rounds": 1}


def test_evaluate(benchmark, problem):
    plan = solve(problem, Greedy()).best.plan
    problem.teleport  # noqa: B018  worked out once a problem, and timed below
    benchmark(evaluate, problem, plan)


def test_teleport(benchmark, problem):
    benchmark(teleport, problem)


def test_greedy(benchmark, problem):
    benchmark.pedantic(solve, (problem, Greedy()), **TIMES)


@pytest.mark.parametrize("name", ["lhc-gw-conv", "top2", "topn"])
def test_the_papers_planners(benchmark, problem, name):
    benchmark.pedantic(solve, (problem, make_planner(name)), **TIMES)


@pytest.mark.parametrize("ticks", [4, 16])
def test_anneal(benchmark, problem, ticks):
    """Each tick is 80,000 moves of each thread."""
    benchmark.pedantic(solve, (problem, make_planner("anneal")), {"stop": max_ticks(ticks)}, **TIMES)


@pytest.mark.parametrize("size", [100, 300, 1000])
def test_anneal_as_the_map_grows(benchmark, size):
    planner = make_planner("anneal")
    benchmark.pedantic(solve, (made(size, 10 * size), planner), {"stop": max_ticks(8)}, rounds=2, warmup_rounds=1)


@pytest.mark.parametrize("bounds", [1, 10])
def test_bounds(benchmark, problem, bounds):
    """So many tightenings of the proof, from a fresh start."""
    from sooner.bounds import bounds as proof

    value = solve(problem, make_planner("anneal"), max_ticks(4)).best.value

    def tighten() -> float:
        found = np.inf
        for _, bound in zip(range(bounds), proof(_copy(problem), lambda: value), strict=False):
            found = bound.value
        return found

    benchmark.pedantic(tighten, rounds=3, warmup_rounds=1)


def _copy(problem: SearchProblem) -> SearchProblem:
    """The same problem with nothing worked out yet."""
    gains = Gains(problem.gains.table, problem.gains.ratio)
    return SearchProblem(problem.grid, gains, problem.searchers, problem.objective)
