from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.belief import Belief, predict, update_on_miss
from sooner.errors import IllegalPlanError
from sooner.grid import Grid
from sooner.motion import drift_transition
from sooner.problem import (
    CellMoves,
    Drift,
    Gains,
    Objective,
    Plan,
    Searcher,
    SearchProblem,
    detection_gains,
    evaluate,
    joined,
    remainder,
)
from tests.oracles.walks import total, walks
from tests.strategies import problems

relaxed = settings(max_examples=60)


def line(*weights: float, budget: int = 3, glimpse: float = 0.5, **searcher) -> SearchProblem:
    belief = Belief.from_weights([list(weights)])
    return SearchProblem(
        Grid((1, len(weights))), detection_gains(belief, glimpse), (Searcher((0, 0), budget, **searcher),)
    )


@pytest.mark.parametrize(("difficulty", "cdp", "percent"), [(True, 0.046900, 77.00), (False, 0.12039, 96.67)])
def test_the_authors_stored_path_scores_as_he_says(
    wisar, real_problem, difficulty: bool, cdp: float, percent: float
) -> None:
    name = "yes" if difficulty else "no"
    path = np.loadtxt(wisar / f"newyork53_T900_author_topnh_{name}diff_path.csv", delimiter=",", skiprows=1, dtype=int)
    score = evaluate(real_problem("newyork53", 900, difficulty), Plan.of(path[:, 0] * 100 + path[:, 1]))
    assert score.total == pytest.approx(cdp, abs=5e-6)
    assert 100 * score.efficiency == pytest.approx(percent, abs=5e-3)


@relaxed
@given(problem=problems(most_steps=4), pick=st.integers(0, 10**6))
def test_the_value_of_a_walk_is_the_sum_of_its_gains(problem: SearchProblem, pick: int) -> None:
    every = list(walks(problem))
    walk = every[pick % len(every)]
    score = evaluate(problem, Plan.of(walk))
    assert score.total == pytest.approx(total(problem, walk))
    assert np.array_equal(score.looks, np.bincount(walk, minlength=problem.grid.n_cells))


@relaxed
@given(problem=problems(most_steps=4), pick=st.integers(0, 10**6))
def test_cdp_rises_within_zero_and_one(problem: SearchProblem, pick: int) -> None:
    every = list(walks(problem))
    cdp = evaluate(problem, Plan.of(every[pick % len(every)])).cdp
    assert (np.diff(cdp, prepend=0.0) >= 0).all()
    assert cdp[0] >= 0
    assert cdp[-1] <= 1 + 1e-12


@relaxed
@given(problem=problems(most_steps=4), pick=st.integers(0, 10**6))
def test_turning_the_map_upside_down_changes_nothing(problem: SearchProblem, pick: int) -> None:
    grid = problem.grid
    if grid.connectivity == "hex":  # turned by half a circle, odd rows stay odd only where H is odd
        return
    every = list(walks(problem))
    walk = np.array(every[pick % len(every)])
    last = grid.n_cells - 1
    turned_grid = Grid(
        grid.shape, grid.connectivity, obstacles=None if grid.obstacles is None else grid.obstacles[::-1, ::-1]
    )
    s = problem.searcher

    def turn(cell):
        return None if cell is None else turned_grid.cell(last - grid.index(cell))

    searcher = replace(s, start=turn(s.start), end=turn(s.end), came_from=turn(s.came_from))
    gains = Gains(problem.gains.table[::-1], problem.gains.ratio[::-1])
    turned = SearchProblem(turned_grid, gains, (searcher,))
    assert evaluate(turned, Plan.of(last - walk)).total == pytest.approx(evaluate(problem, Plan.of(walk)).total)


def test_renaming_searchers_changes_nothing_and_their_looks_add_up() -> None:
    problem = line(1, 2, 3, 4)
    here, there = Searcher((0, 0), 3), Searcher((0, 3), 3)
    two = replace(problem, searchers=(here, there))
    swapped = replace(problem, searchers=(there, here))
    a, b = [0, 1, 2, 2], [3, 2, 2, 3]
    score = evaluate(two, Plan.of(a, b))
    assert score.total == pytest.approx(evaluate(swapped, Plan.of(b, a)).total)
    assert score.total == pytest.approx(
        sum(0.1 * w * (1 - 0.5**n) for w, n in zip((1, 2, 3, 4), (1, 1, 4, 2), strict=True))
    )
    assert list(score.times) == [0, 1, 2, 3]


def test_times_and_expectations_of_a_known_curve() -> None:
    score = evaluate(line(1, 1, glimpse=1.0, budget=2), Plan.of([0, 0, 1]))
    assert list(score.cdp) == [0.5, 0.5, 1.0]
    assert score.time_to(0.5) == 0
    assert score.time_to(0.6) == 2
    assert score.time_to(1.1) == np.inf
    assert score.cdp_at(1.5) == 0.5
    assert score.cdp_at(-1) == 0.0
    assert score.mean_time_if_found == pytest.approx(1.0)
    assert score.expected_time == pytest.approx(1.0)
    assert score.efficiency == pytest.approx(1.0)


