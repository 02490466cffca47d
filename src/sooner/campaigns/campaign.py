"""The campaign: trials go out to a crew, what comes of them goes into the ledger, until every trial has its row.

It may be ended at any moment, by Ctrl-C or by a power cut, and goes on where it was when it is run again: a trial that
was in the air then is flown again, every other stays as it is.
"""

from __future__ import annotations

import json
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from sooner.campaigns.ledger import ASIDE, DONE, WAITING, Ledger
from sooner.campaigns.provenance import maps, provenance, same_source, sources
from sooner.campaigns.trial import Case, Outcome, Place, Trial, in_short
from sooner.errors import DataFormatError, Fault

__all__ = ["Asked", "Crew", "Progress", "Watch", "fly"]

ATTEMPTS = 2
ATTEMPTS_IF_KILLED = 5  # by somebody else: that says little about the trial
HOPELESS = 20  # attempts of one planner, none of which ever came to a good end
LOOKED_UP = 1_000_000  # trials that are looked up in the ledger at once
TELL_S = 0.25


class Crew(Protocol):
    """Who flies trials: the embedded `Pool`, or a `Cluster`."""

    @property
    def workers(self) -> int:
        """Trials that fly at once; may change while the campaign runs."""

    @property
    def room(self) -> int:
        """Trials to have begun at once: those that fly, and some that wait for a free worker."""

    def start(self, trial: Trial) -> None:
        """Fly it as soon as there is room."""

    def ended(self, wait_s: float) -> list[Outcome]:
        """What has come to its end, after waiting so long at most for the first."""

    def close(self) -> None:
        """Let go of everything."""


@dataclass(frozen=True)
class Asked:
    """Which trials there should be: the same seeds of every case, but for cases with a number of their own.

    Parameters
    ----------
    cases : tuple of (Case, range)      with the seeds of each
    """

    cases: tuple[tuple[Case, range], ...]

    def __len__(self) -> int:
        return sum(len(seeds) for _, seeds in self.cases)


@dataclass(frozen=True)
class Progress:
    """How far the campaign is.

    Parameters
    ----------
    total, done, aside : int         trials; of an earlier run too
    rate : float                     trials that ended in a second of this run
    seconds_left : float or None     from what trials of each case have taken; None while nothing is known
    last_failure : str               what the last attempt that went wrong said, "" if none did
    in_air : int                     trials that fly now, or wait for a free worker
    notes : tuple of str             what the user should know, as it came up
    """

    total: int
    done: int
    aside: int
    rate: float
    seconds_left: float | None
    last_failure: str = ""
    in_air: int = 0
    notes: tuple[str, ...] = ()

    @property
    def missing(self) -> int:
        """Trials that have no answer."""
        return self.total - self.done


Watch = Callable[[Progress], None]


def fly(
    asked: Asked,
    ledger: Ledger,
    crew: Crew,
    place: Place,
    watch: Watch = lambda progress: None,
    notes: Sequence[str] = (),
) -> Progress:
    """Fly every trial that is asked for and has no answer yet.

    Trials go by seeds first, then by cases: a campaign that is cut short is a smaller one, not a lopsided one. Trials
    that were in the air when an earlier campaign died come last, since one of them may be what killed it; trials that
    are flown alone come after all others, one at a time.

    A planner whose first attempts all failed, so many that each of its cases had one, is hopeless: the rest of its
    trials is not flown in this run.

    Raises
    ------
    DataFormatError        the ledger cannot be written, or a worker has other code or other maps
    """
    ledger.recover()
    return _Flying(asked, ledger, crew, place, watch, notes).run()


