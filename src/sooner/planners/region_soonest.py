"""Soonest over regions: reach a given CDP in the fewest seconds.

As over cells (`sooner.planners.soonest`): the most by a short time is another flight than the start of the most by a
long one, so the shortest time is sought by which an inner planner still collects the target.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.random import Generator

from sooner.bounds.region_soonest import within
from sooner.errors import InfeasibleProblemError
from sooner.planners.planner import Part, Planner, Ticks
from sooner.planners.region_greedy import RegionGreedy
from sooner.planners.team import least_flight, left_for
from sooner.problem import Incumbent, Objective, Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround
from sooner.problem.regions import RegionMoves

__all__ = ["RegionSoonest"]


@dataclass(frozen=True)
class RegionSoonest:
    """Shorten the time while the inner planner still collects the target in it.

    The plan for the whole budget is a first answer. Then times between the longest that failed and the best answer are
    tried, half way, wherever the flight is by then; having reached the target it goes on greedily, and home where
    there is an end. A plan from which a searcher could not come home is no answer.

    Parameters
    ----------
    inner : Planner        plans over regions for the most by the end, for one searcher or for several
    part : float           share of the remaining run that one time may take, where its length is known
    ticks : int            of each time where it is not
    near : float           share of the answer by which the longest time that failed is shorter, at the end
    """

    inner: Planner
    part: float = 0.2
    ticks: int = 40
    near: float = 0.005

    def handles(self, problem: SearchProblem) -> str | None:
        """A target over regions, and whatever the inner planner handles without one."""
        if problem.objective.target is None:
            return "it needs a target to reach soonest; give detection_target"
        if not all(isinstance(each.moves, RegionMoves) for each in problem.searchers):
            return "it plans moves over regions"
        return self.inner.handles(_most(problem))

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield after every tick of every time that is tried."""
        first = Plan(tuple(least_flight(_most(problem), number, rng) for number in range(len(problem.searchers))))
        best = _greedy(problem, Incumbent(first, evaluate(problem, first).value))
        share: float | None = yield best
        failed, answer, tried = 0.0, inf, max(searcher.budget for searcher in problem.searchers)
        asked: SearchProblem | None = _most(problem)
        while asked is not None:

            def take(proposal: Incumbent, asked: SearchProblem = asked) -> Incumbent:
                nonlocal best
                best = _better(problem, best, asked, proposal.plan)
                return best

            def enough(tried: float = tried, first: bool = answer == inf) -> bool:
                return -best.value <= tried and not first

            begin = share or 0.0
            part = Part(begin, begin + self.part * (1.0 - begin), self.ticks)
            share, ended = yield from part.run(self.inner, asked, rng, share, take, enough)
            if best.value > -inf:
                failed, answer = (tried if -best.value > tried else failed), -best.value
                tried, asked = self._next(problem, failed, answer)
            elif ended or share is None:  # not even the whole budget is enough, as far as we know
                return

    def _next(self, problem: SearchProblem, failed: float, answer: float) -> tuple[float, SearchProblem | None]:
        """The next time to try, half way, and what is asked; None where there is none left."""
        while answer - failed > self.near * answer:
            seconds = (failed + answer) / 2.0
            try:
                return seconds, within(problem, seconds)
            except InfeasibleProblemError:  # too short for any action
                failed = seconds
        return answer, None


def _most(problem: SearchProblem) -> SearchProblem:
    """The same search for the most by the end."""
    return replace(problem, objective=Objective(problem.objective.kind))


def _greedy(problem: SearchProblem, best: Incumbent) -> Incumbent:
    """The better of this plan and those that begin with any one action of each searcher and go on greedily."""
    firsts = [
        [way for way, _ in RegionGround.of(left_for(_most(problem), number, {})).ways_from(searcher.moves.first)]
        for number, searcher in enumerate(problem.searchers)
        if isinstance(searcher.moves, RegionMoves)
    ]
    for step in range(max(map(len, firsts))):
        found = _flown_on(problem, Plan.of(*([ways[step % len(ways)]] for ways in firsts)))
        value = -inf if found is None else evaluate(problem, found).value
        if found is not None and value > best.value:
            best = Incumbent(found, value)
    return best


def _better(problem: SearchProblem, best: Incumbent, asked: SearchProblem, plan: Plan) -> Incumbent:
    """The better of the best so far and this plan, flown on to the end of the whole budget."""
    score = evaluate(asked, plan)
    time = score.time_to(problem.objective.target or inf)
    if time == inf and best.value == -inf:  # nothing has reached the target yet: keep what comes closest
        whole = asked.searchers == problem.searchers
        return Incumbent(plan, -inf) if whole and score.total > evaluate(problem, best.plan).total else best
    if time < inf and -time <= best.value:
        return best
    found = _flown_on(problem, plan)
    if found is None:  # from there somebody could not get home
        return best
    value = evaluate(problem, found).value
    return Incumbent(found, value) if value > best.value else best


def _flown_on(problem: SearchProblem, plan: Plan) -> Plan | None:
    """The plan, with more actions of each searcher in turn while there is time, and home; None if that is too far."""
    flights = list(plan.actions)
    for number, searcher in enumerate(problem.searchers):
        alone = left_for(_most(problem), number, {n: flight for n, flight in enumerate(flights) if n != number})
        ground, moves, flown = RegionGround.of(alone), searcher.moves, flights[number]
        assert isinstance(moves, RegionMoves)
        here = ground.walked(flown.tolist())
        flights[number] = np.array([*flown.tolist(), *ground.homeward(here)], np.int64)
        if moves.fault(problem.grid, searcher, flights[number]) is not None:
            return None
        seen = replace(moves, back=-1).looks(problem.grid, searcher, flown).items
        looked = np.bincount(seen, minlength=problem.gains.n_cells)
        later = replace(moves, first=here, depart=-1)
        left_s = searcher.budget - moves.seconds(flown) + later.leg_s  # whose way back is still to be flown
        rest = replace(searcher, budget=left_s, moves=later)
        try:
            left = replace(alone, gains=alone.gains.after(looked), searchers=(rest,))
        except InfeasibleProblemError:  # no time for another action
            continue
        more = next(RegionGreedy().plans(left, np.random.default_rng(0))).plan.actions[0]
        flights[number] = np.concatenate([flown, more])
    return Plan(tuple(flights))