def test_a_target_is_worth_minus_the_time_it_takes() -> None:
    problem = replace(line(1, 1, glimpse=1.0, budget=2), objective=Objective(target=0.9))
    assert evaluate(problem, Plan.of([0, 1])).value == -1
    assert evaluate(problem, Plan.of([0, 0])).value == -np.inf


@pytest.mark.parametrize(
    ("walk", "why"),
    [
        ([], "no cells"),
        ([0, 1, 2, 3, 3], "takes 4 steps; the budget is 3"),
        ([1, 2], "starts at"),
        ([0, 2], "not neighbours"),
        ([0, 7], "outside the map"),
        ([0, -1], "outside the map"),
    ],
)
def test_an_illegal_plan_is_refused_with_its_step_and_reason(walk: list[int], why: str) -> None:
    with pytest.raises(IllegalPlanError, match=why):
        evaluate(line(1, 1, 1, 1), Plan.of(walk))


def test_a_plan_must_end_at_the_end() -> None:
    with pytest.raises(IllegalPlanError, match="ends at"):
        evaluate(line(1, 1, 1, end=(0, 1)), Plan.of([0, 1, 2]))


def test_an_obstacle_is_named() -> None:
    problem = SearchProblem(
        Grid((1, 3), obstacles=np.array([[False, True, False]])), line(1, 1, 1).gains, (Searcher((0, 0), 3),)
    )
    with pytest.raises(IllegalPlanError, match="obstacle"):
        evaluate(problem, Plan.of([0, 1]))


@pytest.mark.parametrize(("walk", "why"), [([0, 0], "hovers"), ([0, 1, 0], "turns straight back")])
def test_a_fixed_wing_neither_hovers_nor_turns_back(walk: list[int], why: str) -> None:
    with pytest.raises(IllegalPlanError, match=why):
        evaluate(line(1, 1, 1, moves=CellMoves("fixed_wing")), Plan.of(walk))


def test_a_fixed_wing_in_flight_does_not_turn_back_on_its_first_step() -> None:
    problem = replace(line(1, 1, 1), searchers=(Searcher((0, 1), 1, moves=CellMoves("fixed_wing"), came_from=(0, 0)),))
    assert evaluate(problem, Plan.of([1, 2])).total > 0
    with pytest.raises(IllegalPlanError, match="step 1 turns straight back"):
        evaluate(problem, Plan.of([1, 0]))


def test_plans_for_another_number_of_searchers_are_refused() -> None:
    with pytest.raises(IllegalPlanError, match="2 searchers"):
        evaluate(line(1, 1), Plan.of([0], [0]))


@relaxed
@given(problem=problems(most_steps=5), pick=st.integers(0, 10**6), cut=st.integers(1, 5))
def test_a_flight_is_worth_its_start_and_its_remainder(problem: SearchProblem, pick: int, cut: int) -> None:
    every = list(walks(problem))
    walk = np.array(every[pick % len(every)])
    flown = walk[: min(cut, len(walk) - 1)]
    left = remainder(problem, flown)
    rest = walk[len(flown) - 1 :]
    before = total(problem, list(flown[:-1]))
    assert joined(flown, rest) == Plan.of(walk)
    assert before + evaluate(left, Plan.of(rest)).total == pytest.approx(evaluate(problem, Plan.of(walk)).total)


def drifting(seed: int = 0) -> SearchProblem:
    rng = np.random.default_rng(seed)
    grid = Grid((3, 3))
    poc, glimpse = rng.random(9), rng.random(9)
    drift = Drift(poc / poc.sum(), glimpse, drift_transition(grid, 0.5))
    return SearchProblem(grid, Gains.independent(drift.poc, glimpse), (Searcher((0, 0), 5),), drift=drift)


def test_a_drifting_person_is_detected_as_bayes_says_look_by_look() -> None:
    problem = drifting()
    walk = [0, 1, 4, 4, 5, 8]
    belief, survived, found = problem.drift.poc.copy(), 1.0, []
    for cell in walk:
        seen = np.where(np.arange(9) == cell, problem.drift.glimpse, 0.0)
        hit = float(belief @ seen)
        found.append(survived * hit)
        belief, survived = update_on_miss(belief, seen), survived * (1 - hit)
        belief = predict(belief, problem.drift.transition)
    assert np.diff(evaluate(problem, Plan.of(walk)).cdp, prepend=0) == pytest.approx(found)
    assert evaluate(problem, Plan.of(walk)).efficiency is None


def test_the_remainder_of_a_search_for_a_drifting_person_adds_up() -> None:
    problem = drifting(1)
    walk = np.array([0, 3, 4, 5, 5, 8])
    left = remainder(problem, walk[:3])
    before = evaluate(problem, Plan.of(walk)).cdp[1]
    assert before + evaluate(left, Plan.of(walk[2:])).total == pytest.approx(evaluate(problem, Plan.of(walk)).total)
