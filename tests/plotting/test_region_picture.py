"""Pictures of plans over regions."""

import numpy as np
import pytest

from sooner.planners import solve
from sooner.planners.region_greedy import RegionGreedy
from sooner.plotting import BITS, TARGETS, Caption, Ground, draw_region_plan
from sooner.plotting.region_picture import first_seen
from sooner.problem import Plan, SearchProblem, evaluate
from tests.planners.region_worlds import region_world


def seen(problem, plan):
    looks = sum(
        searcher.moves.cell_looks(problem.grid, actions)
        for searcher, actions in zip(problem.searchers, plan.actions, strict=True)
    )
    there = np.linspace(0.0, 1.0, problem.grid.n_cells)
    return Ground(there, looks, there / (1.0 + looks))


def flown(**world):
    problem = region_world(2, 4, 40.0, **world)
    return problem, solve(problem, RegionGreedy()).best.plan


@pytest.mark.parametrize(
    "caption",
    [
        None,
        Caption(
            "Bits", "greedy", 9.0, "proof", cell_m=2.0, measure=BITS, reference=8.0, reference_name="iterative greedy"
        ),
        Caption("Targets", measure=TARGETS),
    ],
)
@pytest.mark.parametrize("legs", [False, True])
def test_a_plan_over_regions_is_drawn_the_same_each_time(caption, legs):
    problem, plan = flown(legs=legs, ends=legs)
    drawn = draw_region_plan(evaluate(problem, plan), plan, seen(problem, plan), caption)
    assert drawn.startswith(b"\x89PNG")
    assert drawn == draw_region_plan(evaluate(problem, plan), plan, seen(problem, plan), caption)


def test_two_drones_over_regions_are_drawn():
    problem, plan = flown()
    problem = SearchProblem(problem.grid, problem.gains, problem.searchers * 2)
    plan = Plan(plan.actions * 2)
    assert draw_region_plan(evaluate(problem, plan), plan, seen(problem, plan)).startswith(b"\x89PNG")


def test_cells_are_first_seen_within_the_flight_and_just_those_that_are_looked_at():
    problem, plan = flown(legs=True, ends=True)
    first = first_seen(evaluate(problem, plan), plan)
    moves = problem.searcher.moves
    assert (np.isfinite(first) == (moves.cell_looks(problem.grid, plan.actions[0]) > 0)).all()
    assert 0 <= np.nanmin(first) <= np.nanmax(first) <= moves.seconds(plan.actions[0]) + 1.0
