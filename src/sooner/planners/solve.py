"""solve: run a planner under a stop rule, and keep the best of it whatever happens."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from math import isfinite

import numpy as np

from sooner.errors import InvalidProblemError
from sooner.planners.planner import Planner, follow, refuse_unhandled
from sooner.planners.stop import Progress, StopRule, never
from sooner.problem import Incumbent, SearchProblem

__all__ = ["Solution", "Status", "solve"]


class Status(Enum):
    """Why `solve` returned."""

    PROVED = "proved"  # the value has met the bound
    STOPPED = "stopped"  # the stop rule said so
    FINISHED = "finished"  # the planner had nothing more to try
    INTERRUPTED = "interrupted"  # someone pressed Ctrl-C; the best plan is kept


@dataclass(frozen=True)
class Solution:
    """The best plan, what is proved, and how it came about.

    Parameters
    ----------
    best : Incumbent
    status : Status
    seed : int
    seconds : float                 wall-clock time in all
    trace : tuple of Progress       a row for each improvement of value or bound, and the last tick
    """

    best: Incumbent
    status: Status
    seed: int
    seconds: float
    trace: tuple[Progress, ...]


def solve(
    problem: SearchProblem,
    planner: Planner,
    stop: StopRule | None = None,
    seed: int = 0,
    on_tick: Callable[[Progress], None] | None = None,
) -> Solution:
    """Run `planner` on `problem` until the rule says stop, the planner has finished, or the bound is met.

    The same seed and the same `max_ticks` give the same plan. Ctrl-C is an answer too: the best plan so far.

    Parameters
    ----------
    stop : StopRule             `max_seconds(10) | gap_below(0.01)`; None lets the planner finish
    on_tick : callable          is shown the progress of every tick

    Raises
    ------
    UnsupportedProblemError     where the planner does not handle the problem, with its sentence why
    KeyboardInterrupt           only if nothing had been found yet

    Examples
    --------
    >>> from sooner.belief import Belief
    >>> from sooner.grid import Grid
    >>> from sooner.planners import Greedy, solve
    >>> from sooner.problem import Searcher, SearchProblem, detection_gains
    >>> gains = detection_gains(Belief.from_weights([[1.0, 2.0, 1.0]]), 1.0)
    >>> problem = SearchProblem(Grid((1, 3)), gains, (Searcher((0, 0), budget=2),))
    >>> solution = solve(problem, Greedy())
    >>> solution.best.value, solution.status.value
    (1.0, 'finished')
    """
    refuse_unhandled(problem, planner)
    if seed < 0:
        raise InvalidProblemError(f"seed {seed} came; expected a whole number of at least 0")
    rule = stop or never()
    ticks = planner.plans(problem, np.random.default_rng(seed))
    run = _Run(time.perf_counter())
    try:
        status = _drive(ticks, rule, run, on_tick)
    except KeyboardInterrupt:
        if run.best is None:
            raise
        status = Status.INTERRUPTED
    finally:
        if isinstance(ticks, Generator):
            ticks.close()
    if run.best is None:
        raise RuntimeError(f"{type(planner).__name__} ended without a plan; a planner must yield at least once")
    return Solution(run.best, status, seed, time.perf_counter() - run.began, tuple(run.trace))


class _Run:
    """The running state of one solve."""

    def __init__(self, began: float) -> None:
        self.began = began
        self.best: Incumbent | None = None
        self.ticks = 0
        self.trace: list[Progress] = []

    def take(self, incumbent: Incumbent) -> Progress:
        """Keep the better plan and the tighter bound; a planner that slips back does no harm."""
        self.ticks += 1
        improved = self.best is None or incumbent.value > self.best.value or incumbent.bound < self.best.bound
        self.best = incumbent if self.best is None else _better(self.best, incumbent)
        now = Progress(time.perf_counter() - self.began, self.ticks, self.best.value, self.best.bound)
        if improved:
            self.trace.append(now)
        return now


def _better(old: Incumbent, new: Incumbent) -> Incumbent:
    value = new if new.value >= old.value else old
    bound = new if new.bound < old.bound else old
    return replace(value, bound=bound.bound, bound_proof=bound.bound_proof, bound_assumes=bound.bound_assumes)


def _drive(ticks: Iterator[Incumbent], rule: StopRule, run: _Run, on_tick: Callable[[Progress], None] | None) -> Status:
    advance = follow(ticks)
    share: float | None = 0.0
    while True:
        incumbent = advance(share)
        if incumbent is None:
            return Status.FINISHED
        progress = run.take(incumbent)
        if on_tick is not None:
            on_tick(progress)
        if progress.bound <= progress.value and isfinite(progress.value):
            return Status.PROVED
        if rule.met(progress):
            if run.trace[-1] != progress:
                run.trace.append(progress)
            return Status.STOPPED
        share = rule.share(progress)
