"""Annealed walks over the cells of a lattice, flown as ways: what `Anneal` is worth without legs of its own."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray
from router import lattice

from sooner.belief import Belief
from sooner.experiments.sarenv import Sarenv
from sooner.grid import Grid
from sooner.planners import StopRule, solve
from sooner.planners.anneal import Anneal
from sooner.planners.team import Team
from sooner.problem import Searcher, SearchProblem, detection_gains

Way = NDArray[np.float64]


def walk(scenario: Sarenv, drones: int, metres: float, pitch_m: float, seconds: float, seed: int = 0) -> list[Way]:
    """One way for each drone over the lattice's nodes, from the centre and back, each at most metres / drones long."""
    nodes, heat = lattice(scenario, pitch_m)
    side = round(np.sqrt(len(heat)))
    nodes, heat = nodes.reshape(side, side, 2)[::-1], heat.reshape(side, side)[::-1]  # row 0 is north
    start = (side // 2, side // 2)
    there_m = float(np.hypot(*(nodes[start] - scenario.centre)))
    steps = int((metres / drones - 2 * there_m) / pitch_m) // 2 * 2  # a closed walk over squares has an even number
    searchers = tuple(Searcher(start, steps, start) for _ in range(drones))
    problem = SearchProblem(
        Grid((side, side), cell_m=pitch_m), detection_gains(Belief.from_weights(heat), 1.0), searchers
    )
    planner = Anneal(threads=1) if drones == 1 else Team(Anneal(threads=1))
    plan = solve(problem, planner, stop=processor_seconds(seconds), seed=seed).best.plan
    centre = np.array([scenario.centre])
    return [np.concatenate([centre, nodes.reshape(-1, 2)[cells], centre]) for cells in plan.actions]


def processor_seconds(seconds: float) -> StopRule:
    """Stop when this process has worked for so long, from now on, whoever else is at work on this machine."""
    began = time.process_time()

    def share() -> float:
        return min((time.process_time() - began) / seconds, 1.0)

    return StopRule(lambda _: share() >= 1.0, lambda _: share())
