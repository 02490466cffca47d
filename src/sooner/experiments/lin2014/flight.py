"""One trial: a map of the authors' flown from one start for so many steps by one planner."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sooner.campaigns.trial import Place, Trial
from sooner.experiments.flight import load_kernels, made, stopping
from sooner.experiments.lin2014.maps import posed
from sooner.planners import Planner, solve
from sooner.planners.proved import Proved
from sooner.problem import evaluate

__all__ = ["fly"]


def fly(trial: Trial, place: Place) -> Mapping[str, Any]:
    """Plan once, in a process whose kernels are loaded.

    Answers, in percent of what teleporting collects, `efficiency` (Efficiency_LB [Lin2014, eq. (9)]), `bound` (what no
    plan exceeds; 100 where only teleport is known) and `proved`, how much of the optimum the plan surely has; the
    `cells` of the path; under `timing` the seconds of planning by the clock and, over all threads, of the process.
    """
    instance, said = trial.instance, dict(trial.planner)
    end = tuple(instance["end"]) if "end" in instance else None
    problem = posed(Path(place.data), instance["map"], tuple(instance["start"]), int(trial.budget or 0), end)
    stop, proved = stopping(said), said.pop("proved", False)
    planner: Planner = Proved(made(said)) if proved else made(said)
    load_kernels(instance["map"], problem, planner)
    wall, cpu = time.perf_counter(), time.process_time()
    best = solve(problem, planner, stop() if stop else None, trial.seed).best
    timing = {"seconds": time.perf_counter() - wall, "cpu_seconds": time.process_time() - cpu}
    judged, teleport = evaluate(problem, best.plan), problem.teleport.value
    efficiency, bound = 100.0 * judged.value / teleport, 100.0 * min(best.bound, teleport) / teleport
    return {
        "efficiency": efficiency,
        "bound": bound,
        "proved": 100.0 * efficiency / bound,
        "cells": [int(cell) for cell in best.plan.actions[0]],
        "timing": timing,
    }
