"""The trial that a study flies if it names no other: plan a mission or a scenario once, by the judge's count."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

from sooner.campaigns.trial import Place, Trial
from sooner.errors import DataFormatError, Fault
from sooner.planners import Planner, StopRule, max_seconds, max_ticks, solve
from sooner.planners.proved import Proved
from sooner.planners.registry import make_planner
from sooner.problem import SearchProblem, evaluate

__all__ = ["cpu_seconds", "fly", "made", "stopping"]


def fly(trial: Trial, place: Place) -> Mapping[str, Any]:
    """Plan once and let the judge say what the plan is worth.

    The instance is `{ mission = FILE }`, beside the study, or `{ scenario = NAME, seed = N, ... }`; the budget, if any,
    replaces the steps of every searcher. The planner is `{ name = NAME }` of `sooner planners` or `{ make =
    "module:Class", ... }` with its settings, and with one of `ticks`, `seconds` and `cpu_seconds` (of all threads
    together), and `proved = true` for a bound beside it. Only ticks give the same plan everywhere.

    Answers `value`, `bound`, `efficiency` (value over that of a searcher that teleports), `gap`, the `status` of the
    run, `steps` flown, and under `timing` the seconds.
    """
    problem = _problem(trial, place)
    said = dict(trial.planner)
    stop, proved = stopping(said), said.pop("proved", False)
    planner = made(said)
    planner = Proved(planner) if proved else planner
    wall, cpu = time.perf_counter(), time.process_time()
    solution = solve(problem, planner, stop() if stop else None, trial.seed)
    timing = {"seconds": time.perf_counter() - wall, "cpu_seconds": time.process_time() - cpu}
    judged, bound = evaluate(problem, solution.best.plan), solution.best.bound
    finite = bound < float("inf")
    return {
        "value": judged.value,
        "bound": bound if finite else None,
        "gap": (bound - judged.value) / bound if finite and bound else None,
        "efficiency": judged.efficiency if problem.drift is None and problem.objective.target is None else None,
        "status": str(solution.status),
        "timing": timing,
    }


def _problem(trial: Trial, place: Place) -> SearchProblem:
    said = dict(trial.instance)
    if "mission" in said:
        return _with_budget(_mission(str(Path(place.folder) / said["mission"])), trial.budget)
    if "scenario" in said:
        from sooner.scenarios import make_scenario

        scenario = make_scenario(said["scenario"], said.get("seed"))
        return scenario.problem(None if trial.budget is None else int(trial.budget))
    expected = "expected mission = FILE or scenario = NAME"
    raise DataFormatError(Fault("study", f"instances.{trial.case.instance}", f"{said} came", expected))


@cache
def _mission(path: str) -> SearchProblem:
    from sooner.missions import read_mission

    return read_mission(Path(path)).problem


def _with_budget(problem: SearchProblem, budget: int | float | None) -> SearchProblem:
    if budget is None:
        return problem
    return replace(problem, searchers=tuple(replace(each, budget=int(budget)) for each in problem.searchers))


def made(said: Any) -> Any:
    """A planner, or another object, from what a study says: `name` in the registry, or `make` with its settings.

    >>> made({"make": "sooner.planners.topn:TopN", "layers": [[5, 3]]}).layers
    ((5, 3),)
    """
    if isinstance(said, list):
        return tuple(map(made, said))
    if not isinstance(said, dict):
        return said
    settings = {key: made(value) for key, value in said.items() if key not in ("name", "make")}
    if "make" in said:
        module, name = said["make"].split(":")
        return getattr(import_module(module), name)(**settings)
    planner: Planner = make_planner(said["name"], **settings)
    return planner


def stopping(said: dict[str, Any]) -> Callable[[], StopRule] | None:
    """Take `ticks`, `seconds` or `cpu_seconds` out of the settings: how to make the stop rule, if there is one."""
    for key, rule in (("ticks", max_ticks), ("seconds", max_seconds), ("cpu_seconds", cpu_seconds)):
        if key in said:
            return partial(rule, said.pop(key))
    return None


def cpu_seconds(seconds: float) -> StopRule:
    """Stop when this process, all its threads, has computed for so long: other work on the machine costs nothing."""
    began = time.process_time()

    def share(_: object) -> float:
        return min((time.process_time() - began) / seconds, 1.0)

    return StopRule(lambda progress: share(progress) >= 1.0, share)
