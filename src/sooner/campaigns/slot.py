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
from contextlib import suppress
from dataclasses import asdict, dataclass
from queue import Empty, SimpleQueue
from typing import IO

from sooner.campaigns.trial import Ending, Limits, Outcome, Place, Trial

__all__ = ["Slot"]

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
WORKER = "sooner.campaigns.worker"
WATCH_S = 0.2
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

    def run(self, trial: Trial) -> Outcome:
        """Fly a trial within the limits."""
        said = self._ready() or self._asked(trial)
        if isinstance(said, _End):
            return Outcome(trial, said.ending, "", said.reason, said.seconds, provenance=self._provenance)
        told = json.loads(said)
        return Outcome(trial, told.pop("ending", "done"), **told, provenance=self._provenance)

    def close(self) -> None:
        """End the process; may be called from another thread."""
        self._closed = True
        if (process := self._process) is not None:
            process.kill()

    def drop(self) -> None:
        """End the process and let go of its pipes; for the thread that runs trials here, or after it."""
        if self._process is not None:
            self._process.kill()
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
        self._provenance = told.strip()
        ready = self._line(Limits(START_S))
        return ready if isinstance(ready, _End) else None

    def _start(self) -> None:
        self.drop()
        self._lines = SimpleQueue()
        self._errors = tempfile.TemporaryFile("ab+")  # noqa: SIM115
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", WORKER, json.dumps(asdict(self.place)), str(os.getpid())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            encoding="utf-8",
            env=os.environ | dict.fromkeys(ONE_THREAD, "1"),
        )
        if self._closed:  # while we started it
            self._process.kill()
        threading.Thread(target=_relay, args=(self._process.stdout, self._lines), daemon=True).start()

    def _asked(self, trial: Trial) -> str | _End:
        """Send the row, wait for its answer."""
        assert self._process is not None
        assert self._process.stdin is not None
        assert self._errors is not None
        self._errors.truncate(0)
        try:
            self._process.stdin.write(json.dumps([trial.case.key, trial.seed]) + "\n")
            self._process.stdin.flush()
        except OSError:  # it died between two trials
            return self._ended("crash", 0.0)
        return self._line(self.limits)

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
                if (used := self._resident_mb()) > limits.memory_mb:
                    reason = f"{used:.0f} MB were resident; the limit is {limits.memory_mb:.0f}"
                    return self._ended("memory", taken, reason)
                continue
            return line if line else self._ended("crash", time.perf_counter() - began)

    def _resident_mb(self) -> float:
        import psutil

        assert self._process is not None
        try:
            return float(psutil.Process(self._process.pid).memory_info().rss) / 2**20
        except psutil.Error:
            return 0.0

    def _ended(self, ending: Ending, seconds: float, reason: str = "") -> _End:
        """The process is over: by our hand where there is a reason, else by its own or by somebody else's."""
        assert self._process is not None
        if reason:
            self._process.kill()
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
