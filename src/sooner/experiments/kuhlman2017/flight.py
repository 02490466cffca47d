"""One trial: a natural environment searched from one start by one planner [Kuhlman2017, sec. 7]."""

from __future__ import annotations

import time
from collections.abc import Mapping
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sooner.belief.effort import Variant, expected_effort
from sooner.bounds.region_lp import RegionLP
from sooner.campaigns.trial import Place, Trial
from sooner.experiments.flight import made, stopping
from sooner.experiments.kuhlman2017.ground import DETECT, FALSE_ALARM, Posed, posed
from sooner.planners import solve
from sooner.planners.depth_first import relaxation
from sooner.problem import Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround

__all__ = ["fly"]

AT_HAND_S = 0.01  # a ground that takes less was made before
THRESHOLD = 0.01  # P_neg, sec. 7.3
VARIANTS: tuple[Variant, Variant] = ("printed", "corrected")


class _Flown(NamedTuple):
    """What a planner did."""

    actions: NDArray[np.int64] | None  # None where it found no complete walk
    first_value: float
    solutions: int
    expanded: int
    first_s: float  # seconds of this process until the first solution
    seconds: float  # by the clock
    cpu_seconds: float  # of this process


def fly(trial: Trial, place: Place) -> Mapping[str, Any]:
    """Plan once and count as the paper does.

    Answers `info`, what the judge says the plan collects in percent of the iterative greedy reference, and
    `first_info`, the same of the first solution; `bits`; `success`, whether there is a complete walk (the other numbers
    of a plan are null where not), and the same as `success_percent`; `solutions` and `expanded` of planners that search
    over walks; `effort` by the printed equation and `effort_corrected`, mean search times of the free cells; `regions`,
    `t_max`, `reference` (bits) and `cells` of the ground, `swept_m2_per_m` of its ways; `bound`, of the linear program
    in percent of the reference, and `proved`, the percentage of it that the plan reaches, where the planner says
    proved = true; and under `timing` the process's seconds to the first solution, in all, and for the ground where it
    had to be made.

    The planner is what `sooner.experiments.flight` takes; `walks = true` asks for what a search over walks has done,
    for its complete walks only.
    """
    began = time.process_time()
    found = posed(trial.instance, trial.seed)
    ground_s = time.process_time() - began
    said = dict(trial.planner)
    walks, proved = said.pop("walks", False), said.pop("proved", False)
    _load_kernels(said, walks)
    flown = _searched(found.problem, said, trial.seed) if walks else _planned(found.problem, said, trial.seed)
    reference, _ = relaxation(RegionGround.of(found.problem))
    numbers = {**_ground_numbers(found, reference), **_plan_numbers(found, flown, reference)}
    if proved:
        numbers["bound"] = 100.0 * _bound(found.problem) / reference
        numbers["proved"] = None if numbers["info"] is None else 100.0 * numbers["info"] / numbers["bound"]
    timing = {"first_s": _known(flown.first_s), "seconds": flown.seconds, "cpu_seconds": flown.cpu_seconds}
    if ground_s > AT_HAND_S:
        timing["ground_s"] = ground_s
    return {**numbers, "timing": timing}


def _planned(problem: SearchProblem, said: Mapping[str, Any], seed: int) -> _Flown:
    """By `solve`: one plan, or what is best when the time is up."""
    settings = dict(said)
    stop = stopping(settings)
    planner = made(settings)
    wall, cpu = time.perf_counter(), time.process_time()
    best = solve(problem, planner, stop() if stop else None, seed).best
    taken = time.perf_counter() - wall, time.process_time() - cpu
    return _Flown(np.asarray(best.plan.actions[0]), nan, 1, 0, nan, *taken)


def _searched(problem: SearchProblem, said: Mapping[str, Any], seed: int) -> _Flown:
    """By its records: of the complete walks only, as the paper counts them."""
    planner = made(dict(said))
    wall, cpu = time.perf_counter(), time.process_time()
    first_s = nan
    for record in planner.searched(problem, np.random.default_rng(seed)):
        if record.success and not isfinite(first_s):
            first_s = time.process_time() - cpu
    taken = time.perf_counter() - wall, time.process_time() - cpu
    actions = np.array(record.walk, np.int64) if record.success else None
    return _Flown(actions, record.first_value, record.solutions, record.expanded, first_s, *taken)


def _ground_numbers(found: Posed, reference: float) -> dict[str, Any]:
    graph = found.ground.graph
    ways = range(graph.n_regions, graph.n_regions + graph.n_edges)
    flown_m = sum(float(np.hypot(*np.diff(graph.paths[way], axis=0).T).sum()) for way in ways)
    cells = sum(len(graph.footprints.of(way)) for way in ways)
    return {
        "regions": found.ground.regions.n_regions,
        "t_max": found.ground.budget_s,
        "reference": reference,
        "cells": found.problem.grid.n_cells,
        "swept_m2_per_m": cells * found.problem.grid.cell_m**2 / flown_m if flown_m else None,
    }


def _plan_numbers(found: Posed, flown: _Flown, reference: float) -> dict[str, Any]:
    if flown.actions is None:
        numbers = dict.fromkeys(("info", "first_info", "bits", "effort", "effort_corrected", "solutions"))
        return {**numbers, "success": False, "success_percent": 0.0, "expanded": flown.expanded, "actions": []}
    bits = evaluate(found.problem, Plan.of(flown.actions)).value
    looks, free = found.looks(flown.actions), found.free
    printed, corrected = (
        None
        if found.ground.model == "beta"
        else _effort(found.theta[free], looks[free], variant)  # a rate is no target
        for variant in VARIANTS
    )
    return {
        "info": 100.0 * bits / reference,
        "first_info": _known(100.0 * flown.first_value / reference),
        "bits": bits,
        "effort": printed,
        "effort_corrected": corrected,
        "solutions": flown.solutions,
        "success": True,
        "success_percent": 100.0,
        "expanded": flown.expanded,
        "actions": flown.actions.tolist(),
    }


def _effort(theta: NDArray[np.float64], looks: NDArray[np.int64], variant: Variant) -> float:
    """Mean over cells of the expected search time."""
    each = expected_effort(theta, looks, DETECT, FALSE_ALARM, threshold=THRESHOLD, variant=variant)
    return float(each.mean())


def _bound(problem: SearchProblem) -> float:
    """The lowest value of the linear program over regions [bounds.region_lp]."""
    return min(found.value for found in RegionLP().bounds(problem))


def _known(value: float) -> float | None:
    return value if isfinite(value) else None


_loaded: set[str] = set()


def _load_kernels(said: Mapping[str, Any], walks: bool) -> None:
    """Once a process, on a small ground, so that no trial pays for it."""
    if repr(said) in _loaded:
        return
    _loaded.add(repr(said))
    small = posed({"kind": "vlf"}, 0).problem
    if walks:
        few = {**said, "iterations": 50}
        _searched(small, few, 0)
        return
    short = {key: value for key, value in said.items() if key not in ("seconds", "cpu_seconds")}
    _planned(small, {**short, "ticks": 1}, 0)
