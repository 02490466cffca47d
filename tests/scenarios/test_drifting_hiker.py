import numpy as np
import pytest

from sooner.planners import Greedy, solve
from sooner.planners.receding import Receding
from sooner.scenarios.drifting_hiker import drifting_hiker


def test_the_same_seed_makes_the_same_search_and_another_seed_another() -> None:
    one, same, other = drifting_hiker(1), drifting_hiker(1), drifting_hiker(2)
    assert np.array_equal(one.drift.poc, same.drift.poc)
    assert not np.array_equal(one.drift.poc, other.drift.poc)


def test_nobody_leaves_the_map_by_drifting() -> None:
    assert drifting_hiker(0).drift.transition.sum(axis=1) == pytest.approx(1.0)


def test_without_moving_it_is_the_same_search_for_a_person_who_stays() -> None:
    assert drifting_hiker(3, move=0.0).drift is None
    assert drifting_hiker(3, move=0.0).gains.first == pytest.approx(drifting_hiker(3).gains.first)


def test_asking_again_finds_more_of_those_who_walk_on() -> None:
    gained = []
    for seed in range(6):
        problem = drifting_hiker(seed, size=20, steps=60)
        once, often = (solve(problem, Receding(Greedy(), every), seed=seed).best.value for every in (60, 10))
        gained.append(often - once)
    assert min(gained) >= 0
    assert np.mean(gained) > 0.02
