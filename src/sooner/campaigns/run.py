"""Run a study: open its ledger, get a crew, fly what is missing, then write what came of it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from sooner.campaigns.campaign import Asked, Crew, Progress, Watch, fly
from sooner.campaigns.ledger import Ledger
from sooner.campaigns.pool import Pool, cores, share_of_memory_mb
from sooner.campaigns.provenance import provenance, same_source
from sooner.campaigns.results import Results, collect
from sooner.campaigns.study import Study
from sooner.campaigns.tidy import flat
from sooner.campaigns.trial import Case, Place, Trial
from sooner.errors import DataFormatError, Fault, InvalidProblemError

__all__ = ["LEDGER", "Earlier", "Ran", "find_data", "refuse_none", "run_study"]

LEDGER = "trials.sqlite"
Earlier = Literal["ask", "keep", "redo"]


@dataclass(frozen=True)
class Ran:
    """What a campaign left: the ledger stays open to be read, so use it in a `with`.

    Parameters
    ----------
    asked : Asked
    ledger : Ledger
    progress : Progress
    """

    asked: Asked
    ledger: Ledger
    progress: Progress

    def __enter__(self) -> Ran:
        return self

    def __exit__(self, *_: object) -> None:
        self.ledger.close()

    def results(self, alone: bool = True) -> dict[Case, Results]:
        """What came of every case; with those flown alone or without."""
        return {case: self.of(case, seeds) for case, seeds in self.asked.cases if alone or not case.alone}

    def of(self, case: Case, seeds: range) -> Results:
        """What came of one case."""
        rows = ((seed, flat(answer)) for seed, answer in self.ledger.answers(case, seeds))
        return collect(case.instance, case.planner, case.budget, rows, self.ledger.counts(case, seeds).aside)

    def answers(self, case: Case) -> list[dict[str, Any]]:
        """Whole answers of a case, by seed: paths and whatever else a trial told."""
        seeds = dict(self.asked.cases)[case]
        return [answer for _, answer in self.ledger.answers(case, seeds)]

    def set_aside(self) -> list[tuple[Trial, str, str]]:
        """Trials that failed for good: how, and why."""
        asked = dict(self.asked.cases)
        return [found for found in self.ledger.failures(asked) if found[0].seed in asked[found[0].case]]

    def rows(self) -> Iterator[dict[str, Any]]:
        """Every trial that was begun, as one flat row."""
        for case, seeds in self.asked.cases:
            named = {"instance": case.instance, "planner": case.planner, "budget": case.budget, "alone": case.alone}
            for row in self.ledger.rows(case, seeds):
                yield named | row


def run_study(
    study: Study,
    folder: Path,
    data: Path | None = None,
    trials: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    earlier: Earlier = "ask",
    retry: bool = False,
    watch: Watch = lambda progress: None,
) -> Ran:
    """Fly what is missing of a study.

    Parameters
    ----------
    folder : Path             of the ledger, `trials.sqlite`
    data : Path or None       folder of the real maps; None takes SOONER_DATA
    trials : int or None      seeds of each case; None takes the study's number
    workers : int or None     processes; None takes one for each core
    scheduler : str or None   address of a Dask scheduler; None flies on this machine
    earlier : str             results of other code or other maps that the ledger holds: "ask" refuses to mix them,
                              "keep" counts them, "redo" puts that ledger aside and begins anew
    retry : bool              give trials that were set aside another chance
    watch : callable          is told how it goes

    Raises
    ------
    DataFormatError           no such data, a study that its trial cannot fly, or a ledger that cannot be used
    InvalidProblemError       no trial, or no worker
    """
    refuse_none(trials, workers)
    _check(study)
    place = Place(
        study.file.trial,
        str(study.folder.resolve()),
        str(find_data(data, study.file.data, study.file.data_files)) if study.file.data else "",
        study.data_files,
    )
    asked = study.asked(trials)
    ledger = _opened(folder / LEDGER, study, asked, place, earlier)
    try:
        if retry:
            ledger.retry()
        progress = fly(asked, ledger, _crew(study, place, workers, scheduler), place, watch)
    except BaseException:
        ledger.close()
        raise
    return Ran(asked, ledger, progress)


def refuse_none(trials: int | None, workers: int | None) -> None:
    """Raise InvalidProblemError for no trial, or no worker."""
    if any(number is not None and number < 1 for number in (trials, workers)):
        raise InvalidProblemError(f"{trials} trials and {workers} workers came; expected at least one of each")


def _check(study: Study) -> None:
    """Ask the trial, where it is sooner's own, whether it can fly the study: before anything is flown."""
    module = study.file.trial.partition(":")[0]
    if module.partition(".")[0] == "sooner":
        getattr(import_module(module), "check", lambda study: None)(study)


def _crew(study: Study, place: Place, workers: int | None, scheduler: str | None) -> Crew:
    if scheduler is not None:
        from sooner.campaigns.cluster import Cluster

        return Cluster(scheduler, place, study.limits)
    count = workers or cores()
    limits = study.limits
    return Pool(count, place, replace(limits, memory_mb=min(limits.memory_mb, share_of_memory_mb(count))))


def _opened(path: Path, study: Study, asked: Asked, place: Place, earlier: Earlier) -> Ledger:
    ledger = Ledger(path, study.key)
    if earlier == "keep":
        return ledger
    ours = provenance(place)
    stale = [(it, count) for it, count in ledger.provenances(c for c, _ in asked.cases) if not same_source(ours, it)]
    if not stale:
        return ledger
    if earlier == "redo":
        ledger.begin_anew()
        return ledger
    ledger.close()
    commits = ", ".join(sorted({it["commit"] or "unknown" for it, _ in stale}))
    came = f"{sum(count for _, count in stale)} trials were flown by other code or on other maps (commit {commits})"
    raise DataFormatError(
        Fault(str(path), "", came, "say --earlier keep to count them, --earlier redo to fly all of them again")
    )


def find_data(data_dir: Path | None, name: str, patterns: list[str]) -> Path:
    """The folder of real maps called `name`: in `data_dir`, or where SOONER_DATA says, or that folder itself.

    Raises
    ------
    DataFormatError               if no file of `patterns` is in either
    """
    given = data_dir or (Path(os.environ["SOONER_DATA"]) if os.environ.get("SOONER_DATA") else None)
    if given is None:
        raise DataFormatError(Fault(name, "", "no data directory came", "give --data DIR or set SOONER_DATA"))
    for folder in (given / name, given):
        if folder.is_dir() and all(any(folder.glob(pattern)) for pattern in patterns):
            return folder.resolve()
    missing = [pattern for pattern in patterns if not any((given / name).glob(pattern))]
    came = f"{name}/{missing[0]} is not there" if missing else f"{name} is not there"
    raise DataFormatError(Fault(str(given), "", came, "give --data DIR or set SOONER_DATA to the folder above it"))
