"""Soonest: reach a given CDP in the fewest steps, the second quality metric of [Lin2014] (Fig. 1).

The most by a short horizon is another flight than the start of the most by a long one. The shortest horizon at which
an inner planner still reaches the target is the answer; every probe of a horizon costs one run of that planner.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, inf

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InfeasibleProblemError
from sooner.planners.greedy import Greedy, first_flight
from sooner.planners.planner import Part, Planner, Ticks
from sooner.problem import Evaluation, Incumbent, Objective, Plan, SearchProblem, evaluate, joined, remainder

__all__ = ["Soonest"]


@dataclass(frozen=True)
class Soonest:
    """Shrink the horizon while the inner planner still reaches the target in it.

    Where the plan for the whole budget crosses the target is a first answer. Then horizons between the longest that
    failed and the best answer are probed: half way down after a success, and after a failure longer by what is
    missing over what teleporting gains per step there. Once the flight has reached the target it goes on greedily,
    and home where there is an end.

    Parameters
    ----------
    inner : Planner        plans for the most by the end
    part : float           share of the remaining run that one probe may take, where its length is known
    ticks : int            ticks of a probe where it is not; doubled when every horizon has failed
    """

    inner: Planner
    part: float = 0.25
    ticks: int = 40

    def handles(self, problem: SearchProblem) -> str | None:
        """A target, and whatever the inner planner handles without one."""
        if problem.objective.target is None:
            return "it needs a target to reach soonest; give detection_target"
        return self.inner.handles(_most(problem))

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield after every tick of every probe."""
        bracket = _Bracket.of(problem)
        start = first_flight(_most(problem), rng)
        best, share, ticks, ended = Incumbent(start, evaluate(problem, start).value), 0.0, self.ticks, False
        yield best
        known: float | None = share
        while not bracket.closed and not (ended and bracket.exhausted):
            asked = _most(problem) if bracket.whole else _most(problem, bracket.horizon)
            total, answer, whole = 0.0, bracket.answer, bracket.whole

            def take(proposal: Incumbent, asked: SearchProblem = asked) -> Incumbent:
                nonlocal best, total
                total = proposal.value
                best = _better(problem, best, asked, proposal.plan)
                return best

            def enough(answer: float = answer, whole: bool = whole) -> bool:
                return -best.value < answer and not whole

            part = Part(share, share + self.part * (1.0 - share), ticks)
            known, ended = yield from part.run(self.inner, asked, rng, known, take, enough)
            share = share if known is None else known
            bracket = bracket.after_success(-best.value) if -best.value < answer else bracket.after_failure(total)
            ticks = ticks * 2 if bracket.exhausted else ticks


@dataclass(frozen=True)
class _Bracket:
    """The horizon to try next, between the longest that failed and the best answer."""

    target: float
    curve: NDArray[np.float64]  # what teleporting collects in 1, 2, ... looks
    least: int  # no plan is quicker
    failed: int
    answer: float
    horizon: int
    whole: bool = True
    exhausted: bool = False

    @classmethod
    def of(cls, problem: SearchProblem) -> _Bracket:
        target, budget = problem.objective.target or inf, problem.searcher.steps
        reference = problem.teleport
        soonest = reference.time_to(target)
        least = int(min(soonest, budget))
        return cls(target, reference.curve, least, least - 1, inf, budget)

    def after_success(self, answer: float) -> _Bracket:
        """Half way from the answer down to the longest horizon that failed."""
        failed = min(self.failed, int(answer) - 1)
        horizon = max((int(answer) + failed) // 2, 1)
        return replace(self, answer=answer, failed=failed, horizon=horizon, whole=False, exhausted=False)

    def after_failure(self, total: float) -> _Bracket:
        """Longer by what was missing, at the rate at which teleporting gains there."""
        if self.whole:  # not even the whole budget reaches the target: there is nothing else to try
            return replace(self, exhausted=True)
        index = min(self.horizon, len(self.curve) - 1)
        rate = self.curve[index] - self.curve[max(index - 1, 0)]
        missing = ceil((self.target - total) / rate) if rate > 0 else 1
        failed, longest = max(self.failed, self.horizon), int(self.answer) - 1
        horizon = max(min(self.horizon + max(missing, 1), longest), 1)
        return replace(self, failed=failed, horizon=horizon, exhausted=failed >= longest)

    @property
    def closed(self) -> bool:
        """Whether the answer cannot be improved."""
        return self.answer <= self.least


def _most(problem: SearchProblem, horizon: int | None = None) -> SearchProblem:
    """The most by `horizon`, wherever it ends; or by the whole budget, at the problem's end."""
    objective = Objective(problem.objective.kind)
    if horizon is None:
        return replace(problem, objective=objective)
    return replace(problem, objective=objective, searchers=(replace(problem.searcher, budget=horizon, end=None),))


def _better(problem: SearchProblem, best: Incumbent, asked: SearchProblem, plan: Plan) -> Incumbent:
    """The better of the best so far and this plan, flown on to the end of the whole budget."""
    target = problem.objective.target or inf
    score: Evaluation = evaluate(asked, plan)
    time = score.time_to(target)
    if time == inf and best.value == -inf:  # nothing has reached the target yet: keep what comes closest
        closer = score.total > evaluate(problem, best.plan).total
        return Incumbent(plan, -inf) if closer and asked.searcher.steps == problem.searcher.steps else best
    if -time <= best.value:
        return best
    whole = plan
    if asked.searcher.steps < problem.searcher.steps:
        try:
            whole = _flown_on(problem, plan.actions[0][: int(time) + 1])
        except InfeasibleProblemError:  # from there it could not get home
            return best
    return Incumbent(whole, evaluate(problem, whole).value)


def _flown_on(problem: SearchProblem, flown: NDArray[np.int64]) -> Plan:
    left = _most(remainder(problem, flown))
    rest = next(Greedy().plans(left, np.random.default_rng(0)))
    return joined(flown, rest.plan.actions[0])
