"""The judge: what a plan is worth. Nobody else says."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import IllegalPlanError, UnsupportedProblemError
from sooner.problem.moves import Looks
from sooner.problem.plan import Plan
from sooner.problem.search_problem import Drift, SearchProblem

__all__ = ["Evaluation", "check_legal", "evaluate", "filtered"]


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What a plan is worth, and how its worth grows over time.

    Parameters
    ----------
    problem : SearchProblem
    times : (n,) float        when something was looked at, each time once, rising (steps for cell moves)
    cdp : (n,) float          total gain up to and including that time: the CDP curve, ending at the plan's POS
    looks : (N,) int          how often each cell was looked at; (N,) float where looks are worth parts of one
    """

    problem: SearchProblem
    times: NDArray[np.float64]
    cdp: NDArray[np.float64]
    looks: NDArray[Any]

    @property
    def total(self) -> float:
        """All that the plan collects: its POS where gains are detections."""
        return float(self.cdp[-1])

    @property
    def value(self) -> float:
        """The problem's objective: the total, or minus the time to reach the target."""
        target = self.problem.objective.target
        return self.total if target is None else -self.time_to(target)

    def time_to(self, target: float) -> float:
        """First time at which the total reaches `target`; inf where it never does [Lin2014, Fig. 1]."""
        reached = self.cdp >= target
        return float(self.times[np.argmax(reached)]) if reached.any() else float("inf")

    def cdp_at(self, time: float) -> float:
        """Total collected up to and including `time`."""
        before = int(np.searchsorted(self.times, time, side="right"))
        return float(self.cdp[before - 1]) if before else 0.0

    @property
    def mean_time_if_found(self) -> float:
        """Expected time to detection, given that this plan detects; nan where it cannot."""
        gained = np.diff(self.cdp, prepend=0.0)
        return float(gained @ self.times / self.total) if self.total > 0 else float("nan")

    @property
    def early_share(self) -> float:
        """Area under the curve of gains, as a share of all of it being collected at once; nan where there is none.

        integral from 0 to T of value(t) / value(T) dt / T = 1 - (mean time of the gains) / T

        T is when the last budget ends.
        """
        return 1.0 - self.mean_time_if_found / max(searcher.until for searcher in self.problem.searchers)

    @property
    def expected_time(self) -> float:
        """Expected time until the person is found or the plan ends, whichever is first: sum of 1 - CDP."""
        gained = np.diff(self.cdp, prepend=0.0)
        return float(gained @ self.times + (1.0 - self.total) * self.times[-1])

    @property
    def efficiency(self) -> float | None:
        """Total over what teleporting collects, eq. (9) of [Lin2014]; None where there is no such reference."""
        reference = self.reference
        return self.total / reference if reference else None

    @cached_property
    def reference(self) -> float | None:
        """What teleporting collects; None where the person moves."""
        try:
            return self.problem.teleport.value
        except UnsupportedProblemError:
            return None