class _Flying:
    """One run of a campaign."""

    def __init__(
        self, asked: Asked, ledger: Ledger, crew: Crew, place: Place, watch: Watch, notes: Sequence[str]
    ) -> None:
        self.ledger, self.crew, self.watch, self.place = ledger, crew, watch, place
        self.pace = _Pace(asked, ledger)
        self.hopes = _Hopes(asked, self.pace)
        self.queue = _Queue(asked, ledger, self.hopes.none)
        self.in_air: set[Trial] = set()
        self.ended: list[tuple[Outcome, int]] = []
        self.last_failure = ""
        self.notes = list(notes)
        self.source, self.files = provenance(place), {**sources(place), **maps(place)}
        self.trusted: set[str] = set()

    def run(self) -> Progress:
        try:
            self._tell(at_once=True)
            while True:
                begun = self._begun()
                self.ledger.write(self.ended, begun)
                self.ended = []
                for trial in begun:
                    self.crew.start(trial)
                if not self.in_air:
                    break
                self._tell()
                for outcome in self.crew.ended(0.5):
                    self._take(outcome)
        finally:
            self._land()
        self._tell(at_once=True)
        return self._progress()

    def _begun(self) -> list[Trial]:
        """Trials for the places that are free; they are in the air from now on."""
        begun: list[Trial] = []
        while (trial := self.queue.next(self.in_air, self.crew.room)) is not None:
            self.in_air.add(trial)
            begun.append(trial)
        return begun

    def _take(self, outcome: Outcome) -> None:
        if outcome.trial not in self.in_air:  # a cluster may answer twice
            return
        self._same_source(outcome)
        self.in_air.remove(outcome.trial)
        state = self._state(outcome)
        self.ended.append((outcome, state))
        self.pace.take(outcome, state)
        if state == WAITING:
            self.queue.again(outcome.trial)
        if outcome.ending not in ("done", "lost"):
            self.last_failure = f"{outcome.trial}: {outcome.ending}: {in_short(outcome.reason)}"
        if self.hopes.lost(outcome):
            came = f"{outcome.trial.case.planner}: all of its first {self.hopes.failed(outcome.trial)} attempts failed"
            self.notes.append(f"{came}, the rest is not flown; the last one: {self.last_failure}")

    def _state(self, outcome: Outcome) -> int:
        if outcome.ending == "done":
            return DONE
        if outcome.ending == "lost":
            return WAITING
        most = ATTEMPTS_IF_KILLED if outcome.ending == "killed" else ATTEMPTS
        return ASIDE if self.ledger.attempts(outcome.trial) + 1 >= most else WAITING

    def _same_source(self, outcome: Outcome) -> None:
        text = outcome.provenance
        if not text or text in self.trusted:
            return
        theirs = json.loads(text)
        if not same_source(self.source, theirs):
            self._refuse_change()
            came = (
                f"a worker on {theirs['machine']} answered with other code or other maps than ours "
                f"(commit {theirs['commit'] or 'unknown'}, source {theirs['source']}, data {theirs['data'] or 'none'})"
            )
            ours = f"source {self.source['source']}, data {self.source['data'] or 'none'}"
            raise DataFormatError(Fault(str(self.ledger.path), "", came, f"expected {ours} on every machine"))
        self.trusted.add(text)

    def _refuse_change(self) -> None:
        """Say so where a file of ours has changed since we began."""
        now = {**sources(self.place), **maps(self.place)}
        names = sorted(name for name, _ in self.files.items() ^ now.items())
        if names := list(dict.fromkeys(names)):
            came = f"{', '.join(names[:5])}{' and others' if len(names) > 5 else ''} changed while the campaign flew"
            expected = "give the same command again; it asks what to do with the trials that are flown"
            raise DataFormatError(Fault(self.place.folder or str(self.ledger.path), "", came, expected))

    def _land(self) -> None:
        """Whatever happens, keep what has ended and give back what has not."""
        try:
            self.crew.close()
        finally:
            self.ledger.write(self.ended, ())
            self.ledger.release(self.in_air)

    def _tell(self, at_once: bool = False) -> None:
        if at_once or time.perf_counter() - self.pace.told > TELL_S:
            self.pace.told = time.perf_counter()
            self.watch(self._progress())

    def _progress(self) -> Progress:
        progress = self.pace.progress(self.crew.workers)
        return replace(progress, last_failure=self.last_failure, in_air=len(self.in_air), notes=tuple(self.notes))


class _Hopes:
    """Which planners may still come to something."""

    def __init__(self, asked: Asked, pace: _Pace) -> None:
        cases = Counter(case.planner for case, _ in asked.cases)
        self.none: set[str] = set()
        self._most = {planner: max(HOPELESS, count) for planner, count in cases.items()}
        self._good = {case.planner for case, taken in pace.taken.items() if taken[1]}
        self._failed: Counter[str] = Counter()

    def lost(self, outcome: Outcome) -> bool:
        """Whether this attempt was the one too many."""
        planner = outcome.trial.case.planner
        if outcome.ending == "done":
            self._good.add(planner)
        elif outcome.ending != "lost":
            self._failed[planner] += 1
        if planner in self._good or planner in self.none or self._failed[planner] < self._most[planner]:
            return False
        self.none.add(planner)
        return True

    def failed(self, trial: Trial) -> int:
        """Attempts of its planner that failed in this run."""
        return self._failed[trial.case.planner]


