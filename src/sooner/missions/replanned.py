"""A plan that is made anew on the way, with what looks have answered so far."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from sooner.belief import EvidenceGrid
from sooner.errors import DataFormatError, Fault
from sooner.missions.hidden import HiddenTargets, theta_after
from sooner.missions.mission_file import Mission
from sooner.missions.plan_trials import Flyover, PlanTrial, looks_of
from sooner.missions.planning import Planned, wrapped
from sooner.missions.processes import for_each_seed
from sooner.missions.sight import Sight
from sooner.planners import Status, max_ticks, solve
from sooner.planners.registry import make_planner
from sooner.problem import CellMoves, Gains, Plan, Searcher, SearchProblem, evaluate
from sooner.problem.atoms import atom_gains
from sooner.problem.regions import RegionMoves

__all__ = ["Replanning", "check_replanning", "fly_replanned"]

TICKS = 20  # of the planner at each replan: as many on every machine, so that a seed is one flight


@dataclass(frozen=True, eq=False)
class Replanning:
    """Fly a plan for some time, work out from the answers what cells hold now, plan the rest for that, and so on.

    A yes where a target is counts it as found, so that a cell that said yes pays nothing more where targets are
    counted; where bits are counted it pays what is left to learn. The new plan is flown only if the judge prefers it to
    what is left of the old one.

    Parameters
    ----------
    mission : Mission
    plan : Plan             the first one
    planner : str
    every : float           time between plans, in the judge's unit: steps over cells, seconds over regions
    ticks : int             of the planner at each replan
    """

    mission: Mission
    plan: Plan
    planner: str
    every: float
    ticks: int = TICKS

    def flown(self, seed: int) -> PlanTrial:
        """One flight against what this seed hides."""
        hidden, sight = HiddenTargets(self.mission.sight, seed), self.mission.sight
        problem, plan, begun = self.mission.problem, self.plan, 0.0
        while True:
            part = _parted(problem, plan, self.every)
            hidden.look(part.cells, begun + part.times)
            if part.rest is None:
                break
            gains = _gains(problem, self._sight(hidden))
            problem, begun = replace(problem, gains=gains, searchers=part.searchers), begun + part.until
            plan = self._better(problem, part.rest, seed)
        return Flyover(sight, np.repeat(np.arange(hidden.looks.size), hidden.looks), np.empty(0)).told(seed, hidden)

    def _better(self, problem: SearchProblem, old: Plan, seed: int) -> Plan:
        """What the planner finds, if the judge prefers it to what is left of the old plan."""
        planner = wrapped(problem, make_planner(self.planner))
        if planner.handles(problem) is not None:
            return old
        solution = solve(problem, planner, stop=max_ticks(self.ticks), seed=seed)
        if solution.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        new = solution.best.plan
        return new if evaluate(problem, new).value > evaluate(problem, old).value else old

    def _sight(self, hidden: HiddenTargets) -> Sight:
        sight = self.mission.sight
        detect = sight.glimpse.ravel()
        theta = theta_after(sight.theta.ravel(), detect, sight.false_alarm, hidden.looks, hidden.hits)
        if sight.objective.kind == "detection":
            theta = np.where(hidden.hits > 0, 0.0, theta)
        return replace(sight, known=EvidenceGrid(theta.reshape(sight.theta.shape)))


@dataclass(frozen=True, eq=False)
class _Part:
    """Looks until the next plan; then who flies on from where, with what is left of the old plan, and when.

    rest is None where flights end before that. Over cells the look at where the rest begins is part of the rest.
    """

    cells: NDArray[np.int64]
    times: NDArray[np.float64]
    rest: Plan | None = None
    searchers: tuple[Searcher, ...] = ()
    until: float = 0.0


def check_replanning(mission: Mission) -> None:
    """Refuse where answers teach nothing that the plan does not know, or where drones come free at different times.

    Raises
    ------
    DataFormatError
    """
    if not isinstance(mission.sight.known, EvidenceGrid):
        came = "it came, and area.poc" if mission.belief is not None else 'it came, and model = "beta"'
        why = (
            "expected area.evidence: one person is not found until he is, which the plan counts on already"
            if mission.belief is not None
            else 'expected it left out, or model = "binary"'
        )
        raise DataFormatError(Fault("--replan", "", came, why))
    if mission.settings.links is not None:
        raise DataFormatError(Fault("--replan", "", "it came beside [links]", "expected one of them"))
    if mission.over_regions and len(mission.problem.searchers) > 1:
        came = f"it came, and {len(mission.problem.searchers)} drones over regions"
        raise DataFormatError(Fault("--replan", "", came, "expected one: this version replans for one, or over cells"))


def fly_replanned(planned: Planned, every: float, seeds: range, workers: int = 1) -> Iterator[PlanTrial]:
    """Fly once for each seed, planning anew on the way; what comes does not depend on the number of workers."""
    mission = planned.score.mission
    check_replanning(mission)
    replanning = Replanning(mission, planned.score.plan, planned.planner, every)
    yield from for_each_seed(partial(_fly, replanning), seeds, workers)


def _fly(replanning: Replanning, seed: int) -> PlanTrial:
    return replanning.flown(seed)


def _over_regions(problem: SearchProblem) -> bool:
    return isinstance(problem.searchers[0].moves, RegionMoves)


def _parted(problem: SearchProblem, plan: Plan, every: float) -> _Part:
    """What is flown before the next plan, and what is left."""
    if isinstance(problem.searchers[0].moves, RegionMoves):
        return _parted_over_regions(problem, plan, every)
    steps = int(every)
    going = [n for n, actions in enumerate(plan.actions) if len(actions) > steps + 1]
    if not going:
        return _Part(*looks_of(problem, plan))
    flown = Plan(tuple(actions[:steps] if n in going else actions for n, actions in enumerate(plan.actions)))
    searchers = tuple(_further(problem, problem.searchers[n], plan.actions[n], steps) for n in going)
    return _Part(
        *looks_of(problem, flown), Plan(tuple(plan.actions[n][steps:] for n in going)), searchers, float(steps)
    )


def _further(problem: SearchProblem, searcher: Searcher, actions: NDArray[np.int64], steps: int) -> Searcher:
    wing = isinstance(searcher.moves, CellMoves) and searcher.moves.kind == "fixed_wing"
    start, before = (problem.grid.cell(int(actions[n])) for n in (steps, steps - 1))
    return replace(searcher, start=start, budget=searcher.steps - steps, came_from=before if wing else None)


def _parted_over_regions(problem: SearchProblem, plan: Plan, every: float) -> _Part:
    searcher, actions = problem.searcher, plan.actions[0]
    moves = searcher.moves
    assert isinstance(moves, RegionMoves)
    here, now = moves.first, float(moves.graph.seconds[moves.depart]) if moves.depart >= 0 else 0.0
    for number, action in enumerate(actions[:-1].tolist(), 1):
        there = moves.graph.target(action, here)
        here, now = here if there is None else there, now + float(moves.graph.seconds[action])
        if now >= every:
            going = replace(searcher, moves=replace(moves, back=-1))
            flown = looks_of(replace(problem, searchers=(going,)), Plan((actions[:number],)))
            left = replace(searcher, moves=replace(moves, first=here, depart=-1), budget=searcher.budget - now)
            return _Part(*flown, Plan((actions[number:],)), (left,), now)
    return _Part(*looks_of(problem, plan))


def _gains(problem: SearchProblem, sight: Sight) -> Gains:
    moves = problem.searchers[0].moves
    return atom_gains(moves.atoms, sight.rows) if isinstance(moves, RegionMoves) else sight.gains
