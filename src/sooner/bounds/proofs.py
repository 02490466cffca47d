"""Which proofs fit a problem, and the tightest of them so far."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from sooner.bounds.bound import Bound, Known
from sooner.bounds.connected_subgraph import ASSUMES, ConnectedSubgraph
from sooner.bounds.legs import leg_bounds
from sooner.bounds.region_lp import RegionLP
from sooner.bounds.region_soonest import region_soonest_bounds
from sooner.bounds.soonest import soonest_bounds
from sooner.problem import CellMoves, SearchProblem
from sooner.problem.leg_moves import LegMoves
from sooner.problem.regions import RegionMoves

__all__ = ["bounds"]


def bounds(problem: SearchProblem, known: Known = -inf) -> Iterator[Bound]:
    """Yield bounds that never rise, the quickest first, for as long as they are asked for.

    Over cells teleport, then connected subgraphs; for a target, the time that any plan needs. Over regions a linear
    program. Along legs what ways of their length can sweep. Nothing is yielded where nothing is proved: the person
    moves, or moves are of several kinds.

    Parameters
    ----------
    problem : SearchProblem
    known : float or callable      value of the best plan so far; a better one makes the proof quicker
    """
    if problem.drift is None and all(isinstance(each.moves, RegionMoves) for each in problem.searchers):
        over_regions = RegionLP().bounds if problem.objective.target is None else region_soonest_bounds
        yield from over_regions(problem, known)
        return
    if all(isinstance(each.moves, LegMoves) for each in problem.searchers):
        yield from leg_bounds(problem)
        return
    if problem.drift is not None or not all(isinstance(each.moves, CellMoves) for each in problem.searchers):
        return
    if problem.objective.target is not None:
        yield from soonest_bounds(problem, known)
        return
    best = Bound(problem.teleport.value * (1.0 + 1e-12), "teleport", ASSUMES)
    yield best
    for found in ConnectedSubgraph().bounds(problem, known):
        if found.value < best.value:
            best = found
        yield best