class _Queue:
    """Trials that have no answer yet, in the order in which they go out."""

    def __init__(self, asked: Asked, ledger: Ledger, hopeless: Set[str]) -> None:
        self._hopeless = hopeless
        together = [(case, seeds) for case, seeds in asked.cases if not case.alone]
        alone = [(case, seeds) for case, seeds in asked.cases if case.alone]
        self._first = {False: _missing(together, ledger, hopeless), True: _missing(alone, ledger, hopeless)}
        self._again: dict[bool, deque[Trial]] = {False: deque(), True: deque()}
        self._one = False

    def next(self, in_air: Set[Trial], room: int) -> Trial | None:
        """The next trial, if there is room for it."""
        if in_air and (self._one or len(in_air) >= room):
            return None
        trial = self._pop(alone=False)
        if trial is None and not in_air:  # all others are done, second attempts as well
            trial = self._pop(alone=True)
            self._one = True
        return trial

    def again(self, trial: Trial) -> None:
        """Try it once more, after all others."""
        self._again[trial.case.alone].append(trial)

    def _pop(self, alone: bool) -> Trial | None:
        trial = next(self._first[alone], None)
        while trial is None and self._again[alone]:
            again = self._again[alone].popleft()
            trial = None if again.case.planner in self._hopeless else again
        return trial


def _missing(cases: Sequence[tuple[Case, range]], ledger: Ledger, hopeless: Set[str]) -> Iterator[Trial]:
    """Trials without an end, by seed and then by case; those that were once interrupted come last.

    They are looked up as they are needed: a study of many millions begins at once.
    """
    low = min((seeds.start for _, seeds in cases), default=0)
    high = max((seeds.stop for _, seeds in cases), default=0)
    at_once = max(LOOKED_UP // max(len(cases), 1), 1)
    for start in range(low, high, at_once):
        left = np.zeros((min(at_once, high - start), len(cases)), bool)
        for column, (case, seeds) in enumerate(cases):
            part = range(max(start, seeds.start), min(start + at_once, seeds.stop))
            if not part or case.planner in hopeless:
                continue
            left[part.start - start : part.stop - start, column] = True
            begun, states, interrupted = ledger.states(case, part)
            left[begun[(states != WAITING) | (interrupted > 0)] - start, column] = False
        for row, column in np.argwhere(left).tolist():
            if cases[column][0].planner not in hopeless:
                yield Trial(cases[column][0], start + row)
    last = [(n, Trial(case, seed)) for case, seeds in cases for seed, n in ledger.interrupted(case, seeds)]
    for _, trial in sorted(last, key=lambda each: each[0]):
        if trial.case.planner not in hopeless:
            yield trial


class _Pace:
    """What is done, how fast it goes, and how long the rest will take."""

    def __init__(self, asked: Asked, ledger: Ledger) -> None:
        self.total, self.told, self.began = len(asked), 0.0, time.perf_counter()
        self.done = self.aside = self.this_run = 0
        self.taken: dict[Case, list[float]] = {}  # seconds, trials
        self._left: dict[Case, int] = {}
        for case, seeds in asked.cases:
            counts = ledger.counts(case, seeds)
            self.done, self.aside = self.done + counts.done, self.aside + counts.aside
            self._left[case] = len(seeds) - counts.done - counts.aside
            self.taken[case] = [counts.wall_s * counts.done, counts.done]

    def take(self, outcome: Outcome, state: int) -> None:
        """An attempt has ended."""
        if state == WAITING:
            return
        self.this_run += 1
        self._left[outcome.trial.case] -= 1
        if state == ASIDE:
            self.aside += 1
            return
        self.done += 1
        taken = self.taken[outcome.trial.case]
        taken[0], taken[1] = taken[0] + outcome.wall_s, taken[1] + 1

    def progress(self, workers: int) -> Progress:
        """So far."""
        rate = self.this_run / max(time.perf_counter() - self.began, 1e-9)
        return Progress(self.total, self.done, self.aside, rate, self._seconds_left(workers))

    def _seconds_left(self, workers: int) -> float | None:
        seconds, trials = (sum(taken[part] for taken in self.taken.values()) for part in (0, 1))
        if not trials:
            return None
        left = {False: 0.0, True: 0.0}
        for case, number in self._left.items():
            took, of = self.taken[case]
            left[case.alone] += number * (took / of if of else seconds / trials)
        return left[False] / max(workers, 1) + left[True]
