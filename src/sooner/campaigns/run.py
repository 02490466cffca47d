"""Run a study: open its ledger, get a crew, fly what is missing, then write what came of it."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from sooner.campaigns.campaign import Asked, Crew, Progress, Watch, fly
from sooner.campaigns.ledger import Ledger
from sooner.campaigns.pool import Pool, cores, share_of_memory_mb
from sooner.campaigns.provenance import provenance, same_source
from sooner.campaigns.results import Results, collect
from sooner.campaigns.study import MOST_TRIALS, Study, refused
from sooner.campaigns.tidy import flat
from sooner.campaigns.trial import Case, Place, Trial, in_short
from sooner.errors import DataFormatError, Fault, InvalidProblemError

__all__ = ["LEDGER", "Earlier", "Ran", "find_data", "recall_study", "refuse_none", "run_study"]

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

    def sources(self) -> list[tuple[str, str, str, int]]:
        """Which commit, source and maps flew how many of the trials that are done: the most first."""
        found: Counter[tuple[str, str, str]] = Counter()
        for stop in {seeds.stop for _, seeds in self.asked.cases}:
            cases = [case for case, seeds in self.asked.cases if seeds.stop == stop]
            for it, count in self.ledger.provenances(cases, stop):
                found[it.get("commit", ""), it.get("source", ""), it.get("data", "")] += count
        return [(*key, count) for key, count in found.most_common()]

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
    beside: Sequence[tuple[Case, range]] = (),
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
    beside : sequence         cases whose earlier results will stand beside these; nothing of them is flown

    Raises
    ------
    DataFormatError           no such data, a study that its trial cannot fly, or a ledger that cannot be used
    InvalidProblemError       no trial, or no worker
    """
    refuse_none(trials, workers)
    if faults := refused(study):
        raise DataFormatError(*faults)
    place = _place(study, data)
    asked = study.asked(trials)
    crew = _crew(study, place, workers, scheduler)
    new = not (folder / LEDGER).exists()
    try:
        if new:  # so that a study with a fault leaves nothing behind
            _rehearse(study, crew)
        ledger, notes = _opened(folder / LEDGER, study, (*asked.cases, *beside), place, earlier)
    except BaseException:
        crew.close()
        raise
    try:
        if retry:
            ledger.retry(asked.cases)
        if not new and progress_of(asked, ledger).missing:
            _rehearse(study, crew)
        progress = fly(asked, ledger, crew, place, watch, notes)
    except BaseException:
        crew.close()
        ledger.close()
        raise
    return Ran(asked, ledger, progress)


def recall_study(study: Study, folder: Path, trials: int | None = None) -> Ran:
    """What the ledger of a study has, without a flight.

    Raises
    ------
    DataFormatError           nothing has been flown there, or the ledger cannot be used
    """
    refuse_none(trials, None)
    asked = study.asked(trials)
    if not (folder / LEDGER).is_file():
        raise DataFormatError(Fault(str(folder / LEDGER), "", "it is not there", "fly the study first: leave --report"))
    ledger = Ledger(folder / LEDGER, study.key)
    return Ran(asked, ledger, progress_of(asked, ledger))


def progress_of(asked: Asked, ledger: Ledger) -> Progress:
    """How far a ledger is."""
    counts = [ledger.counts(case, seeds) for case, seeds in asked.cases]
    return Progress(len(asked), sum(it.done for it in counts), sum(it.aside for it in counts), 0.0, None)


def refuse_none(trials: int | None, workers: int | None) -> None:
    """Raise InvalidProblemError for no trial, or no worker, or more trials than a study may have."""
    if any(number is not None and number < 1 for number in (trials, workers)):
        raise InvalidProblemError(f"{trials} trials and {workers} workers came; expected at least one of each")
    if trials is not None and trials > MOST_TRIALS:
        raise InvalidProblemError(f"{trials:,} trials came; expected at most {MOST_TRIALS:,} of each case")


def _place(study: Study, data: Path | None) -> Place:
    maps = str(find_data(data, study.file.data, study.file.data_files)) if study.file.data else ""
    return Place(study.file.trial, str(study.folder.resolve()), maps, study.data_files, study.modules)


def _rehearse(study: Study, crew: Crew) -> None:
    """Load what flies trials and make every planner in the process that will fly the first trial."""
    if not isinstance(crew, Pool):  # machines of a cluster may have what this one has not
        return
    faults = []
    for name, reason in crew.rehearse({name: study.told(name) for name in study.usable()}).items():
        if name:
            came, expected = "it cannot be made", "expected a planner that can be made from its settings"
            faults.append(Fault(str(study.path), f"planners.{name}", f"{came} ({in_short(reason)})", expected))
        else:
            came = f"{study.file.trial!r} cannot be loaded ({in_short(reason)})"
            expected = "expected a function in a module beside the study, or in one that is installed"
            faults.append(Fault(str(study.path), "trial", came, expected))
    if faults:
        raise DataFormatError(*faults)


def _crew(study: Study, place: Place, workers: int | None, scheduler: str | None) -> Crew:
    if scheduler is not None:
        from sooner.campaigns.cluster import Cluster

        return Cluster(scheduler, place, study.limits)
    count = workers or cores()
    limits = study.limits
    return Pool(count, place, replace(limits, memory_mb=min(limits.memory_mb, share_of_memory_mb(count))))


def _opened(
    path: Path, study: Study, cases: Sequence[tuple[Case, range]], place: Place, earlier: Earlier
) -> tuple[Ledger, list[str]]:
    """The ledger, and what the user should know of what it holds."""
    ours = provenance(place)
    ledger = Ledger(path, study.key)
    try:
        there = ledger.provenances(dict.fromkeys(case for case, _ in cases))
        kept = ledger.accepted()
        other = [(it, n) for it, n in there if not same_source(ours, it)]
        stale = [(it, n) for it, n in other if earlier == "redo" or (it["source"], it["data"]) not in kept]
        if not stale:
            return ledger, [*_other_packages(ours, there)]
        if earlier == "keep":
            ledger.accept((it["source"], it["data"]) for it, _ in stale)
            return ledger, [*_other_packages(ours, there)]
        if earlier == "redo":
            return ledger, [f"the earlier ledger is now {ledger.begin_anew()}"]
    except BaseException:
        ledger.close()
        raise
    ledger.close()
    commits = ", ".join(sorted({it["commit"] or "unknown" for it, _ in stale}))
    came = f"{sum(count for _, count in stale)} trials were flown by other code or on other maps (commit {commits})"
    raise DataFormatError(
        Fault(str(path), "", came, "say --earlier keep to count them, --earlier redo to fly all of them again")
    )


def _other_packages(ours: Mapping[str, Any], there: Sequence[tuple[dict[str, Any], int]]) -> Iterator[str]:
    """One line where trials that are there were flown with other versions of what sooner needs."""
    now = {"Python": ours["python"], **ours["packages"]}
    changed: dict[str, dict[str, None]] = {}
    trials = 0
    for it, count in there:
        then = {"Python": it.get("python"), **it.get("packages", {})}
        others = {name: then[name] for name in now if then.get(name) and then[name] != now[name]}
        trials += count if others else 0
        for name, version in others.items():
            changed.setdefault(name, {})[version] = None
    if changed:
        told = ", ".join(f"{name} {' and '.join(old)} (now {now[name]})" for name, old in changed.items())
        yield f"{trials:,} trials were flown with {told}"


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
