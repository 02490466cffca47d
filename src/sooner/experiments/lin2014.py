"""Lin and Goodrich 2014, run again: their maps, their planners, every number they print.

L. Lin, M. A. Goodrich, "Hierarchical heuristic search using a Gaussian mixture model for UAV coverage planning",
IEEE Transactions on Cybernetics 44 (2014), 2532-2544.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from sooner.experiments.lin2014_claims import WITHOUT_CHANCE, claims
from sooner.experiments.lin2014_maps import posed
from sooner.experiments.study import Reproduced, commit, processor
from sooner.experiments.trials import Estimate, estimate, run_trials
from sooner.planners import StopRule, max_ticks, solve
from sooner.planners.planner import Planner
from sooner.problem import SearchProblem, evaluate

__all__ = ["Case", "Outcome", "Trial", "run_study", "run_trial"]

TIMED = 3  # seeds of each case that are run again, one at a time, for the tables of times

Say = Callable[[str], None]


@dataclass(frozen=True)
class Case:
    """One map flown from one start for so many steps by one planner.

    Parameters
    ----------
    instance : str             its name in the study
    map : str                  stem of the two files, `<map>_dist.csv` and `<map>_diff.csv`
    start, end : (row, col)
    steps : int
    planner : str              its name in the study
    make : str                 "module:Class"
    settings : str             its arguments as JSON; an object with "make" is made in turn
    seconds : float or None    planning time, of all threads together by the process's own clock; None lets it finish
    proved : bool              with a bound running beside it
    most : int                 seeds that are enough, where one takes long
    factor : int               times as many seeds, where chance decides
    """

    instance: str
    map: str
    start: tuple[int, int]
    end: tuple[int, int] | None
    steps: int
    planner: str
    make: str
    settings: str = "{}"
    seconds: float | None = None
    proved: bool = False
    most: int = 1_000_000
    factor: int = 1

    def planner_made(self) -> Planner:
        """The planner, with its settings."""
        planner: Planner = _made({"make": self.make, **json.loads(self.settings)})
        if not self.proved:
            return planner
        from sooner.planners.proved import Proved

        return Proved(planner)


def _made(value: Any) -> Any:
    """Objects from what TOML can say."""
    if isinstance(value, list):
        return tuple(map(_made, value))
    if not isinstance(value, dict) or "make" not in value:
        return value
    module, name = value["make"].split(":")
    return getattr(import_module(module), name)(**{key: _made(v) for key, v in value.items() if key != "make"})


@dataclass(frozen=True)
class Trial:
    """A case under one seed, with the folder of its maps."""

    case: Case
    seed: int
    data: Path


@dataclass(frozen=True)
class Outcome:
    """What came of a trial: percent of what teleporting collects, and seconds.

    Parameters
    ----------
    efficiency : float         Efficiency_LB in percent [Lin2014, eq. (9)]
    bound : float              what no plan exceeds, in the same percent; 100 where only teleport is known
    seconds : float            wall-clock time of planning, kernels loaded
    cpu : float                the same by the process's own clock, over all its threads
    cells : tuple of int       the path
    """

    efficiency: float
    bound: float
    seconds: float
    cpu: float
    cells: tuple[int, ...]


def run_trial(trial: Trial) -> Outcome:
    """Plan once, in a process whose kernels are loaded."""
    case = trial.case
    problem = posed(trial.data, case.map, case.start, case.steps, case.end)
    _load_kernels(case, problem)
    stop = _cpu_seconds(case.seconds) if case.seconds is not None else None
    began, cpu = time.perf_counter(), time.process_time()
    best = solve(problem, case.planner_made(), stop, trial.seed).best
    seconds, cpu = time.perf_counter() - began, time.process_time() - cpu
    judged, teleport = evaluate(problem, best.plan), problem.teleport.value
    bound = 100.0 * min(best.bound, teleport) / teleport
    return Outcome(100.0 * judged.value / teleport, bound, seconds, cpu, tuple(map(int, best.plan.actions[0])))


def _cpu_seconds(seconds: float) -> StopRule:
    """Stop when this process, all its threads, has computed for so long: other work on the machine costs nothing."""
    began = time.process_time()

    def share(_: object) -> float:
        return min((time.process_time() - began) / seconds, 1.0)

    return StopRule(lambda progress: share(progress) >= 1.0, share)


_loaded: set[tuple[str, bool, str]] = set()


def _load_kernels(case: Case, problem: SearchProblem) -> None:
    """Once a process, so that no trial pays for it; not for planners that take their time from their settings."""
    known = (case.make, case.proved, case.map)
    if known not in _loaded and "seconds" not in json.loads(case.settings):
        solve(problem, case.planner_made(), max_ticks(3))
    _loaded.add(known)


def run_study(
    study: Mapping[str, Any], data: Path, trials: int, workers: int, say: Say
) -> tuple[list[Reproduced], dict[Case, list[Outcome]]]:
    """Run every table of the study, and what the paper claims in its text.

    The first seeds of every case that has a table of times are run again, alone, one after the other.
    """
    cases = list(dict.fromkeys(case for table in study["tables"] for _, _, case in _cells(study, table)))
    all_ = [Trial(case, seed, data) for case in cases for seed in range(min(trials * case.factor, case.most))]
    timed = [Trial(case, seed, data) for case in _with_times(study) for seed in range(min(trials, TIMED))]
    outcomes = _together(all_, run_trials(run_trial, all_, workers, _saying(say, "trials")))
    times = _together(timed, run_trials(run_trial, timed, 1, _saying(say, "timed trials, one at a time")))
    mark = Reproduced("", "", "", 0.0, 0.0, 0.0, 0, commit(), processor())
    rows = [row for table in study["tables"] for row in _table(study, table, outcomes, times, mark)]
    for table, row, column, value in claims({row.key: row.value for row in rows}, _spread(study, outcomes), data):
        n = 1 if table in WITHOUT_CHANCE else min(trials, TIMED) if "Speed" in table else trials
        rows.append(_row(mark, table, row, column, Estimate(value, value, value, n)))
    return rows, outcomes


def _together(trials: Sequence[Trial], outcomes: Sequence[Outcome]) -> dict[Case, list[Outcome]]:
    found: dict[Case, list[Outcome]] = {}
    for trial, outcome in zip(trials, outcomes, strict=True):
        found.setdefault(trial.case, []).append(outcome)
    return found


def _saying(say: Say, what: str) -> Callable[[int, int], None]:
    def on_done(done: int, of: int) -> None:
        if done == of or done % max(of // 20, 1) == 0:
            say(f"{done} of {of} {what}")

    return on_done


def _cells(study: Mapping[str, Any], table: Mapping[str, Any]) -> Iterator[tuple[str, str, Case]]:
    """Row, column and case of every cell of a table; planners that need a package that is not there are left out."""
    for instance in table["instances"]:
        place = study["instances"][instance]
        for planner in table["planners"]:
            chosen = dict(study["planners"][planner])
            if find_spec(chosen.pop("needs", "sooner")) is None:
                continue
            case = Case(
                instance=instance,
                map=place["map"],
                start=tuple(place["start"]),
                end=tuple(place["end"]) if "end" in place else None,
                steps=0,
                planner=planner,
                make=chosen.pop("make"),
                seconds=chosen.pop("cpu_seconds", None),
                proved=chosen.pop("proved", False),
                most=chosen.pop("most_trials", 1_000_000),
                factor=chosen.pop("seeds_factor", 1),
                settings=json.dumps(chosen, sort_keys=True),
            )
            for steps in table["steps"]:
                names = {"instance": instance, "planner": planner, "steps": steps}
                yield table["row"].format(**names), table["column"].format(**names), replace(case, steps=steps)


def _with_times(study: Mapping[str, Any]) -> list[Case]:
    tables = [table for table in study["tables"] if "times" in table]
    return list(dict.fromkeys(case for table in tables for _, _, case in _cells(study, table)))


def _table(
    study: Mapping[str, Any],
    table: Mapping[str, Any],
    outcomes: Mapping[Case, Sequence[Outcome]],
    times: Mapping[Case, Sequence[Outcome]],
    mark: Reproduced,
) -> Iterator[Reproduced]:
    """The rows of one table, then of its table of times."""
    statistic, measure = table.get("statistic", "mean"), table.get("measure", "efficiency")
    for row, column, case in _cells(study, table):
        found = estimate([_of(outcome, measure) for outcome in outcomes[case]], statistic)
        yield _row(mark, table["name"], row, column, found)
    if "times" in table:
        for row, column, case in _cells(study, table):
            found = estimate([outcome.seconds for outcome in times.get(case, outcomes[case])], statistic)
            yield _row(mark, table["times"], row, column, found)


def _of(outcome: Outcome, measure: str) -> float:
    if measure == "proved":  # how much of the optimum the plan surely has
        return 100.0 * outcome.efficiency / outcome.bound
    return float(getattr(outcome, measure))


def _row(mark: Reproduced, table: str, row: str, column: str, found: Estimate) -> Reproduced:
    return replace(
        mark, table=table, row=row, column=column, value=found.value, low=found.low, high=found.high, n=found.n
    )


def _spread(study: Mapping[str, Any], outcomes: Mapping[Case, Sequence[Outcome]]) -> dict[str, float]:
    """Largest standard deviation of Efficiency_LB over the cells that the paper prints of a map, as a fraction."""
    widest: dict[str, float] = {}
    for case, found in outcomes.items():
        if case.planner in study["printed"]:
            deviation = float(np.std([outcome.efficiency / 100.0 for outcome in found]))
            widest[case.instance] = max(widest.get(case.instance, 0.0), deviation)
    return widest
