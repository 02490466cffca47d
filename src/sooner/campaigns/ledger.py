"""The ledger: one durable row for each trial that was begun, in SQLite.

A trial that has no row was never begun; which trials there should be is the study's to say. So a study may grow, and
its ledger grows with it. Only the campaign writes: workers answer to it, and a worker whose campaign is gone has nobody
to answer to. That, and the key (case, seed), is why no trial can count twice.

::

    ledger      what study this is
    cases       every case that was ever begun, as one text
    provenance  every commit, set of packages and processor that flew a trial
    trials      case, seed, state (leased, done, waiting to be flown again, set aside), what it took, provenance
    answers     what a trial that is done said, as JSON
    failures    every attempt that went wrong: how, why, when
    accepted    sources and maps of earlier trials that the user has said to keep
"""

from __future__ import annotations

import json
import sqlite3
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.campaigns.trial import Case, Outcome, Trial
from sooner.errors import DataFormatError, Fault

__all__ = ["ASIDE", "DONE", "LEASED", "WAITING", "Counts", "Ledger"]

LEASED, DONE, WAITING, ASIDE = 1, 2, 3, 4
STATES = {LEASED: "leased", DONE: "done", WAITING: "waiting", ASIDE: "aside"}
APPLICATION = 0x536F6F6E  # "Soon"
VERSION = 1

SCHEMA = """
CREATE TABLE ledger(study TEXT NOT NULL, made_by TEXT NOT NULL, made_at REAL NOT NULL);
CREATE TABLE cases(
    id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE,
    instance TEXT NOT NULL, planner TEXT NOT NULL, budget, alone INTEGER NOT NULL
);
CREATE TABLE accepted(source TEXT NOT NULL, data TEXT NOT NULL, PRIMARY KEY(source, data));
CREATE TABLE provenance(id INTEGER PRIMARY KEY, text TEXT NOT NULL UNIQUE);
CREATE TABLE trials(
    id INTEGER PRIMARY KEY,
    case_id INTEGER NOT NULL REFERENCES cases(id),
    seed INTEGER NOT NULL,
    state INTEGER NOT NULL,
    attempts INTEGER NOT NULL DEFAULT 0,
    interrupted INTEGER NOT NULL DEFAULT 0,
    wall_s REAL, cpu_s REAL, memory_mb REAL, ended_at REAL,
    provenance_id INTEGER REFERENCES provenance(id),
    UNIQUE(case_id, seed)
);
CREATE TABLE answers(trial_id INTEGER PRIMARY KEY REFERENCES trials(id), answer TEXT NOT NULL);
CREATE TABLE failures(
    id INTEGER PRIMARY KEY, trial_id INTEGER NOT NULL REFERENCES trials(id), ending TEXT NOT NULL, reason TEXT NOT NULL,
    wall_s REAL, memory_mb REAL, ended_at REAL, provenance_id INTEGER REFERENCES provenance(id)
);
CREATE INDEX failures_of_trial ON failures(trial_id);
"""


@dataclass(frozen=True)
class Counts:
    """How far a case is.

    Parameters
    ----------
    done, aside : int      trials with an answer, trials set aside
    wall_s : float         mean of those done
    """

    done: int
    aside: int
    wall_s: float


