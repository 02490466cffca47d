"""The cluster: the same slots inside the workers of a Dask scheduler; the ledger stays with us.

Any Dask deployment will do (`dask scheduler` and `dask worker` by hand, a batch system through dask-jobqueue,
Kubernetes): sooner is installed on each machine, in the same version, with the same maps. What Dask loses (a worker,
the scheduler, the connection) costs the trials that were in the air there; they are flown again.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
import uuid
from contextlib import suppress
from dataclasses import replace
from queue import Empty, SimpleQueue
from typing import Any

from sooner.campaigns.slot import Slot
from sooner.campaigns.trial import Limits, Outcome, Place, Trial
from sooner.errors import DataFormatError, Fault, UnsupportedProblemError

__all__ = ["Cluster"]

PATIENCE_S = 120.0
COUNT_S = 1.0  # between two looks at how many workers there are


class Cluster:
    """A crew on other machines, as many as the scheduler has.

    Parameters
    ----------
    address : str         of the scheduler, as tcp://10.0.0.1:8786
    place : Place         the worker looks there for the maps, or else where its own SOONER_DATA says
    limits : Limits       of each trial; its memory is a share of what the worker may have
    patience_s : float    how long to wait for a scheduler that is gone before giving up
    """

    def __init__(self, address: str, place: Place, limits: Limits, patience_s: float = PATIENCE_S) -> None:
        self.address, self.place, self.limits, self.patience_s = address, place, limits, patience_s
        self.campaign = uuid.uuid4().hex
        self._client: Any = None
        self._in_air: dict[str, tuple[Trial, Any]] = {}
        self._ended: SimpleQueue[str] = SimpleQueue()
        self._numbers = itertools.count()
        self._counted_at, self._threads = -math.inf, 1

    @property
    def workers(self) -> int:
        """Threads of the cluster, each with a slot."""
        if self._client is not None and time.monotonic() - self._counted_at > COUNT_S:
            self._counted_at = time.monotonic()
            with suppress(OSError, RuntimeError):
                workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
                self._threads = max(sum(worker["nthreads"] for worker in workers), 1)
        return self._threads

    @property
    def places(self) -> int:
        """One in each slot, and as many that wait for a free one."""
        return 2 * self.workers

    def start(self, trial: Trial) -> None:
        """Send it; Dask chooses where it flies."""
        key = f"sooner-{self.campaign}-{next(self._numbers)}"
        future = self._connected().submit(
            _flown, self.campaign, trial, self.place, self.limits, key=key, pure=False, retries=0
        )
        self._in_air[key] = trial, future
        future.add_done_callback(lambda done: self._ended.put(done.key))

    def ended(self, wait_s: float) -> list[Outcome]:
        """What has come to its end, after waiting so long at most for the first."""
        found = []
        try:
            found.append(self._outcome(self._ended.get(timeout=wait_s)))
            while True:
                found.append(self._outcome(self._ended.get_nowait()))
        except Empty:
            return found

    def close(self) -> None:
        """Let go of the cluster; processes that fly for us there are ended."""
        if self._client is None:
            return
        with suppress(Exception):  # whatever is gone already need not be told
            if self._client.status == "running":
                self._client.cancel([future for _, future in self._in_air.values()])
                self._client.run(_land, self.campaign, on_error="ignore")
        with suppress(Exception):
            self._client.close(timeout=5)
        self._client = None

    def _outcome(self, key: str) -> Outcome:
        trial, future = self._in_air.pop(key)
        try:
            if future.status == "finished":
                outcome: Outcome = future.result(timeout=self.patience_s)
                return outcome
            if future.status == "error":
                return _failed(trial, future.exception(timeout=self.patience_s))
        except Exception as error:  # the connection went away before the answer came over it
            return Outcome(trial, "lost", reason=str(error))
        return Outcome(trial, "lost", reason=f"the cluster lost it ({future.status})")

    def _connected(self) -> Any:
        """A client of the scheduler; where that is gone, wait for it to come back."""
        if self._client is not None and self._client.status in ("running", "connecting"):
            return self._client
        self._client = _client(self.address, self.patience_s)
        self._counted_at = -math.inf
        return self._client


def _client(address: str, patience_s: float) -> Any:
    try:
        from distributed import Client as connect
    except ImportError:
        raise UnsupportedProblemError("a cluster needs Dask: pip install 'sooner[cluster]'") from None
    try:
        return connect(address, timeout=patience_s, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        came = f"{address!r} came, and no scheduler of Dask answers there ({type(error).__name__})"
        expected = "expected an address as tcp://10.0.0.1:8786; what was recorded is kept, the same command goes on"
        raise DataFormatError(Fault("--scheduler", "", came, expected)) from None


def _failed(trial: Trial, error: BaseException | None) -> Outcome:
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):  # machine after machine went away under it
        return Outcome(trial, "killed", reason=str(error))
    return Outcome(trial, "error", reason=f"{type(error).__name__}: {error}")


# What runs in the workers of Dask -------------------------------------------------------------------------------------

_slots: dict[tuple[str, int], Slot] = {}  # by campaign and thread


def _flown(campaign: str, trial: Trial, place: Place, limits: Limits) -> Outcome:
    """Fly in this thread's slot."""
    mine = campaign, threading.get_ident()
    if mine not in _slots:
        _slots[mine] = Slot(place, replace(limits, memory_mb=min(limits.memory_mb, _share_mb())))
    return _slots[mine].run(trial)


def _share_mb() -> float:
    """What one thread of this worker may have of the memory that Dask gives to the worker."""
    from distributed import get_worker

    worker = get_worker()
    limit = worker.memory_manager.memory_limit
    return float(limit) / 2**20 / worker.state.nthreads if limit else math.inf


def _land(campaign: str) -> None:
    """The campaign is over: end its processes."""
    for key in [key for key in _slots if key[0] == campaign]:
        _slots.pop(key).close()
