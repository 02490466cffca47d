"""A place for one trial at a time, in a process of its own that may crash, hang or eat its memory.

Why not an executor of the library: there a dead worker takes every other trial with it, a hanging one cannot be ended,
and none may start inside a worker of Dask. One process behind two pipes has none of these limits, and the embedded pool
and the cluster fly through the same one.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import IO, Any

from sooner.campaigns.trial import Ending, Limits, Outcome, Place, Trial

__all__ = ["Slot"]

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
WORKER = "sooner.campaigns.worker"
WATCH_S = 0.2
REHEARSALS = 5
START_S = 300.0  # to import and compile, on a machine that is busy
FROM_OUTSIDE = (signal.SIGTERM, getattr(signal, "SIGKILL", signal.SIGTERM), getattr(signal, "SIGHUP", signal.SIGTERM))


@dataclass(frozen=True)
class _End:
    """How a process ended while it was waited for."""

    ending: Ending
    reason: str
    seconds: float


class Slot:
    """Flies one trial after the other; `run` always comes back with an outcome.

    The process starts with the first trial, stays for the next (its kernels loaded), and is started anew after it
    died or was ended.

    Parameters
    ----------
    place : Place
    limits : Limits
    """

    def __init__(self, place: Place, limits: Limits) -> None:
        self.place, self.limits = place, limits
        self._process: subprocess.Popen[str] | None = None
        self._errors: IO[bytes] | None = None
        self._lines: SimpleQueue[str] = SimpleQueue()
        self._provenance = ""
        self._closed = False
        self._most_mb = 0.0

    def run(self, trial: Trial) -> Outcome:
        """Fly a trial within the limits."""
        self._most_mb = 0.0
        said = self._ready() or self._asked([trial.case.key, trial.seed], self.limits)
        if isinstance(said, _End):
            return Outcome(
                trial, said.ending, "", said.reason, said.seconds, 0.0, self._most_mb, provenance=self._provenance
            )
        told = json.loads(said)
        told["memory_mb"] = max(told["memory_mb"], self._most_mb)
        return Outcome(trial, told.pop("ending", "done"), **told, provenance=self._provenance)

    def rehearse(self, planners: Mapping[str, Any]) -> dict[str, str]:
        """Load what flies trials and make these planners, without a flight: which cannot be, and why.

        The key "" is that of the function that flies trials. A process that somebody ends meanwhile says nothing of
        them, so it is started again; where that goes on, trials will show.
        """
        for _ in range(REHEARSALS):
            said = self._ready() or self._asked([planners, None], Limits(START_S))
            if not isinstance(said, _End):
                cannot: dict[str, str] = json.loads(said)["cannot"]
                return cannot
            if said.ending != "killed":
                return {"": said.reason}
        return {}

    def close(self) -> None:
        """End the process; may be called from another thread."""
        self._closed = True
        if (process := self._process) is not None:
            _end(process)

    def drop(self) -> None:
        """End the process and let go of its pipes; for the thread that runs trials here, or after it."""
        if self._process is not None:
            _end(self._process)
            self._process.wait()
            with suppress(OSError):  # a row that nobody read
                if self._process.stdin is not None:
                    self._process.stdin.close()
        if self._errors is not None:
            self._errors.close()
        self._process = self._errors = None

    def _ready(self) -> _End | None:
        """A process that waits for a row; or how it failed to come up."""
        if self._process is not None and self._process.poll() is None:
            return None
        self._start()
        told = self._line(Limits(START_S))
        if isinstance(told, _End):
            return told
        first = "unfit" not in json.loads(told)
        self._provenance = told.strip() if first else ""
        ready = self._line(Limits(START_S)) if first else told
        if isinstance(ready, _End):
            return ready
        if unfit := json.loads(ready).get("unfit"):
            self.drop()
            return _End("error", unfit, 0.0)
        return None

    def _start(self) -> None:
        self.drop()
        self._lines = SimpleQueue()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        _append_to(self._errors)
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", WORKER, json.dumps(asdict(self.place)), str(os.getpid())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            encoding="utf-8",
            start_new_session=True,  # so that it can be ended with all that it started
            env=os.environ | dict.fromkeys(ONE_THREAD, "1"),
        )
        if self._closed:  # while we started it
            _end(self._process)
        threading.Thread(target=_relay, args=(self._process.stdout, self._lines), daemon=True).start()

    def _asked(self, row: list[Any], limits: Limits) -> str | _End:
        """Send the row, wait for its answer."""
        assert self._process is not None
        assert self._process.stdin is not None
        assert self._errors is not None
        self._errors.truncate(0)
        try:
            self._process.stdin.write(json.dumps(row) + "\n")
            self._process.stdin.flush()
        except OSError:  # it died between two trials
            return self._ended("crash", 0.0)
        return self._line(limits)

    def _line(self, limits: Limits) -> str | _End:
        """What the process says next, or how it ended."""
        assert self._process is not None
        began, over = time.perf_counter(), False
        while True:
            try:
                line = self._lines.get(timeout=WATCH_S)
            except Empty:
                taken = time.perf_counter() - began
                if over:  # it ended a while ago, but a process of its own keeps the pipe open
                    return self._ended("crash", taken)
                over = self._process.poll() is not None
                if taken > limits.seconds:
                    return self._ended("hang", taken, f"it had no answer after {limits.seconds:g} s")
                self._most_mb = max(self._most_mb, used := _resident_mb(self._process.pid))
                if used > limits.memory_mb:
                    reason = f"{used:.0f} MB were resident; the limit is {limits.memory_mb:.0f}"
                    return self._ended("memory", taken, reason)
                continue
            return line if line else self._ended("crash", time.perf_counter() - began)

    def _ended(self, ending: Ending, seconds: float, reason: str = "") -> _End:
        """The process is over: by our hand where there is a reason, else by its own or by somebody else's."""
        assert self._process is not None
        if reason:
            _end(self._process)
        code = self._process.wait()
        if not reason:
            ending = "killed" if -code in FROM_OUTSIDE else ending
            reason = f"its process ended with {_named(code)}"
        reason = f"{reason}\n{self._last_words()}".strip()
        self.drop()
        return _End(ending, reason, seconds)

    def _last_words(self) -> str:
        assert self._errors is not None
        size = self._errors.seek(0, os.SEEK_END)
        self._errors.seek(max(size - 4000, 0))
        return self._errors.read().decode("utf-8", "replace")


