"""The same legs, earlier: sorties flown the other way round, or by another battery, where that finds sooner."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from sooner.problem import Plan, SearchProblem, evaluate
from sooner.problem.leg_moves import LegMoves

__all__ = ["earlier_within"]

SAME = 1e-9  # of the total, which rounding may cost


def earlier_within(problem: SearchProblem, plan: Plan, seconds: float) -> Plan:
    """A plan along the same legs that collects the same in all and, by the judge, more of it early.

    Flights are reversed one by one, and exchanged two by two, for as long as that helps and the time lasts.

    Parameters
    ----------
    problem : SearchProblem     along legs
    seconds : float             of wall-clock time, about
    """
    until = time.monotonic() + seconds
    best, found = plan, evaluate(problem, plan)
    if not found.total > 0:
        return plan
    least, share, improved = found.total * (1 - SAME), found.early_share, True
    while improved:
        improved = False
        for flights in _others(problem, best):
            if time.monotonic() > until:
                return best
            proposed = Plan(flights)
            told = evaluate(problem, proposed)
            if told.total >= least and told.early_share > share * (1 + SAME):
                best, share, improved = proposed, told.early_share, True
                break
    return best


def _others(problem: SearchProblem, plan: Plan) -> Iterator[tuple[NDArray[np.int64], ...]]:
    """Legal flights that differ from the plan's by one that is reversed, or two that are exchanged."""
    flights, searchers = plan.actions, problem.searchers

    def may(number: int, actions: NDArray[np.int64]) -> bool:
        return searchers[number].moves.fault(problem.grid, searchers[number], actions) is None

    for number, actions in enumerate(flights):
        if may(number, actions[::-1]):
            yield (*flights[:number], actions[::-1], *flights[number + 1 :])
    for one, other in combinations(range(len(flights)), 2):
        first, second = searchers[one].moves, searchers[other].moves
        assert isinstance(first, LegMoves)
        assert isinstance(second, LegMoves)
        if first.home == second.home and may(one, flights[other]) and may(other, flights[one]):
            changed = list(flights)
            changed[one], changed[other] = flights[other], flights[one]
            yield tuple(changed)
