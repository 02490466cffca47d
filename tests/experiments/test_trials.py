"""Trials over processes: order, survival of a dead worker, and intervals."""

import os
from pathlib import Path

import numpy as np
import pytest

from sooner.experiments.trials import estimate, run_trials


def square(number: int) -> int:
    return number * number


def threads(_: int) -> str | None:
    return os.environ.get("OPENBLAS_NUM_THREADS")


def dies_once(mark: str) -> str:
    path = Path(mark)
    if not path.exists():
        path.touch()
        os._exit(3)
    return path.name


def fails(_: int) -> None:
    raise ValueError("this trial cannot run")


def test_answers_come_in_the_order_of_the_trials_whatever_the_workers():
    seen = []
    assert run_trials(square, range(7), workers=2, on_done=lambda *done: seen.append(done)) == [n * n for n in range(7)]
    assert seen[-1] == (7, 7)


def test_each_worker_has_one_linear_algebra_thread_and_ours_are_left_alone(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "5")
    assert run_trials(threads, [0], workers=1) == ["1"]
    assert os.environ["OPENBLAS_NUM_THREADS"] == "5"


def test_a_dead_worker_costs_no_answer(tmp_path):
    assert run_trials(dies_once, [str(tmp_path / "mark")], workers=1) == ["mark"]


def test_workers_that_keep_dying_are_reported(tmp_path):
    with pytest.raises(RuntimeError, match="1 trials have no answer"):
        run_trials(dies_once, [str(tmp_path / "mark")], workers=1, attempts=1)


def test_a_trial_that_raises_ends_the_run_with_its_own_error():
    with pytest.raises(ValueError, match="this trial cannot run"):
        run_trials(fails, [1, 2], workers=1)


@pytest.mark.parametrize("statistic", ["mean", "median"])
def test_the_interval_holds_the_statistic_and_narrows_with_more_trials(statistic):
    rng = np.random.default_rng(4)
    few, many = (estimate(rng.normal(3.0, 1.0, n), statistic) for n in (10, 400))
    for found in (few, many):
        assert found.low <= found.value <= found.high
    assert many.high - many.low < few.high - few.low


def test_the_same_sample_gives_the_same_interval():
    assert estimate([1.0, 2.0, 4.0]) == estimate([1.0, 2.0, 4.0])
