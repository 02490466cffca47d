from dataclasses import replace

import numpy as np
import pytest

from sooner.belief import Belief
from sooner.grid import Grid
from sooner.planners import Greedy, solve
from sooner.plotting import Caption, draw_plan
from sooner.plotting.plan_picture import duration, first_looks, remaining
from sooner.problem import CellMoves, Objective, Plan, Searcher, SearchProblem, detection_gains, evaluate
from sooner.scenarios import bimodal, drifting_hiker

BELIEF = Belief.from_weights(np.arange(1.0, 49.0).reshape(6, 8), outside=0.1)


def problem(connectivity="square4", obstacles=None, **searcher) -> SearchProblem:
    gains = detection_gains(BELIEF, 0.5)
    settings = {"budget": 12} | searcher
    return SearchProblem(Grid((6, 8), connectivity, 20.0, obstacles), gains, (Searcher((0, 0), **settings),))


def picture(asked, plan=None, poc=BELIEF.poc, glimpse=None, caption=None) -> bytes:
    plan = plan or solve(asked, Greedy()).best.plan
    drawn = draw_plan(evaluate(asked, plan), plan, poc, glimpse, caption)
    assert drawn.startswith(b"\x89PNG")
    return drawn


@pytest.mark.parametrize("connectivity", ["square4", "square8", "hex"])
def test_every_kind_of_grid_is_drawn(connectivity):
    rocks = np.zeros((6, 8), bool)
    rocks[3, 4] = True
    picture(
        problem(connectivity, rocks, end=(5, 7), moves=CellMoves("fixed_wing" if connectivity == "hex" else "copter"))
    )


def test_the_same_plan_gives_the_same_picture():
    assert picture(problem()) == picture(problem())


@pytest.mark.parametrize(
    "caption",
    [
        Caption("Small", "greedy", bound=0.9, bound_proof="proof", step_s=2.0, cell_m=20.0),
        Caption("No metres", "greedy", bound=0.9),
        Caption(r"$\frac{1}{$ two \ lines" + "\n and 山 " + "long " * 99, "greedy", cell_m=2000.0),
        None,
    ],
)
def test_a_picture_says_what_is_known(caption):
    picture(problem(), caption=caption, glimpse=np.linspace(0, 1, 48).reshape(6, 8))


def test_a_target_is_drawn():
    asked = replace(problem(), objective=Objective("detection", 0.1))
    picture(asked, solve(problem(), Greedy()).best.plan, caption=Caption(bound=-3.0))


def test_a_person_who_drifts_is_drawn():
    asked = drifting_hiker(size=12, steps=20)
    picture(asked, Plan.of([asked.grid.index(asked.searcher.start)]), asked.drift.poc.reshape(12, 12))


def test_two_searchers_are_drawn():
    asked = problem()
    picture(
        replace(asked, searchers=(asked.searcher, replace(asked.searcher, start=(2, 2)))), Plan.of([0, 1], [18, 19])
    )


def test_a_flight_that_stays_where_it_starts_on_a_map_of_one_cell_is_drawn():
    gains = detection_gains(Belief.from_weights([[1.0]]), 1.0)
    picture(SearchProblem(Grid((1, 1)), gains, (Searcher((0, 0), 3),)), Plan.of([0]), np.ones((1, 1)))


def test_what_is_drawn_as_unseen_is_what_is_left():
    scenario = bimodal(size=20)
    asked = scenario.problem(60)
    plan = solve(asked, Greedy()).best.plan
    poc = Belief.from_weights(scenario.weights).poc
    evaluation = evaluate(asked, plan)
    assert remaining(evaluation, poc).sum() == pytest.approx(1.0 - evaluation.total)
    first = first_looks(evaluation, plan)
    assert (np.isfinite(first) == (evaluation.looks > 0)).all()
    assert first[plan.actions[0][0]] == 0.0


def test_durations_read_as_clocks():
    assert duration(900, 2.0) == "30:00 min"
    assert duration(4, None) == "4 steps"
