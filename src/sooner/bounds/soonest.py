"""The soonest that any plan can reach a target: longer than every horizon whose bound stays below it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import ceil, inf

import numpy as np

from sooner.bounds.bound import Bound, Known, known_value
from sooner.bounds.connected_subgraph import ASSUMES, ConnectedSubgraph
from sooner.problem import Objective, SearchProblem

__all__ = ["soonest_bounds"]


def soonest_bounds(
    problem: SearchProblem, known: Known = -inf, proof: ConnectedSubgraph | None = None, ticks: int = 40
) -> Iterator[Bound]:
    """Yield minus the fewest steps that any plan needs to reach the target; never rises.

    If no plan of h steps, wherever it ends, collects the target, then every plan needs h + 1 or more. Teleport rules
    out the first horizons. Then horizons between the longest ruled out and the best plan known are tried, half way,
    each for a number of ticks that doubles when all are spent.

    Parameters
    ----------
    problem : SearchProblem        with a target
    known : float or callable      value of the best plan so far: minus the time it takes
    proof : ConnectedSubgraph      how a horizon is bounded
    ticks : int                    of the proof at each horizon, the first time
    """
    proof, target, budget = proof or ConnectedSubgraph(), problem.objective.target, _budget(problem)
    if target is None:
        return
    least = max(_teleport_time(problem, target), 0.0 if _at_the_start(problem) >= target else 1.0)
    name = "teleport"
    yield Bound(-least, name, ASSUMES)
    hopeless = budget + 1
    while least <= budget:
        latest = int(min(-known_value(known) - 1, budget, hopeless - 1))  # the longest horizon worth ruling out
        if latest < max(least, 1.0):
            if hopeless > budget or least < 1.0:
                return
            hopeless, ticks = budget + 1, 2 * ticks
            continue
        horizon = (int(least) + latest + 1) // 2
        ruled_out = False
        for tick, found in enumerate(proof.bounds(_within(problem, horizon), target * (1.0 - 1e-6))):
            ruled_out = found.value < target
            if ruled_out or tick >= ticks:
                break
            yield Bound(-least, name, ASSUMES)
        if ruled_out:
            least, name = float(horizon + 1) if horizon < budget else inf, "connected subgraph, by horizon"
            yield Bound(-least, name, ASSUMES)
        else:
            hopeless = horizon


def _teleport_time(problem: SearchProblem, target: float) -> float:
    """Steps before which even teleporting searchers, all looking at once, stay below the target."""
    curve, searchers = problem.teleport.curve, len(problem.searchers)
    reached = curve * (1.0 + 1e-12) >= target
    if not reached.any():
        return inf
    return float(max(problem.teleport.delay - 1 + ceil((int(np.argmax(reached)) + 1) / searchers), 0))


def _at_the_start(problem: SearchProblem) -> float:
    """The most that the looks at time 0 can pay."""
    starts = np.array([problem.grid.index(each.start) for each in problem.searchers])
    return float(problem.gains.first[starts].sum()) * (1.0 + 1e-12)


def _budget(problem: SearchProblem) -> int:
    return max(searcher.steps for searcher in problem.searchers)


def _within(problem: SearchProblem, horizon: int) -> SearchProblem:
    """The most by `horizon`, wherever it ends."""
    searchers = tuple(replace(each, budget=min(each.steps, horizon), end=None) for each in problem.searchers)
    return replace(problem, objective=Objective(problem.objective.kind), searchers=searchers)