class Ledger:
    """The trials of one study in one file, open for one campaign.

    Parameters
    ----------
    path : Path
    study : str               key of the study; a ledger of another study is refused

    Raises
    ------
    DataFormatError           no ledger of this study and version, in use by another campaign, or not to be written
    """

    def __init__(self, path: Path, study: str) -> None:
        self.path, self.study = path, study
        self._case_ids: dict[str, int] = {}
        self._provenance_ids: dict[str, int] = {}
        if path.is_dir():
            raise self._refusal("it is a folder; expected a file", "give another --out")
        with self._told():
            self._lock = _locked(path)
            try:
                self._base = sqlite3.connect(path, isolation_level=None, timeout=30.0)
                self._open()
            except BaseException:
                self.close()
                raise

    def __enter__(self) -> Ledger:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let others have it."""
        with suppress(sqlite3.Error):
            if (base := getattr(self, "_base", None)) is not None:
                base.close()
        self._lock.close()

    # ------------------------------------------------------------ opening

    def _open(self) -> None:
        (application,) = self._base.execute("PRAGMA application_id").fetchone()
        (version,) = self._base.execute("PRAGMA user_version").fetchone()
        (tables,) = self._base.execute("SELECT count(*) FROM sqlite_master").fetchone()
        if application == 0 and version == 0 and tables == 0:  # new, or its maker was killed
            self._begin()
        elif application != APPLICATION:
            raise self._refusal("it is a database, but no ledger of sooner's")
        elif version != VERSION:
            made = self._base.execute("SELECT made_by FROM ledger").fetchone()
            by = f" (by sooner {made[0]})" if made else ""
            raise self._refusal(
                f"it is a ledger of version {version}{by}; this sooner keeps version {VERSION}",
                "finish it with the sooner that made it, or give another --out",
            )
        (theirs,) = self._base.execute("SELECT study FROM ledger").fetchone()
        if theirs != self.study:
            raise self._refusal(f"it is the ledger of the study {theirs!r}, not of {self.study!r}")
        (sound,) = self._base.execute("PRAGMA quick_check(1)").fetchone()  # half a second for a million trials
        if sound != "ok":
            raise self._refusal(f"it is a damaged ledger ({sound})")
        self._base.execute("PRAGMA journal_mode = WAL")  # where the disk cannot, it stays as it was: slower, as durable
        self._base.execute("PRAGMA synchronous = FULL")
        self._base.execute("UPDATE ledger SET study = study")  # asks the disk whether we may write

    def _begin(self) -> None:
        from sooner import __version__

        with self._transaction():
            for statement in SCHEMA.split(";"):
                self._base.execute(statement)
            self._base.execute("INSERT INTO ledger VALUES (?, ?, ?)", (self.study, __version__, time.time()))
            self._base.execute(f"PRAGMA application_id = {APPLICATION}")
            self._base.execute(f"PRAGMA user_version = {VERSION}")

    def begin_anew(self) -> Path:
        """Give this ledger another name and begin an empty one in its place; answers that name."""
        number = 1
        while (other := self.path.with_name(f"{self.path.stem}-{number}{self.path.suffix}")).exists():
            number += 1
        with self._told():
            self._base.close()  # what still stood in its log goes into the file
            self.path.replace(other)
            self._case_ids.clear()
            self._provenance_ids.clear()
            self._base = sqlite3.connect(self.path, isolation_level=None, timeout=30.0)
            self._open()
        return other

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All of it on the disk, or nothing."""
        self._base.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._base.execute("COMMIT")
        except BaseException:
            self._case_ids.clear()
            self._provenance_ids.clear()
            with suppress(sqlite3.Error):
                self._base.execute("ROLLBACK")
            raise

    @contextmanager
    def _told(self) -> Iterator[None]:
        """What SQLite or the system says, in words that help."""
        try:
            yield
        except sqlite3.DatabaseError as error:
            said = str(error)
            if "full" in said:
                expected = "make room and give the same command again; every trial that was recorded is kept"
                raise DataFormatError(Fault(str(self.path), "", "the disk is full", expected)) from None
            if "not a database" in said or "malformed" in said:
                raise self._refusal(f"it is no ledger, or a damaged one ({said})") from None
            expected = "expected a folder and a ledger that can be written to; give another --out"
            raise DataFormatError(Fault(str(self.path), "", f"it cannot be written ({said})", expected)) from None
        except OSError as error:
            expected = "expected a folder that can be written to; give another --out"
            raise DataFormatError(Fault(str(self.path), "", str(error.strerror or error), expected)) from None

    def _refusal(self, came: str, expected: str = "move it, or give another --out") -> DataFormatError:
        return DataFormatError(Fault(str(self.path), "", came, f"{expected}; nothing was changed"))

    # ------------------------------------------------------------ what is known

    def states(self, case: Case, seeds: range) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Seeds of these that were begun, their states, and how often each was interrupted."""
        with self._told():
            rows = self._base.execute(
                "SELECT seed, state, interrupted FROM trials WHERE case_id = ? AND seed >= ? AND seed < ?",
                (self._known(case), seeds.start, seeds.stop),
            ).fetchall()
        table = np.array(rows, np.int64).reshape(-1, 3)
        return table[:, 0], table[:, 1], table[:, 2]

    def interrupted(self, case: Case, seeds: range) -> list[tuple[int, int]]:
        """Seeds that wait to be flown again because a campaign ended under them, and how often one did."""
        with self._told():
            rows: list[tuple[int, int]] = self._base.execute(
                "SELECT seed, interrupted FROM trials WHERE case_id = ? AND seed >= ? AND seed < ? AND state = ? "
                "AND interrupted > 0 ORDER BY seed",
                (self._known(case), seeds.start, seeds.stop, WAITING),
            ).fetchall()
        return rows

    def counts(self, case: Case, seeds: range) -> Counts:
        """How far a case is, of the seeds that are asked for."""
        found: dict[int, int] = {}
        mean = 0.0
        with self._told():
            rows = self._base.execute(
                "SELECT state, count(*), avg(wall_s) FROM trials "
                "WHERE case_id = ? AND seed >= ? AND seed < ? GROUP BY state",
                (self._known(case), seeds.start, seeds.stop),
            )
            for state, count, wall_s in rows:
                found[state] = count
                mean = wall_s if state == DONE else mean
        return Counts(found.get(DONE, 0), found.get(ASIDE, 0), mean or 0.0)

    def answers(self, case: Case, seeds: range) -> Iterator[tuple[int, dict[str, Any]]]:
        """Seed and answer of the trials that are done, by seed."""
        with self._told():
            rows = self._base.execute(
                "SELECT seed, answer FROM trials JOIN answers ON trial_id = trials.id "
                "WHERE case_id = ? AND state = ? AND seed >= ? AND seed < ? ORDER BY seed",
                (self._known(case), DONE, seeds.start, seeds.stop),
            )
            for seed, answer in rows:
                yield seed, json.loads(answer)

    def rows(self, case: Case, seeds: range) -> Iterator[dict[str, Any]]:
        """Everything the ledger has of each trial that was begun, by seed: for the reader's own analysis."""
        columns = (
            "seed", "state", "attempts", "wall_s", "cpu_s", "memory_mb", "ended_at", "provenance", "reason", "answer"
        )  # fmt: skip
        with self._told():
            rows = self._base.execute(
                "SELECT seed, state, attempts, wall_s, cpu_s, memory_mb, ended_at, provenance.text, "
                "(SELECT ending || ': ' || reason FROM failures WHERE trial_id = trials.id ORDER BY id DESC LIMIT 1), "
                "answer FROM trials LEFT JOIN answers ON trial_id = trials.id "
                "LEFT JOIN provenance ON provenance.id = provenance_id "
                "WHERE case_id = ? AND seed >= ? AND seed < ? ORDER BY seed",
                (self._known(case), seeds.start, seeds.stop),
            )
            for row in rows:
                found = dict(zip(columns, row, strict=True))
                yield found | {"state": STATES[found["state"]], "answer": json.loads(found["answer"] or "{}")}

    def provenances(self, cases: Iterable[Case], below: int | None = None) -> list[tuple[dict[str, Any], int]]:
        """What flew the trials that are done, and how many of them; of all seeds or of those below a number."""
        with self._told():
            known = {id_ for case in cases if (id_ := self._known(case)) >= 0}
            texts = dict(self._base.execute("SELECT id, text FROM provenance"))
            rows = self._base.execute(  # as they lie: a quarter of the time of going by the index
                "SELECT case_id, provenance_id, count(*) FROM trials NOT INDEXED WHERE state = ? AND seed < ? "
                "GROUP BY case_id, provenance_id",
                (DONE, 2**62 if below is None else below),
            ).fetchall()
        found: dict[str, int] = {}
        for case_id, provenance_id, count in rows:
            if case_id in known:
                text = texts[provenance_id]
                found[text] = found.get(text, 0) + count
        return [(json.loads(text), count) for text, count in found.items()]

    def accepted(self) -> set[tuple[str, str]]:
        """Sources and maps of earlier trials that the user has said to keep."""
        with self._told():
            return set(self._base.execute("SELECT source, data FROM accepted"))

    def failures(self, cases: Iterable[Case]) -> list[tuple[Trial, str, str]]:
        """Trials that are set aside, how their last attempt ended, and why."""
        with self._told():
            by_id = {self._known(case): case for case in cases}
            rows = self._base.execute(
                "SELECT case_id, seed, ending, reason FROM trials JOIN failures ON trial_id = trials.id "
                "WHERE state = ? GROUP BY trials.id HAVING failures.id = max(failures.id) ORDER BY case_id, seed",
                (ASIDE,),
            ).fetchall()
        return [(Trial(by_id[id_], seed), ending, reason) for id_, seed, ending, reason in rows if id_ in by_id]

    # ------------------------------------------------------------ what happens

    def recover(self) -> int:
        """Take back the leases of a campaign that ended without a word; answers how many there were."""
        with self._told(), self._transaction():
            taken = self._base.execute(
                "UPDATE trials SET state = ?, interrupted = interrupted + 1 WHERE state = ?", (WAITING, LEASED)
            )
            return taken.rowcount

    def accept(self, pairs: Iterable[tuple[str, str]]) -> None:
        """Remember that trials of this source and these maps are to be kept."""
        with self._told(), self._transaction():
            self._base.executemany("INSERT OR IGNORE INTO accepted VALUES (?, ?)", pairs)

    def retry(self, cases: Iterable[tuple[Case, range]]) -> None:
        """Give those of these trials that were set aside another chance."""
        with self._told(), self._transaction():
            self._base.executemany(
                "UPDATE trials SET state = ?, attempts = 0 WHERE case_id = ? AND seed >= ? AND seed < ? AND state = ?",
                [(WAITING, self._known(case), seeds.start, seeds.stop, ASIDE) for case, seeds in cases],
            )

    def write(self, ended: Sequence[tuple[Outcome, int]], leased: Sequence[Trial]) -> None:
        """Record what ended, with its new state, and what is begun: one transaction, on the disk when this returns."""
        if not ended and not leased:
            return
        with self._told(), self._transaction():
            for outcome, state in ended:
                self._end(outcome, state)
            self._base.executemany(
                "INSERT INTO trials(case_id, seed, state) VALUES (?, ?, ?) "
                "ON CONFLICT(case_id, seed) DO UPDATE SET state = excluded.state WHERE state = ?",
                [(self._case_id(trial.case), trial.seed, LEASED, WAITING) for trial in leased],
            )

    def release(self, trials: Iterable[Trial]) -> None:
        """Take back leases of trials that were not finished, and are not to blame for it."""
        with self._told(), self._transaction():
            self._base.executemany(
                "UPDATE trials SET state = ? WHERE case_id = ? AND seed = ? AND state = ?",
                [(WAITING, self._case_id(trial.case), trial.seed, LEASED) for trial in trials],
            )

    def _end(self, outcome: Outcome, state: int) -> None:
        row = self._base.execute(
            "SELECT id FROM trials WHERE case_id = ? AND seed = ? AND state = ?",
            (self._case_id(outcome.trial.case), outcome.trial.seed, LEASED),
        ).fetchone()
        if row is None:  # nobody asked for it, or it came twice
            return
        by, now = self._provenance_id(outcome.provenance), time.time()
        charged = 0 if outcome.ending == "lost" else 1
        self._base.execute(
            "UPDATE trials SET state = ?, attempts = attempts + ?, wall_s = ?, cpu_s = ?, memory_mb = ?, ended_at = ?, "
            "provenance_id = ? WHERE id = ?",
            (state, charged, outcome.wall_s, outcome.cpu_s, outcome.memory_mb, now, by, *row),
        )
        if state == DONE:
            self._base.execute("INSERT INTO answers VALUES (?, ?)", (*row, outcome.answer))
        elif charged:
            self._base.execute(
                "INSERT INTO failures(trial_id, ending, reason, wall_s, memory_mb, ended_at, provenance_id) "
                "VALUES (?, ?, ?, ?, ?, ?, ?)",
                (*row, outcome.ending, outcome.reason, outcome.wall_s, outcome.memory_mb, now, by),
            )

    def attempts(self, trial: Trial) -> int:
        """How often it was tried and is to blame for how that ended."""
        with self._told():
            row = self._base.execute(
                "SELECT attempts FROM trials WHERE case_id = ? AND seed = ?", (self._known(trial.case), trial.seed)
            ).fetchone()
        return 0 if row is None else int(row[0])

    # ------------------------------------------------------------ numbers for texts

    def _known(self, case: Case) -> int:
        """Number of a case, -1 where none of its trials was ever begun."""
        if case.key not in self._case_ids:
            row = self._base.execute("SELECT id FROM cases WHERE key = ?", (case.key,)).fetchone()
            if row is None:
                return -1
            self._case_ids[case.key] = row[0]
        return self._case_ids[case.key]

    def _case_id(self, case: Case) -> int:
        if (known := self._known(case)) >= 0:
            return known
        row = (case.key, case.instance, case.planner, case.budget, case.alone)
        self._base.execute("INSERT INTO cases(key, instance, planner, budget, alone) VALUES (?, ?, ?, ?, ?)", row)
        return self._known(case)

    def _provenance_id(self, text: str) -> int:
        if text not in self._provenance_ids:
            self._base.execute("INSERT OR IGNORE INTO provenance(text) VALUES (?)", (text,))
            row = self._base.execute("SELECT id FROM provenance WHERE text = ?", (text,)).fetchone()
            self._provenance_ids[text] = row[0]
        return self._provenance_ids[text]


def _locked(path: Path) -> sqlite3.Connection:
    """A lock that goes away with this process, however it ends: a database that nobody else can begin to write."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f"{path.name}.lock")
    lock = sqlite3.connect(beside, isolation_level=None, timeout=0.0)
    try:
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.OperationalError as error:
        lock.close()
        if "locked" not in str(error):
            raise
        expected = "wait until it ends, or give another --out"
        raise DataFormatError(Fault(str(path), "", "another sooner is flying this campaign", expected)) from None
    return lock