def _end(process: subprocess.Popen[str]) -> None:
    """A process and all that it started."""
    if process.poll() is not None:  # what it started is ended by its guard
        return
    children = _children(process.pid)
    if sys.platform == "win32":
        process.kill()
    else:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    import psutil

    for child in children:  # some may have left the group
        with suppress(psutil.Error):
            child.kill()


def _children(pid: int) -> list[Any]:
    """Its children, theirs, and so on."""
    import psutil

    try:
        return list(psutil.Process(pid).children(recursive=True))
    except psutil.Error:
        return []


def _resident_mb(pid: int) -> float:
    """What a process and all that it started have in memory."""
    import psutil

    whole = 0.0
    for each in (pid, *_below(pid)):
        with suppress(psutil.Error):
            whole += float(psutil.Process(each).memory_info().rss) / 2**20
    return whole


def _below(pid: int) -> list[int]:
    """Numbers of its children, theirs, and so on: from the kernel's own list where it keeps one."""
    found: list[int] = []
    tasks = Path(f"/proc/{pid}/task")
    if not (tasks / str(pid) / "children").exists():
        return [child.pid for child in _children(pid)]
    with suppress(OSError):
        for task in tasks.iterdir():
            with suppress(OSError):
                for child in map(int, (task / "children").read_text(encoding="ascii").split()):
                    found += [child, *_below(child)]
    return found


def _append_to(file: IO[bytes]) -> None:
    """Whoever writes to it writes at its end, even where it has been cut."""
    with suppress(ImportError):  # Windows
        from fcntl import F_GETFL, F_SETFL, fcntl

        fcntl(file, F_SETFL, fcntl(file, F_GETFL) | os.O_APPEND)


def _relay(answers: IO[str], lines: SimpleQueue[str]) -> None:
    """Hand whole lines on until the process ends; then an empty one."""
    with suppress(ValueError), answers:  # bytes that are no text
        for line in answers:
            if line.endswith("\n"):
                lines.put(line)
    lines.put("")


def _named(code: int) -> str:
    try:
        return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"
    except ValueError:
        return f"signal {-code}"
