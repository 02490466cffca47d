"""`sooner study` and `sooner reproduce`: campaigns of trials."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from sooner.cli.exits import BAD_INPUT, DONE, say
from sooner.errors import DataFormatError, Fault

if TYPE_CHECKING:
    from sooner.campaigns import Progress
    from sooner.campaigns.run import Earlier

__all__ = ["Wishes", "reproduce", "study"]

PAPERS = ("lin2014", "kuhlman2017", "wolek2020")
EARLIER = ("ask", "keep", "redo")


@dataclass(frozen=True)
class Wishes:
    """What both commands take."""

    data: Path | None
    trials: int | None
    workers: int | None
    out: Path | None
    scheduler: str | None
    earlier: str
    retry: bool
    report: bool
    json: bool
    quiet: bool
    force: bool

    def checked(self) -> Earlier:
        """How to treat earlier results; refuses a folder of maps that is not there."""
        if self.data is not None and not self.data.is_dir():
            raise DataFormatError(Fault("--data", "", f"{str(self.data)!r} came", "expected a folder that exists"))
        if self.report and (self.retry or self.earlier != "ask"):
            came, expected = "it came with --retry or --earlier", "leave them out: it flies nothing"
            raise DataFormatError(Fault("--report", "", came, expected))
        if self.scheduler is not None and self.workers is not None:
            raise DataFormatError(
                Fault("--workers", "", f"{self.workers} came with --scheduler", "the cluster has its own; leave it out")
            )
        for word in ("ask", "keep", "redo"):
            if self.earlier == word:
                return word
        raise DataFormatError(Fault("--earlier", "", f"{self.earlier!r} came", f"expected one of {', '.join(EARLIER)}"))


def study(file: Path, wishes: Wishes) -> int:
    """Fly a study of the user's own."""
    earlier = wishes.checked()
    from sooner.campaigns.report import REPORT, write_report
    from sooner.campaigns.run import recall_study, run_study
    from sooner.campaigns.study import read_study
    from sooner.experiments.tables import tables_files
    from sooner.io.writing import Folder

    read = read_study(file)
    name = "study" if file.is_dir() else file.stem
    out = Folder(wishes.out or read.folder / f"{name}-results", wishes.force)
    out.check(*REPORT, *(("tables.md", "tables.csv") if read.file.tables else ()))
    with (
        Watch(wishes.quiet) as watch,
        recall_study(read, out.path, wishes.trials)
        if wishes.report
        else run_study(
            read,
            out.path,
            wishes.data,
            wishes.trials,
            wishes.workers,
            wishes.scheduler,
            earlier,
            wishes.retry,
            watch.tell,
        ) as ran,
    ):
        report = write_report(ran, read.file.title, out, tables_files(read, ran), read.file.measure)
        aside = [(str(trial), ending, reason) for trial, ending, reason in ran.set_aside()]
    return _ended(wishes, ran.progress, [*report.files, out.path / "trials.sqlite"], aside, report.notes)


def reproduce(paper: str, only: list[str], wishes: Wishes) -> int:
    """Fly a paper's study, and compare."""
    if paper not in PAPERS:
        raise DataFormatError(Fault("reproduce", "", f"{paper!r} came", f"expected {' or '.join(PAPERS)}"))
    earlier = wishes.checked()
    from sooner.experiments import reproduce as run

    with Watch(wishes.quiet) as watch:
        found = run(
            paper,
            wishes.data,
            wishes.trials,
            wishes.workers,
            wishes.out,
            only or ["*"],
            True,
            wishes.scheduler,
            earlier,
            wishes.retry,
            wishes.force,
            watch.tell,
            wishes.report,
        )
    return _ended(wishes, found.progress, found.files, found.aside, found.notes)


def _ended(wishes: Wishes, progress: Progress, files: Any, aside: Any, notes: Any) -> int:
    """Say what there is now."""
    from sooner.campaigns.trial import in_short

    for trial, ending, reason in aside[:10]:
        say(f"set aside: {trial}: {ending}: {in_short(reason)}")
    for note in notes:
        say(f"note: {note}")
    if wishes.json:
        told = {"trials": progress.total, "done": progress.done, "aside": progress.aside}
        print(json.dumps({**told, "files": [str(file) for file in files]}))
    else:
        for file in files:
            print(f"written  {file}")
    if not progress.missing:
        return DONE
    retry = f"; {progress.aside:,} trials were set aside; --retry flies them again" if progress.aside else ""
    say(f"{progress.missing:,} of {progress.total:,} trials have no answer{retry}")
    return BAD_INPUT


class Watch:
    """Tells how a campaign goes, on stderr: a live line on a terminal, now and then a plain one elsewhere."""

    def __init__(self, quiet: bool) -> None:
        self.quiet = quiet
        self._live: Any = None
        self._told = self._began = time.perf_counter()
        self._last: Progress | None = None
        self._noted = 0

    def __enter__(self) -> Watch:
        if not self.quiet and sys.stderr.isatty():
            from rich.console import Console
            from rich.live import Live

            self._live = Live(console=Console(stderr=True), refresh_per_second=4, transient=True)
            self._live.start()
        return self

    def tell(self, progress: Progress) -> None:
        """Show the progress, not more often than anyone can read."""
        first, self._last = self._last is None, progress
        for note in progress.notes[self._noted :]:
            self._note(note)
        self._noted = len(progress.notes)
        if self.quiet:
            return
        if first and progress.done:
            say(f"{progress.done:,} of {progress.total:,} trials were flown before")
        if self._live is not None:
            from rich.text import Text

            self._live.update(Text(_line(progress), no_wrap=True, overflow="ellipsis"))
        elif first or time.perf_counter() - self._told > PLAIN_S or progress.done + progress.aside == progress.total:
            self._told = time.perf_counter()
            say(_line(progress))

    def _note(self, note: str) -> None:
        if self._live is not None:
            self._live.console.print(f"note: {note}", markup=False, highlight=False)
        else:
            say(f"note: {note}")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()
        if isinstance(error, KeyboardInterrupt):
            kept = f"{self._last.done:,} of {self._last.total:,} trials are kept; " if self._last is not None else ""
            then = "the same command goes on from there, with --report it tells of those"
            raise KeyboardInterrupt(f"interrupted; {kept}{then}") from None


PLAIN_S = 10.0


def _line(progress: Progress) -> str:
    parts = [f"{progress.done:,} of {progress.total:,} trials"]
    if progress.aside:
        parts.append(f"{progress.aside:,} set aside")
    if progress.rate:
        parts.append(f"{progress.rate:.3g} a second" if progress.rate >= 1 else f"{60 * progress.rate:.3g} a minute")
    if progress.seconds_left is not None and progress.seconds_left >= 1:
        parts.append(f"{_duration(progress.seconds_left)} left")
    elif progress.in_air:
        parts.append(f"{progress.in_air} in the air")
    if progress.last_failure:
        parts.append(f"last failure: {progress.last_failure}")
    return "   ".join(parts)


def _duration(seconds: float) -> str:
    """As people say it: 40 s, 12 min, 3.5 h, 2 days."""
    for unit, size, most in (("s", 1, 100), ("min", 60, 100), ("h", 3600, 48)):
        if seconds < most * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 10 * size else f"{seconds / size:.0f} {unit}"
    return f"{seconds / 86400:.3g} days"
