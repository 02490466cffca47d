"""The soonest that any plan over regions can reach a target: later than every time by which no plan collects it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf

import numpy as np

from sooner.bounds.bound import Bound, Known, known_value
from sooner.bounds.region_lp import ASSUMES, RegionLP
from sooner.errors import InfeasibleProblemError
from sooner.problem import Objective, SearchProblem
from sooner.problem.regions import RegionMoves

__all__ = ["region_soonest_bounds", "within"]

PROOF = "linear program over regions, by time"
ROUNDS = 8  # of each program: what is not ruled out by then is rarely ruled out later
NEAR = 0.002  # of the best time known: no nearer is worth another program


def within(problem: SearchProblem, seconds: float) -> SearchProblem:
    """The most by `seconds`, wherever each searcher then is.

    Raises
    ------
    InfeasibleProblemError     if that is too little for some searcher's first action
    """
    searchers = []
    for searcher in problem.searchers:
        assert isinstance(searcher.moves, RegionMoves)
        moves = replace(searcher.moves, last=-1, back=-1)
        searchers.append(replace(searcher, budget=min(searcher.budget, seconds), end=None, moves=moves))
    return replace(problem, objective=Objective(problem.objective.kind), searchers=tuple(searchers))


def region_soonest_bounds(problem: SearchProblem, known: Known = -inf) -> Iterator[Bound]:
    """Yield minus the fewest seconds that any plan needs to reach the target; never rises.

    Whatever is seen by time h was seen in actions that had ended by then, which are a plan for h seconds, or in one
    more of each searcher, an action or its way to the end. So nobody has collected the target by h where the bound
    for h seconds, and the most that one more pays beside it, stay below it; or where the bound for h and the longest
    action does, with what the ways to the end pay. Times between the longest ruled out and the best plan known are
    tried, half way.

    Parameters
    ----------
    problem : SearchProblem        with a target, over regions
    known : float or callable      value of the best plan so far: minus the time it takes
    """
    target, budget = problem.objective.target, max(searcher.budget for searcher in problem.searchers)
    if target is None:
        return
    spare = {(0.0, _paid(problem, last=False)), (_longest_s(problem), _paid(problem, last=True))}
    ruled_out, failed = 0.0, budget
    yield Bound(-ruled_out, PROOF, ASSUMES)
    if _ruled_out(problem, budget, target, {(0.0, _paid(problem, last=True))}):
        yield Bound(-inf, PROOF, ASSUMES)
        return
    while True:
        best = min(-known_value(known), budget)
        latest = min(best, failed)
        if latest - ruled_out <= NEAR * best:
            return
        time = (ruled_out + latest) / 2.0
        if _ruled_out(problem, time, target, spare):
            ruled_out = time
        else:
            failed = time
        yield Bound(-ruled_out, PROOF, ASSUMES)


def _ruled_out(problem: SearchProblem, seconds: float, target: float, spare: set[tuple[float, float]]) -> bool:
    """Whether no plan collects the target by then: with so many more seconds, or so much more beside it."""
    enough = target * (1.0 - 1e-9)
    for more_s, beside in spare:
        try:
            asked = within(problem, seconds + more_s)
        except InfeasibleProblemError:
            continue
        if any(
            found.value + beside < enough for found in RegionLP(rounds=ROUNDS).bounds(asked, enough - beside - 1e-12)
        ):
            return True
    return False


def _paid(problem: SearchProblem, last: bool) -> float:
    """The most that one action of each searcher pays, its legs among them; or what the ways to the end pay."""
    total = 0.0
    for searcher in problem.searchers:
        moves = searcher.moves
        assert isinstance(moves, RegionMoves)
        looked = problem.gains.of(moves.atoms.covered, moves.atoms.before)
        actions = np.repeat(np.arange(len(moves.atoms.starts) - 1), np.diff(moves.atoms.starts))
        paid = np.bincount(actions, looked, len(moves.atoms.starts) - 1)
        total += (float(paid[moves.back]) if moves.back >= 0 else 0.0) if last else float(paid.max(initial=0.0))
    return total


def _longest_s(problem: SearchProblem) -> float:
    """Seconds of the longest action of any searcher."""
    moves = [searcher.moves for searcher in problem.searchers]
    return max(float(each.graph.seconds.max()) for each in moves if isinstance(each, RegionMoves))
