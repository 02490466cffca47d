"""The embedded pool: a few slots on this machine."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Mapping
from queue import Empty, SimpleQueue
from typing import Any

from sooner.campaigns.slot import Slot
from sooner.campaigns.trial import Limits, Outcome, Place, Trial
from sooner.errors import DataFormatError, Fault

__all__ = ["Pool", "cores", "share_of_memory_mb"]


class Pool:
    """So many processes, each of which flies one trial at a time.

    Parameters
    ----------
    workers : int
    place : Place
    limits : Limits       of each trial
    """

    def __init__(self, workers: int, place: Place, limits: Limits) -> None:
        self.workers = workers
        self._asked: SimpleQueue[Trial | None] = SimpleQueue()
        self._ended: SimpleQueue[Outcome | OSError] = SimpleQueue()
        self._slots = [Slot(place, limits) for _ in range(workers)]
        self._threads = [threading.Thread(target=self._serve, args=(slot,), daemon=True) for slot in self._slots]
        self._closed = False
        for thread in self._threads:
            thread.start()

    @property
    def room(self) -> int:
        """One in each process, and as many that wait for a free one."""
        return 2 * self.workers

    def rehearse(self, planners: Mapping[str, Any]) -> dict[str, str]:
        """Before the first trial: what cannot be loaded or made, and why; as in `Slot`.

        Raises
        ------
        DataFormatError       this machine starts no processes
        """
        try:
            return self._slots[0].rehearse(planners)
        except OSError as error:
            raise _no_process(error) from None

    def start(self, trial: Trial) -> None:
        """Fly it as soon as a process is free."""
        self._asked.put(trial)

    def ended(self, wait_s: float) -> list[Outcome]:
        """What has come to its end, after waiting so long at most for the first.

        Raises
        ------
        DataFormatError       this machine starts no processes: too many, no memory, no room for their messages
        """
        found: list[Outcome] = []
        try:
            while True:
                outcome = self._ended.get(timeout=0.0 if found else wait_s)
                if isinstance(outcome, OSError):
                    raise _no_process(outcome)
                found.append(outcome)
        except Empty:
            return found

    def close(self) -> None:
        """End every process at once."""
        self._closed = True
        for slot in self._slots:
            self._asked.put(None)
            slot.close()
        for thread in self._threads:
            thread.join(timeout=10.0)

    def _serve(self, slot: Slot) -> None:
        while not self._closed and (trial := self._asked.get()) is not None:
            try:
                self._ended.put(slot.run(trial))
            except OSError as error:
                self._ended.put(error)
        slot.drop()


def _no_process(error: OSError) -> DataFormatError:
    expected = "mend that and give the same command again; every trial that was recorded is kept"
    return DataFormatError(Fault(sys.executable, "", f"no process can be started ({error})", expected))


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share_of_memory_mb(workers: int) -> float:
    """What each of so many processes may have, so that together they leave the machine a tenth of its memory."""
    import psutil

    return 0.9 * float(psutil.virtual_memory().total) / 2**20 / workers