def evaluate(problem: SearchProblem, plan: Plan) -> Evaluation:
    """Score a plan by the problem's gains; refuse an illegal one with the reason.

    value = sum over looks of gain(cell, how often it was looked at before)      [Lin2014, eq. (7), for detection]

    Looks that are worth more or less than one, as legs have them, pay what the total grows by.

    Looks are taken in order of time over all searchers. For a person who stays the total does not depend on that
    order; for one who drifts it is the forward filter of misses and moves.

    Parameters
    ----------
    problem : SearchProblem
    plan : Plan               one sequence of actions per searcher

    Raises
    ------
    IllegalPlanError          naming searcher, step and reason

    Examples
    --------
    >>> from sooner.belief import Belief
    >>> from sooner.grid import Grid
    >>> from sooner.problem import Searcher, SearchProblem, detection_gains
    >>> gains = detection_gains(Belief.from_weights([[1.0, 2.0, 1.0]]), 0.5)
    >>> problem = SearchProblem(Grid((1, 3)), gains, (Searcher((0, 0), budget=2),))
    >>> evaluate(problem, Plan.of([0, 1, 1])).cdp
    array([0.125, 0.375, 0.5  ])
    """
    check_legal(problem, plan)
    looks = [s.moves.looks(problem.grid, s, a) for s, a in zip(problem.searchers, plan.actions, strict=True)]
    items = np.concatenate([look.items for look in looks])
    times = np.concatenate([look.times for look in looks])
    worth = None if looks[0].worth is None else np.concatenate([_worth(look) for look in looks])
    if len(looks) > 1 or worth is not None:
        order = np.argsort(times, kind="stable")
        items, times = items[order], times[order]
        worth = None if worth is None else worth[order]
    if worth is not None:
        before = _summed_before(items, worth)
        gained = problem.gains.total(items, before + worth) - problem.gains.total(items, before)
    elif problem.drift is None:
        gained = problem.gains.of(items, _looked_before(items))
    else:
        _, gained = filtered(problem.drift, items, times.astype(np.int64), until=0)
    cdp = np.cumsum(gained)
    if problem.objective.kind == "detection":
        cdp = np.where((cdp > 1.0) & (cdp < 1.0 + 1e-9), 1.0, cdp)  # rounding alone can take a probability past one
    last = np.flatnonzero(np.append(times[1:] > times[:-1], True))
    return Evaluation(problem, times[last], cdp[last], np.bincount(items, worth, minlength=problem.gains.n_cells))


def check_legal(problem: SearchProblem, plan: Plan) -> None:
    """Raise IllegalPlanError, with searcher, step and reason, unless the plan keeps every rule."""
    if len(plan.actions) != len(problem.searchers):
        count = len(plan.actions)
        came = f"a plan for {count} searcher{'s' * (count != 1)} came"
        raise IllegalPlanError(f"{came}; the problem has {len(problem.searchers)}")
    for number, (searcher, actions) in enumerate(zip(problem.searchers, plan.actions, strict=True)):
        fault = searcher.moves.fault(problem.grid, searcher, actions)
        if fault is not None:
            raise IllegalPlanError(f"searcher {number}: the plan is not legal: {fault}")


def _looked_before(items: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) int: how often the same item came earlier in the sequence."""
    order = np.argsort(items, kind="stable")
    grouped = items[order]
    first = np.append(True, grouped[1:] != grouped[:-1])
    rank = np.arange(len(items)) - np.maximum.accumulate(np.where(first, np.arange(len(items)), 0))
    before = np.empty(len(items), np.int64)
    before[order] = rank
    return before


def _summed_before(items: NDArray[np.int64], worth: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) float: how many looks the same item had before, where each is worth some."""
    order = np.argsort(items, kind="stable")
    grouped, summed = items[order], np.concatenate([[0.0], np.cumsum(worth[order])])
    first = np.append(True, grouped[1:] != grouped[:-1])
    begins = np.maximum.accumulate(np.where(first, np.arange(len(items)), 0))
    before = np.empty(len(items))
    before[order] = summed[:-1] - summed[begins]
    return np.maximum(before, 0.0)


def _worth(looks: Looks) -> NDArray[np.float64]:
    return np.ones(len(looks.items)) if looks.worth is None else looks.worth


def filtered(
    drift: Drift, items: NDArray[np.int64], times: NDArray[np.integer], until: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Forward filter: mass not yet detected is looked at, thinned, and moves once per unit of time.

    Returns the mass of each cell at time `until`, all those looks having missed, and the gain of each look. The mass
    is not normalised: it totals the probability that the person is on the map and not yet found.
    """
    mass = drift.poc.copy()
    forward = drift.transition.T.tocsr()
    gained = np.empty(len(items))
    now = 0
    for n, (item, time) in enumerate(zip(items, times, strict=True)):
        while now < time:
            mass = forward @ mass
            now += 1
        gained[n] = mass[item] * drift.glimpse[item]
        mass[item] -= gained[n]
    for _ in range(now, until):
        mass = forward @ mass
    return mass, gained
