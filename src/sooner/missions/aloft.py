"""A team in flight, between one plan and the next: what it still will look at, and from where it can be sent anew."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sooner.missions.plan_trials import PlanLooks
from sooner.problem import CellMoves, Plan, Searcher, SearchProblem
from sooner.problem.regions import RegionMoves

__all__ = ["Aloft", "Stretch"]

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Aloft:
    """Drones in flight, from the moment of a plan on.

    Parameters
    ----------
    problem : SearchProblem    of the drones that have something to plan, each from where it will be free
    plan : Plan                what they fly from there
    numbers : (S,) int         which searchers of the mission these are
    begins : (S,) float        when each is free
    since : float              when the plan is made: some drone is free then, others may still fly what they began
    pending : PlanLooks        looks that are still to come of what was begun before, of the landed as well
    """

    problem: SearchProblem
    plan: Plan
    numbers: Ints
    begins: Floats
    since: float
    pending: PlanLooks

    @classmethod
    def of(cls, problem: SearchProblem, plan: Plan) -> Aloft:
        """At the start."""
        team = len(problem.searchers)
        nothing = PlanLooks(np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.int64))
        return cls(problem, plan, np.arange(team), np.zeros(team), 0.0, nothing)

    def until(self, every: float) -> Stretch:
        """The looks until the next plan, which is made when some drone comes free after so much time."""
        stops = [self._stop(n, self.since + every) for n in range(len(self.numbers))]
        going = [n for n, stop in enumerate(stops) if stop is not None]
        flown = [self._looks(n, None if stop is None else stop[0]) for n, stop in enumerate(stops)]
        ahead = PlanLooks.joined([self.pending, *flown])
        if not going:
            return Stretch(self, ahead, None)
        free = {n: stop for n, stop in enumerate(stops) if stop is not None}
        now = min(time for _, time in free.values())
        soon = ahead.times <= now
        left = Aloft(
            replace(self.problem, searchers=tuple(self._further(n, *free[n]) for n in going)),
            Plan(tuple(self.plan.actions[n][free[n][0] :] for n in going)),
            self.numbers[going],
            np.array([free[n][1] for n in going]),
            now,
            ahead.where(~soon),
        )
        return Stretch(self, ahead.where(soon), left)

    def _stop(self, number: int, due: float) -> tuple[int, float] | None:
        """Before which of its actions a drone is first free from then on, and when; None where it lands before."""
        searcher, actions = self.problem.searchers[number], self.plan.actions[number]
        if isinstance(searcher.moves, RegionMoves):
            moves = searcher.moves
            leg_s = float(moves.graph.seconds[moves.depart]) if moves.depart >= 0 else 0.0
            after = leg_s + np.append(0.0, np.cumsum(moves.graph.seconds[actions[:-1]]))
        else:  # the look at where the rest begins is part of the rest
            after = np.arange(len(actions) - 1, dtype=np.float64)
        times = self.begins[number] + after
        found = np.flatnonzero(times >= due)
        return (int(found[0]), float(times[found[0]])) if len(found) else None

    def _looks(self, number: int, stop: int | None) -> PlanLooks:
        """Looks of a drone before a stop, or until it lands."""
        searcher, actions = self.problem.searchers[number], self.plan.actions[number]
        if stop is not None and isinstance(searcher.moves, RegionMoves):
            searcher = replace(searcher, moves=replace(searcher.moves, back=-1))
        seen = PlanLooks.of(replace(self.problem, searchers=(searcher,)), Plan((actions[:stop],)))
        return PlanLooks(seen.cells, self.begins[number] + seen.times, np.full(len(seen.cells), self.numbers[number]))

    def _further(self, number: int, stop: int, free: float) -> Searcher:
        """A drone from a stop on, with what is left of its budget."""
        searcher, actions = self.problem.searchers[number], self.plan.actions[number]
        if isinstance(searcher.moves, RegionMoves):
            here = searcher.moves.first
            for action in actions[:stop].tolist():
                there = searcher.moves.graph.target(action, here)
                here = here if there is None else there
            moves = replace(searcher.moves, first=here, depart=-1)
            return replace(searcher, moves=moves, budget=searcher.budget - (free - float(self.begins[number])))
        start, before = (self.problem.grid.cell(int(actions[max(n, 0)])) for n in (stop, stop - 1))
        wing = isinstance(searcher.moves, CellMoves) and searcher.moves.kind == "fixed_wing"
        return replace(searcher, start=start, budget=searcher.steps - stop, came_from=before if wing else None)


@dataclass(frozen=True, eq=False)
class Stretch:
    """What is flown between two plans.

    Parameters
    ----------
    aloft : Aloft              at the first of them
    soon : PlanLooks           until the second, or until all have landed
    left : Aloft or None       at the second, with what is left of the first; None where all have landed
    """

    aloft: Aloft
    soon: PlanLooks
    left: Aloft | None
