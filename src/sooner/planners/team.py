"""Team: several searchers from a planner for one, each in turn against what the others leave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.planners.greedy import first_flight
from sooner.planners.planner import Part, Planner, Ticks
from sooner.problem import Incumbent, Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround
from sooner.problem.regions import RegionMoves

__all__ = ["Team", "least_flight", "left_for"]


@dataclass(frozen=True)
class Team:
    """Plan the searchers one after another, then plan each again while the others keep theirs.

    The first round gives every searcher the gains that those before it leave; each later round asks for one searcher
    at a time whether it can do better against all the others. For gains that fall with every look and an exact inner
    planner, the first round alone is worth at least half of the best team plan [Fisher1978].

    Parameters
    ----------
    inner : Planner       plans for one searcher, over cells or over regions
    rounds : int          rounds of improvement after the first
    ticks : int           ticks for each plan, where the stop rule does not share out time
    """

    inner: Planner
    rounds: int = 2
    ticks: int = 20

    def __post_init__(self) -> None:
        if self.rounds < 0 or self.ticks < 1:
            raise InvalidProblemError(f"{self.rounds} rounds, {self.ticks} ticks came; expected at least 0 and 1")

    def handles(self, problem: SearchProblem) -> str | None:
        """What the inner planner handles for every single searcher."""
        if problem.drift is not None:
            return "it plans for a person who stays"
        alone = (self.inner.handles(replace(problem, searchers=(one,))) for one in problem.searchers)
        return next((why for why in alone if why is not None), None)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield after every tick of the inner planner; until its turn a searcher flies as little as it may."""
        team = len(problem.searchers)
        best = [least_flight(problem, number, rng) for number in range(team)]
        value = evaluate(problem, Plan(tuple(best))).value
        share: float | None = 0.0
        turns = team * (1 + self.rounds)
        for turn in range(turns):
            number = turn % team

            def take(proposal: Incumbent, number: int = number) -> Incumbent:
                nonlocal value
                flights = [*best[:number], proposal.plan.actions[0], *best[number + 1 :]]
                worth = evaluate(problem, Plan(tuple(flights))).value
                if worth > value:
                    best[number], value = proposal.plan.actions[0], worth
                return Incumbent(Plan(tuple(best)), value)

            others = {n: flight for n, flight in enumerate(best) if n != number}
            part = Part(turn / turns, (turn + 1) / turns, self.ticks)
            share, _ = yield from part.run(self.inner, left_for(problem, number, others), rng, share, take)


def least_flight(problem: SearchProblem, number: int, rng: Generator) -> NDArray[np.int64]:
    """A legal flight of little worth for one searcher: the start alone, or the shortest walk over regions."""
    alone = left_for(problem, number, {})
    if isinstance(alone.searcher.moves, RegionMoves):
        return np.array(RegionGround.of(alone).quickest(), np.int64)
    return first_flight(alone, rng).actions[0]


def left_for(problem: SearchProblem, number: int, others: Mapping[int, NDArray[np.int64]]) -> SearchProblem:
    """The problem of one searcher alone, with the gains that the flights of the others leave."""
    looked = np.zeros(problem.gains.n_cells, np.int64)
    for other, flight in others.items():
        searcher = problem.searchers[other]
        np.add.at(looked, searcher.moves.looks(problem.grid, searcher, flight).items, 1)
    return replace(problem, gains=problem.gains.after(looked), searchers=(problem.searchers[number],))
