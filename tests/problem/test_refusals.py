"""Arguments of the Python face that make no sense are refused in words."""

from dataclasses import replace

import numpy as np
import pytest

from sooner.belief import Belief
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.planners import Greedy, max_seconds, max_ticks, solve
from sooner.planners.receding import Receding
from sooner.planners.team import Team
from sooner.problem import Gains, Plan, Searcher, SearchProblem, detection_gains, evaluate
from tests.problem.test_evaluate import line


@pytest.mark.parametrize(
    "ask",
    [
        lambda: Plan.of([0, 1.5]),
        lambda: detection_gains(Belief.from_weights([[1.0]]), 0.5, 0.5, looks=1),
        lambda: Receding(Greedy(), every=0),
        lambda: Team(Greedy(), rounds=-1),
        lambda: solve(line(1, 2), Greedy(), seed=-1),
        lambda: max_seconds(-1),
        lambda: max_seconds(float("nan")),
        lambda: max_ticks(-3),
        lambda: replace(line(1, 2), searchers=(Searcher((0, 0), 5.5),)),
        lambda: replace(line(1, 2), searchers=(Searcher((0.0, 0.0), 5),)),
    ],
)
def test_an_argument_that_makes_no_sense_is_refused(ask) -> None:
    with pytest.raises(InvalidProblemError, match="came"):
        ask()


def test_gains_of_ones_own_are_summed_as_they_are() -> None:
    gains = Gains(np.array([[30.0, 10.0], [20.0, 5.0]]), np.zeros(2))
    problem = SearchProblem(Grid((1, 2)), gains, (Searcher((0, 0), 2),))
    assert evaluate(problem, Plan.of([0, 1, 0])).total == 60.0


def test_a_diagonal_past_an_obstacle_is_refused_for_its_corner() -> None:
    grid = Grid((2, 2), "square8", obstacles=np.array([[False, True], [False, False]]))
    problem = SearchProblem(grid, Gains(np.ones((4, 1)) / 4, np.zeros(4)), (Searcher((0, 0), 1),))
    with pytest.raises(ValueError, match="cuts the corner of an obstacle"):
        evaluate(problem, Plan.of([0, 3]))
