import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import InfeasibleProblemError, InvalidProblemError, UnsupportedProblemError
from sooner.grid import Grid
from sooner.motion import drift_transition
from sooner.problem import CellMoves, Drift, Gains, Objective, Reach, Searcher, SearchProblem, teleport
from tests.oracles.walks import adjacent, optimum
from tests.strategies import grids, problems

relaxed = settings(max_examples=60)
WING = CellMoves("fixed_wing")


def pose(grid: Grid, searcher: Searcher, objective: Objective | None = None) -> SearchProblem:
    gains = Gains(np.full((grid.n_cells, 1), 1 / grid.n_cells), np.zeros(grid.n_cells))
    return SearchProblem(grid, gains, (searcher,), objective or Objective())


ROCK = Grid((3, 3), obstacles=np.array([[False, True, False], [True, True, False], [False, False, False]]))


@pytest.mark.parametrize(
    ("grid", "searcher", "error", "why"),
    [
        (Grid((3, 3)), Searcher((3, 0), 4), InvalidProblemError, "map has rows"),
        (ROCK, Searcher((1, 1), 4), InvalidProblemError, "obstacle stands there"),
        (Grid((3, 3)), Searcher((0, 0), 0), InvalidProblemError, "budget of 0"),
        (Grid((3, 3)), Searcher((0, 0), 3, end=(2, 2)), InfeasibleProblemError, "4 steps from the start"),
        (ROCK, Searcher((2, 2), 9, end=(1, 1)), InvalidProblemError, "obstacle stands there"),
        (ROCK, Searcher((2, 2), 9, end=(0, 0)), InfeasibleProblemError, "cannot be reached"),
        (Grid((3, 3)), Searcher((0, 0), 5, end=(2, 2), moves=WING), InfeasibleProblemError, "give 4 or 6 steps"),
        (Grid((3, 3)), Searcher((0, 0), 5, came_from=(2, 2)), InvalidProblemError, "neighbour of the start"),
    ],
)
def test_an_impossible_searcher_is_refused_with_the_reason(grid, searcher, error, why) -> None:
    with pytest.raises(error, match=why):
        pose(grid, searcher)


def test_parity_does_not_bind_a_copter_or_a_hexagonal_grid() -> None:
    assert pose(Grid((3, 3)), Searcher((0, 0), 5, end=(2, 2))).searcher.budget == 5
    assert pose(Grid((3, 3), "hex"), Searcher((0, 0), 5, end=(2, 2), moves=WING)).searcher.budget == 5


def test_gains_of_another_map_and_no_searcher_are_refused() -> None:
    gains = Gains(np.ones((4, 1)), np.zeros(4))
    with pytest.raises(InvalidProblemError, match="the grid has 9"):
        SearchProblem(Grid((3, 3)), gains, (Searcher((0, 0), 1),))
    with pytest.raises(InvalidProblemError, match="no searcher"):
        SearchProblem(Grid((2, 2)), gains, ())


@pytest.mark.parametrize("target", [0.0, -1.0, 1.5, float("nan")])
def test_a_target_that_is_no_probability_is_refused(target: float) -> None:
    with pytest.raises(InvalidProblemError, match="target"):
        Objective(target=target)


@relaxed
@given(problem=problems(most_steps=5))
def test_no_flight_collects_more_than_teleporting(problem: SearchProblem) -> None:
    assert optimum(problem) <= teleport(problem).value + 1e-12


@relaxed
@given(problem=problems(most_steps=5))
def test_teleporting_takes_the_largest_gains_of_all(problem: SearchProblem) -> None:
    """Against a plain sort of every gain of every reachable cell."""
    searcher, near = problem.searcher, adjacent(problem)

    def flood(source: int) -> dict[int, int]:
        steps, ring = {source: 0}, [source]
        while ring:
            ring = [o for c in ring for o in near[c] if o not in steps and steps.setdefault(o, steps[c] + 1)]
        return steps

    there = flood(problem.grid.index(searcher.start))
    back = flood(problem.grid.index(searcher.end)) if searcher.end else dict.fromkeys(there, 0)
    reachable = [c for c in there if there[c] + back[c] <= searcher.budget]
    pays = [c for c in reachable if problem.gains.first[c] > 0]
    looks = 0
    if pays:
        looks = max(searcher.budget + 1 - min(there[c] for c in pays) - min(back[c] for c in pays), 0)
    every = [problem.gains.of(np.array([c]), np.array([k]))[0] for c in pays for k in range(looks)]
    assert teleport(problem).value == pytest.approx(sum(sorted(every)[::-1][:looks]))


def test_teleporting_is_no_reference_for_a_person_who_moves() -> None:
    grid = Grid((2, 2))
    drift = Drift(np.full(4, 0.25), np.ones(4), drift_transition(grid, 0.5))
    with pytest.raises(UnsupportedProblemError, match="moves"):
        teleport(SearchProblem(grid, Gains.independent(drift.poc, drift.glimpse), (Searcher((0, 0), 2),), drift=drift))


@settings(max_examples=30)
@given(grid=grids(), pick=st.integers(0, 10**6), has_end=st.booleans(), wing=st.booleans())
def test_reach_says_exactly_which_flights_can_be_finished(grid: Grid, pick: int, has_end: bool, wing: bool) -> None:
    """Against the set of all states that a flight can be in, step by step."""
    cells = [int(c) for c in np.flatnonzero(grid.passable)]
    end = cells[pick % len(cells)] if has_end else -1
    searcher = Searcher(grid.cell(cells[0]), 60, grid.cell(end) if has_end else None, WING if wing else CellMoves())
    reach = Reach(grid, searcher)
    near = adjacent(pose(grid, Searcher(grid.cell(cells[0]), 1)))
    for cell in cells:
        for came_from in [-1, *near[cell]]:
            states = {(cell, came_from)}
            for steps in range(60):
                possible = any(not has_end or c == end for c, _ in states)
                assert reach.can_go_on(cell, came_from, steps) == possible
                states = {
                    (other, c)
                    for c, before in states
                    for other in near[c] + ([] if wing else [c])
                    if not (wing and other == before)
                }


def test_a_fixed_wing_in_a_dead_end_is_refused_before_planning() -> None:
    reach = Reach(Grid((1, 4)), Searcher((0, 0), 5, moves=WING))
    with pytest.raises(InfeasibleProblemError, match="stuck"):
        reach.check()
