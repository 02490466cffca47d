"""Receding horizon: any planner, asked again every few steps with what is known by then.

Section VI of [Lin2014] leaves this open for targets that move and beliefs that change.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.planners.planner import Part, Planner, Ticks
from sooner.problem import (
    Gains,
    Incumbent,
    Plan,
    SearchProblem,
    evaluate,
    joined,
    remainder,
)
from sooner.problem.evaluate import filtered

__all__ = ["Receding"]


@dataclass(frozen=True)
class Receding:
    """Plan the whole flight, fly `every` steps of it, plan what is left, and so on to the end.

    At each replan the belief has drifted and every look so far has missed, so the inner planner is asked about the
    person as he will be in the middle of the next `every` steps, held still. Its answer replaces what is left of the
    flight only if the judge, who lets the person move, says that it is better: so it never does worse than the
    first plan alone.

    Parameters
    ----------
    inner : Planner        plans over cells for a person who stays
    every : int            steps flown between plans
    ticks : int            ticks that the inner planner has for each plan, where the stop rule does not share out time
    """

    inner: Planner
    every: int = 60
    ticks: int = 20

    def __post_init__(self) -> None:
        if self.every < 1 or self.ticks < 1:
            raise InvalidProblemError(f"every {self.every} steps, {self.ticks} ticks came; expected at least 1 of each")

    def handles(self, problem: SearchProblem) -> str | None:
        """What the inner planner handles, with or without drift."""
        return self.inner.handles(replace(problem, drift=None))

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield after every tick of the inner planner, always a whole flight."""
        begins = range(0, problem.searcher.steps, self.every)
        best: Incumbent | None = None
        share: float | None = 0.0
        for number, begin in enumerate(begins):
            flown = _start(problem) if best is None else best.plan.actions[0][: begin + 1]
            if len(flown) <= begin:  # the flight ends before its budget
                return

            def take(proposal: Incumbent, flown: NDArray[np.int64] = flown) -> Incumbent:
                nonlocal best
                best = _better(problem, best, joined(flown, proposal.plan.actions[0]))
                return best

            asked = held_still(remainder(problem, flown), self.every)
            share, _ = yield from self._part(number, len(begins)).run(self.inner, asked, rng, share, take)

    def _part(self, number: int, of: int) -> Part:
        """Half of the run for the first plan, the rest in equal parts."""
        if number == 0:
            return Part(0.0, 0.5 if of > 1 else 1.0, self.ticks)
        each = 0.5 / (of - 1)
        return Part(0.5 + (number - 1) * each, 0.5 + number * each, self.ticks)


def held_still(problem: SearchProblem, window: int) -> SearchProblem:
    """The same problem with the person standing where he will be in the middle of the next `window` steps."""
    if problem.drift is None:
        return problem
    nothing = np.zeros(0, np.int64)
    mass, _ = filtered(problem.drift, nothing, nothing, until=window // 2)
    return replace(problem, drift=None, gains=Gains.independent(mass, problem.drift.glimpse))


def _start(problem: SearchProblem) -> NDArray[np.int64]:
    return np.array([problem.grid.index(problem.searcher.start)])


def _better(problem: SearchProblem, best: Incumbent | None, plan: Plan) -> Incumbent:
    value = evaluate(problem, plan).value
    return Incumbent(plan, value) if best is None or value > best.value else best
