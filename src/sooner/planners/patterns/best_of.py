"""A pattern as a planner: drawn in the few ways that its definition leaves open, the best of them by the judge."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from sooner.decomposition.patterns import Tracks
from sooner.errors import InvalidProblemError
from sooner.planners.leg_ground import LegGround
from sooner.planners.patterns.searched import Searched, connected
from sooner.planners.patterns.sorties import shared_out
from sooner.planners.planner import Ticks
from sooner.problem import Incumbent, SearchProblem, evaluate

__all__ = ["best_of"]


def best_of(problem: SearchProblem, drawn: Callable[[Searched], Iterable[Tracks]]) -> Ticks:
    """Yield the way home at once, then the best so far after every way in which the pattern was drawn.

    Parameters
    ----------
    problem : SearchProblem     along legs
    drawn : callable            the pattern's tracks over connected ground, in one way after another
    """
    ground = LegGround(problem)
    best = [ground.least(number) for number in range(len(ground.moves))]
    plan = ground.plan(best)
    incumbent = Incumbent(plan, evaluate(problem, plan).value)
    yield incumbent
    for searched in connected(ground):
        for tracks in drawn(searched):
            try:
                routes = shared_out(ground, tracks, searched.numbers)
            except InvalidProblemError:  # parts that only just hang together: no way that planners may fly
                continue
            plan = ground.plan([routes.get(number, route) for number, route in enumerate(best)])
            value = evaluate(problem, plan).value
            if value > incumbent.value:
                incumbent = Incumbent(plan, value)
                best = [routes.get(number, route) for number, route in enumerate(best)]
            yield incumbent
