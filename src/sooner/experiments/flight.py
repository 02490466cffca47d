"""The trial that a study flies if it names no other: plan a mission or a scenario once, by the judge's count."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import Any

from sooner.campaigns.study import OURS, Study
from sooner.campaigns.trial import Place, Trial
from sooner.errors import DataFormatError, Fault, SoonerError
from sooner.missions.planning import wrapped
from sooner.planners import Planner, StopRule, max_seconds, max_ticks, solve
from sooner.planners.proved import Proved
from sooner.planners.registry import make_planner
from sooner.problem import SearchProblem, evaluate

__all__ = ["check", "cpu_seconds", "drawn", "fly", "load_kernels", "made", "rehearse", "stopping"]

STUDY = "study"  # a fault of the study's own file
STOPS = ("ticks", "seconds", "cpu_seconds")
OF_TRIAL = "trial"  # as an instance's seed


def fly(trial: Trial, place: Place) -> Mapping[str, Any]:
    """Plan once and let the judge say what the plan is worth.

    The instance is `{ mission = FILE }`, beside the study, or `{ scenario = NAME, seed = N, size = N }`, whose seed may
    be "trial": then every seed of the campaign is a search of its own. The budget, if any, replaces the steps of every
    searcher. The planner is `{ name = NAME }` of `sooner planners` or `{ make =
    "module:Class", ... }` with its settings, and with one of `ticks`, `seconds` and `cpu_seconds` (of all threads
    together), and `proved = true` for a bound beside it. Only ticks give the same plan everywhere.

    Answers `value`, `bound`, `efficiency` (value over that of a searcher that teleports), `gap`, each null where there
    is no such number, the `status` of the run, and under `timing` its seconds.
    """
    instance = drawn(trial.instance, trial.seed)
    problem = _problem(f"instances.{trial.case.instance}", instance, place.folder, trial.budget)
    said = dict(trial.planner)
    stop, proved = stopping(said), said.pop("proved", False)
    planner = wrapped(problem, made(said)) if "name" in said else made(said)
    planner = Proved(planner) if proved else planner
    load_kernels(trial.case.instance, problem, planner)
    wall, cpu = time.perf_counter(), time.process_time()
    solution = solve(problem, planner, stop() if stop else None, trial.seed)
    timing = {"seconds": time.perf_counter() - wall, "cpu_seconds": time.process_time() - cpu}
    judged, best = evaluate(problem, solution.best.plan), solution.best
    return {
        "value": _finite(judged.value),
        "bound": _finite(best.bound),
        "gap": _finite(best.gap),
        "efficiency": judged.efficiency if problem.drift is None and problem.objective.target is None else None,
        "status": solution.status.value,
        "timing": timing,
    }


def drawn(instance: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """The instance with the trial's seed where it asks for it.

    >>> drawn({"scenario": "many-hills", "seed": "trial"}, 7)
    {'scenario': 'many-hills', 'seed': 7}
    """
    return {**instance, "seed": seed} if instance.get("seed") == OF_TRIAL else dict(instance)


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


_loaded: set[tuple[str, str]] = set()


def load_kernels(name: str, problem: SearchProblem, planner: Planner) -> None:
    """Once a process, so that no trial pays for it; not for planners that take their time from their settings."""
    known = name, repr(planner)
    if known not in _loaded and not hasattr(planner, "tour_seconds"):
        solve(problem, planner, max_ticks(3))
    _loaded.add(known)


def check(study: Study) -> None:
    """Refuse a study that this trial cannot fly, before anything is flown.

    Raises
    ------
    DataFormatError      with every fault of its instances, budgets and planners
    """
    if faults := [*_faults(study)]:
        named = str(study.path)
        raise DataFormatError(*(replace(each, file=named) if each.file == STUDY else each for each in faults))


def rehearse(said: Mapping[str, Any]) -> None:
    """Make a planner from what a study says of it, as `fly` will."""
    settings = {key: value for key, value in said.items() if key != "proved"}
    stopping(settings)
    made(settings)


def _faults(study: Study) -> Iterator[Fault]:
    for name, said in study.file.instances.items():
        key = f"instances.{name}"
        try:
            _problem(key, drawn(said, 0), str(study.folder), None)
        except DataFormatError as error:
            for fault in error.faults:  # those of a mission file do not say which instance it is of
                there = f"{fault.file}: {fault.key}: " if fault.key else f"{fault.file}: "
                yield fault if fault.file == STUDY else Fault(STUDY, key, f"{there}{fault.came}", fault.expected)
        except SoonerError as error:
            yield Fault(STUDY, key, str(error), "expected a search that can be planned")
    budgets = {*study.file.budgets, *(budget for table in study.tables for budget in table.budgets or ())}
    for budget in sorted(budgets):
        if not (isinstance(budget, int) and budget >= 1):
            yield Fault(STUDY, "budgets", f"{budget} came", "expected steps: whole numbers of at least 1")
    for name, said in study.file.planners.items():
        if wrong := _planner_fault({key: value for key, value in said.items() if key not in OURS}):
            yield Fault(STUDY, f"planners.{name}", *wrong)


def _planner_fault(said: dict[str, Any]) -> tuple[str, str] | None:
    """What is wrong with a planner, as far as it shows without loading what the user wrote."""
    stops = [key for key in STOPS if key in said]
    if len(stops) > 1:
        return f"{' and '.join(stops)} came", "expected one of them"
    for key in stops:
        number = (int,) if key == "ticks" else (int, float)
        if isinstance(said[key], bool) or not isinstance(said[key], number) or said[key] <= 0:
            return f"{key} = {said[key]!r} came", f"expected a {'whole ' if key == 'ticks' else ''}number above 0"
    if not isinstance(said.get("proved", False), bool):
        return f"proved = {said['proved']!r} came", "expected true or false"
    settings = {key: value for key, value in said.items() if key not in (*STOPS, "proved")}
    if ("name" in said) == ("make" in said):
        return f"{said} came", 'expected name = NAME or make = "module:Class"'
    if "make" in said and not str(said["make"]).startswith("sooner."):
        module, _, kind = str(said["make"]).partition(":")
        return None if module and kind.isidentifier() else (f"{said['make']!r} came", 'expected "module:Class"')
    try:
        made(settings)
    except (SoonerError, TypeError, ValueError, AttributeError, ImportError) as error:
        return str(error).partition("\n")[0], "see `sooner planners`, and the class for its settings"
    return None


def _problem(key: str, said: Mapping[str, Any], folder: str, budget: int | float | None) -> SearchProblem:
    """The search of an instance, for its own budget or for another."""
    kinds = [kind for kind in ("mission", "scenario") if kind in said]
    expected = "expected mission = FILE or scenario = NAME"
    if len(kinds) != 1:
        raise DataFormatError(Fault(STUDY, key, f"{dict(said)} came", expected))
    if kinds == ["scenario"]:
        return _scenario(key, dict(said), None if budget is None else int(budget))
    if more := [name for name in said if name != "mission"]:
        expected = "expected mission alone"
        raise DataFormatError(*(Fault(STUDY, f"{key}.{name}", "there is no such key", expected) for name in more))
    return _with_budget(_mission(str(Path(folder) / said["mission"])), budget)


def _scenario(key: str, said: dict[str, Any], budget: int | None) -> SearchProblem:
    from sooner.scenarios import SCENARIOS

    name = said.pop("scenario")
    if name not in SCENARIOS:
        raise DataFormatError(Fault(STUDY, f"{key}.scenario", f"{name!r} came", f"expected {', '.join(SCENARIOS)}"))
    make, faults = SCENARIOS[name].make, []
    known = list(inspect.signature(make).parameters)
    for setting, value in said.items():
        if setting not in known:
            expected = f"expected {' or '.join(known)}"
            faults.append(Fault(STUDY, f"{key}.{setting}", "there is no such key", expected))
        elif isinstance(value, bool) or not isinstance(value, int) or value < 0:
            more = f' or "{OF_TRIAL}"' if setting == "seed" else ""
            faults.append(Fault(STUDY, f"{key}.{setting}", f"{value!r} came", f"expected a whole number{more}"))
    if faults:
        raise DataFormatError(*faults)
    return make(**said).problem(budget)


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
    if "name" not in said and "make" not in said:
        expected = 'expected { name = NAME } or { make = "module:Class" }, with settings'
        raise DataFormatError(Fault(STUDY, "planners", f"{said} came", expected))
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
