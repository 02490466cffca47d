"""Episodes of plans over cells or over regions: one flight by its seed, kept whole, and flown again."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from sooner.errors import InvalidProblemError
from sooner.missions.aloft import Aloft
from sooner.missions.mission_file import Mission
from sooner.missions.plan_trials import PlanLooks
from sooner.missions.replanned import TICKS, Replanning
from sooner.problem import Plan, Searcher, SearchProblem, evaluate
from sooner.problem.regions import RegionMoves
from sooner.simulation.hidden import Hidden
from sooner.simulation.plan_episode import Answers, Course, Flown, Intent, PlanEpisode

__all__ = ["plan_episode", "replayed_plan"]


def plan_episode(
    mission: Mission, plan: Plan, seed: int, planner: str = "", every: float | None = None, ticks: int = TICKS
) -> PlanEpisode:
    """One flight of a plan against what a seed hides, as `fly_plan` and `fly_replanned` fly it.

    Parameters
    ----------
    mission : Mission
    plan : Plan                the first one
    seed : int
    planner : str              that makes the others
    every : float or None      time between plans, in the judge's unit; None: no others
    ticks : int                of the planner at each replan
    """
    flight = Replanning(mission, plan, planner, inf if every is None else every, ticks)
    hidden = Hidden(mission.sight.answers, seed)
    looks, yes, plans = [], [], []
    for stretch in flight.stretches(hidden, seed):
        looks.append(stretch.soon)
        yes.append(hidden.look(stretch.soon.cells, stretch.soon.times))
        plans.append(_intent(stretch.aloft, len(plan.actions)))
    seen = PlanLooks.joined(looks)
    flown = Flown(mission.name, seed, planner, every, ticks, plan.actions, mission.sight.unit, mission.unit_s)
    return PlanEpisode(
        mission.problem.grid,
        hidden.model,
        flown,
        hidden.truth,
        Answers(seen.cells, seen.times, seen.searchers, np.concatenate(yes)),
        tuple(plans),
    )


def replayed_plan(episode: PlanEpisode, mission: Mission) -> PlanEpisode:
    """The same flight once more: what is not the same then was not flown by this version, or in another mission.

    Raises
    ------
    IllegalPlanError         where the first plan cannot be flown in this mission
    InvalidProblemError      where its map is another
    """
    ground = mission.problem.grid
    if episode.grid.shape != ground.shape:
        raise InvalidProblemError(f"an episode over {episode.grid.shape} cells came; the mission has {ground.shape}")
    flown, plan = episode.flown, Plan(episode.flown.actions)
    evaluate(mission.problem, plan)
    return plan_episode(mission, plan, flown.seed, flown.planner, flown.every, flown.ticks)


def _intent(aloft: Aloft, team: int) -> Intent:
    """What drones mean to fly from a plan on."""
    courses = [Course(np.zeros(0), np.zeros((0, 2)))] * team
    flights = zip(aloft.numbers.tolist(), aloft.problem.searchers, aloft.plan.actions, aloft.begins, strict=True)
    for number, searcher, actions, begins in flights:
        course = _course(aloft.problem, searcher, actions)
        courses[number] = replace(course, times=course.times + begins)
    return Intent(aloft.since, tuple(courses))


def _course(problem: SearchProblem, searcher: Searcher, actions: np.ndarray) -> Course:
    """Where a drone is when, from the start of its own clock."""
    if isinstance(searcher.moves, RegionMoves):
        places, times = searcher.moves.timed(actions)
        return Course(times, places)
    return Course(np.arange(len(actions), dtype=np.float64), problem.grid.centres_m[actions])
