"""Many trials over a few processes, and the numbers that sum them up."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any, TypeVar

import numpy as np

__all__ = ["Estimate", "estimate", "run_trials"]

T = TypeVar("T")
R = TypeVar("R")

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


def run_trials(
    run: Callable[[T], R],
    trials: Sequence[T],
    workers: int,
    on_done: Callable[[int, int], None] | None = None,
    attempts: int = 3,
) -> list[R]:
    """What `run` answers for each trial, in the order of the trials.

    Workers are fresh processes with one linear-algebra thread each. Where one dies (killed, out of memory) the pool
    is built anew for the trials that are missing, up to `attempts` times; a trial that raises ends the run.

    Parameters
    ----------
    run : callable             a module-level function, and its trials and answers, that can be pickled
    workers : int              processes; 1 runs one trial after the other, still in a process of its own
    on_done : callable         is told how many trials are done, and of how many

    Raises
    ------
    RuntimeError               if workers keep dying
    """
    answers: dict[int, R] = {}
    for _ in range(attempts):
        missing = [number for number in range(len(trials)) if number not in answers]
        if not missing:
            break
        try:
            for number, answer in _pooled(run, trials, missing, workers):
                answers[number] = answer
                if on_done is not None:
                    on_done(len(answers), len(trials))
        except BrokenProcessPool:
            continue
    if len(answers) < len(trials):
        raise RuntimeError(
            f"workers died {attempts} times; {len(trials) - len(answers)} trials have no answer "
            "(out of memory? a script that starts workers also needs: if __name__ == '__main__')"
        )
    return [answers[number] for number in range(len(trials))]


def _pooled(
    run: Callable[[T], R], trials: Sequence[T], numbers: Sequence[int], workers: int
) -> Iterator[tuple[int, R]]:
    with _one_thread_each(), ProcessPoolExecutor(max(workers, 1), mp_context=get_context("spawn")) as pool:
        asked = {pool.submit(run, trials[number]): number for number in numbers}
        try:
            for done in as_completed(asked):
                yield asked[done], done.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Children inherit the environment they are spawned in."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@dataclass(frozen=True)
class Estimate:
    """A statistic of n trials, with the 95 % interval of its bootstrap."""

    value: float
    low: float
    high: float
    n: int


def estimate(sample: Sequence[float], statistic: str = "mean", resamples: int = 4000) -> Estimate:
    """Mean or median of a sample, with a percentile bootstrap (always the same resamples).

    Examples
    --------
    >>> estimate([2.0, 2.0, 2.0])
    Estimate(value=2.0, low=2.0, high=2.0, n=3)
    """
    of: Any = {"mean": np.mean, "median": np.median}[statistic]
    values = np.asarray(sample, np.float64)
    drawn = values[np.random.default_rng(0).integers(0, len(values), (resamples, len(values)))]
    low, high = np.percentile(of(drawn, axis=1), [2.5, 97.5])
    return Estimate(float(of(values)), float(low), float(high), len(values))
