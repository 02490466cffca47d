"""Fewer places for nearly the same: stubs and corners that hardly find anything are left out of sorties."""

from __future__ import annotations

import numpy as np

from sooner.planners import _leg_kernels as kernels
from sooner.planners.leg_ground import LegGround, Routes
from sooner.problem import Plan, SearchProblem, evaluate
from sooner.problem.leg_moves import places_of

__all__ = ["GIVEN_UP", "tidied"]

GIVEN_UP = 0.001  # share of the total


def tidied(problem: SearchProblem, plan: Plan, give_up: float = GIVEN_UP) -> Plan:
    """The plan without places whose loss costs least, as many as cost a small share of the total together.

    An aircraft stops at every place where it turns; a pilot has to follow each.

    Parameters
    ----------
    problem : SearchProblem     along legs, of the kind that `leg_searchers` accepts
    give_up : float             share of the total

    Returns
    -------
    Plan                        legal, and worth at least 1 - give_up of the other; that itself where nothing can go
    """
    total = evaluate(problem, plan).total
    ground = LegGround(problem)
    routes = Routes(ground, [places_of(actions) for actions in plan.actions], ground.fine)
    left = give_up * routes.value
    while True:
        losses = sorted(
            (_without(routes, r, k, keep=False), r, k) for r in range(len(routes.counts)) for k in _free(routes, r)
        )
        if not losses or losses[0][0] > left:
            break
        gone: set[int] = set()
        for loss, r, k in losses:  # one of each route at a time, as places behind it change their numbers
            if r in gone:
                continue
            if loss > left:
                break
            left -= _without(routes, r, k, keep=True)
            gone.add(r)
    found = ground.plan([kept[:count].copy() for kept, count in zip(routes.points, routes.counts, strict=True)])
    legal = all(
        searcher.moves.fault(problem.grid, searcher, actions) is None
        for searcher, actions in zip(problem.searchers, found.actions, strict=True)
    )
    return found if legal and evaluate(problem, found).total >= (1 - give_up) * total * (1 - 1e-9) else plan


def _free(routes: Routes, r: int) -> range:
    """Places that may go: not home, and not where the route must end."""
    return range(1, int(routes.counts[r]) - (1 if routes.ground.ends[r] else 0))


def _without(routes: Routes, r: int, k: int, keep: bool) -> float:
    """What the routes are worth less without place k of route r; inf where it must stay. It is left out if `keep`."""
    ground, level = routes.ground, routes.level
    place = routes.points[r, k : k + 1].copy()
    seconds = routes.seconds[r]
    size = 4 * len(level.poc) + kernels.NOTES
    notes = np.empty(size, np.int64), np.empty(size), np.empty(size)
    change, _, top = kernels.replace(
        *(routes.points, routes.counts, routes.seconds, routes.effort, r, k - 1, k + 1, place, 0, ground.budgets[r]),
        *(level.poc, level.ground, level.sight, ground.paces, ground.walls, *notes, 0),
    )
    if top < 0:
        return np.inf
    if not keep:
        kernels.unput(routes.effort, notes[0], notes[1], 0, top)
        kernels.spliced(routes.points, routes.counts, r, k - 1, k, place, 1)
        routes.seconds[r] = seconds
    return -float(change)
