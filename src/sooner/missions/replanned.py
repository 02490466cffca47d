"""A plan that is made anew on the way, with what looks have answered so far."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief, BetaGrid, EvidenceGrid
from sooner.errors import DataFormatError, Fault
from sooner.missions.aloft import Aloft, Stretch
from sooner.missions.mission_file import Mission
from sooner.missions.plan_trials import PlanTrial
from sooner.missions.planning import Planned, wrapped
from sooner.missions.processes import for_each_seed
from sooner.missions.sight import Sight
from sooner.planners import Status, max_ticks, solve
from sooner.planners.registry import make_planner
from sooner.problem import Gains, Plan, SearchProblem, evaluate
from sooner.problem.atoms import Rows, atom_gains
from sooner.problem.regions import RegionMoves
from sooner.simulation.answers import theta_of
from sooner.simulation.hidden import Hidden

__all__ = ["TICKS", "Replanning", "check_replanning", "fly_replanned"]

TICKS = 20  # of the planner at each replan: as many on every machine, so that a seed is one flight


@dataclass(frozen=True, eq=False)
class Replanning:
    """Fly a plan for some time, work out from the answers what cells hold now, plan the rest for that, and so on.

    A yes where a target is counts it as found, so that a cell that said yes pays nothing more where targets, or the one
    person, are to be found; where bits are counted it pays what is left to learn. One person with false alarms: a no
    makes all other cells likelier, and those that said yes are left to who goes and sees. The new plan is flown only if
    the judge prefers it to what is left of the old one.

    Over regions an action that has begun is flown to its end: a plan is made as soon as some drone is free, and for the
    others begins where and when they will be, with the looks that they still will take counted as taken.

    Parameters
    ----------
    mission : Mission
    plan : Plan             the first one
    planner : str
    every : float           time between plans, in the judge's unit: steps over cells, seconds over regions; inf: never
    ticks : int             of the planner at each replan
    """

    mission: Mission
    plan: Plan
    planner: str
    every: float
    ticks: int = TICKS

    def flown(self, seed: int) -> PlanTrial:
        """One flight against what this seed hides."""
        hidden = Hidden(self.mission.sight.answers, seed)
        for stretch in self.stretches(hidden, seed):
            hidden.look(stretch.soon.cells, stretch.soon.times)
        return PlanTrial.told(seed, self.mission.sight, hidden)

    def stretches(self, hidden: Hidden, seed: int) -> Iterator[Stretch]:
        """The flight from plan to plan; who asks takes the looks of each stretch before asking for the next."""
        aloft: Aloft | None = Aloft.of(self.mission.problem, self.plan)
        while aloft is not None:
            stretch = aloft.until(self.every)
            yield stretch
            aloft = stretch.left
            if aloft is not None:
                problem = replace(aloft.problem, gains=self._gains(aloft, self._sight(hidden)))
                aloft = replace(aloft, problem=problem, plan=self._better(problem, aloft.plan, seed))

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

    def _sight(self, hidden: Hidden) -> Sight:
        """What is known by now: of one person how likely he is in each cell, which is all that gains depend on."""
        sight, known = self.mission.sight, hidden.model.after(hidden.looks, hidden.hits)
        if isinstance(known, BetaGrid):
            return replace(sight, known=known)
        theta = theta_of(known)
        if sight.objective.kind == "detection":
            theta = np.where(hidden.hits > 0, 0.0, theta)
        return replace(sight, known=EvidenceGrid(theta.reshape(sight.theta.shape)))

    def _gains(self, aloft: Aloft, sight: Sight) -> Gains:
        """What looks pay that follow those which are still to come."""
        moves = aloft.problem.searchers[0].moves
        if not isinstance(moves, RegionMoves):
            return sight.gains  # over cells all drones are free at every step
        return atom_gains(moves.atoms, _later(sight.rows, np.bincount(aloft.pending.cells, minlength=sight.theta.size)))


def check_replanning(mission: Mission) -> None:
    """Refuse where answers teach nothing that the plan does not know, or where nobody would know all of them.

    Raises
    ------
    DataFormatError
    """
    if mission.over_legs:
        why = "expected it left out along legs: plans are flown to their end"
        raise DataFormatError(Fault("--replan", "", 'it came, and moves = "legs"', why))
    if isinstance(mission.sight.known, Belief) and not mission.sight.false_alarm:
        came = "it came, and area.poc without false alarms"
        why = (
            "expected area.evidence, or sensor.false_alarm: until the person is found every look says no, "
            "which the plan counts on already"
        )
        raise DataFormatError(Fault("--replan", "", came, why))
    if mission.problem.objective.target is not None:
        came = f"it came beside objective.detection_target = {mission.problem.objective.target:g}"
        raise DataFormatError(Fault("--replan", "", came, "expected one of them: replans are for the most by the end"))
    if mission.settings.links is not None:
        why = "expected one of them: over links no drone knows all that the others have seen, as a new plan must"
        raise DataFormatError(Fault("--replan", "", "it came beside [links]", why))


def fly_replanned(planned: Planned, every: float, seeds: range, workers: int = 1) -> Iterator[PlanTrial]:
    """Fly once for each seed, planning anew on the way; what comes does not depend on the number of workers."""
    mission = planned.score.mission
    check_replanning(mission)
    replanning = Replanning(mission, planned.score.plan, planned.planner, every)
    yield from for_each_seed(partial(_fly, replanning), seeds, workers)


def _fly(replanning: Replanning, seed: int) -> PlanTrial:
    return replanning.flown(seed)


def _later(rows: Rows, taken: NDArray[np.int64]) -> Rows:
    """What the looks after so many (N,) pay, as many of them as `rows` tells."""

    def later(cells: NDArray[np.int64]) -> NDArray[np.float64]:
        paid = rows(cells)
        number = np.arange(paid.shape[1]) + taken[cells, None]
        last = paid.shape[1] - 1
        return np.where(number <= last, np.take_along_axis(paid, np.minimum(number, last), axis=1), 0.0)

    return later
