"""The cluster: the same slots inside the workers of a Dask scheduler; the ledger stays with us.

Any Dask deployment will do (`dask scheduler` and `dask worker` by hand, a batch system through dask-jobqueue,
Kubernetes): sooner is installed on each machine, in the same version, with the same maps. What Dask loses (a worker,
the scheduler, the connection) costs the trials that were in the air there; they are flown again.
"""

from __future__ import annotations

import asyncio
import itertools
import logging
import threading
import uuid
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

from sooner.campaigns import seats
from sooner.campaigns.trial import Limits, Outcome, Place, Trial
from sooner.errors import DataFormatError, Fault, UnsupportedProblemError

__all__ = ["Cluster"]

T = TypeVar("T")

PATIENCE_S = 30.0  # for a scheduler that was never there
PATIENCE_AGAIN_S = 300.0  # for one that was
COUNT_S = 1.0  # between two looks at how many workers there are
LAND_S = 5.0  # for each step of a farewell
NOISY = ("distributed", "distributed.client", "distributed.gc", "tornado", "tornado.application", "asyncio")
FLOWN, LAND = seats.carrier("flown"), seats.carrier("land")


class Cluster:
    """A crew on other machines, as many as the scheduler has.

    Parameters
    ----------
    address : str         of the scheduler, as tcp://10.0.0.1:8786
    place : Place         the worker looks there for the maps, or else where its own SOONER_DATA says
    limits : Limits       of each trial; its memory is a share of what the worker may have
    patience_s : float    how long to wait for the scheduler at first
    again_s : float       how long to wait for a scheduler that was there and is gone
    """

    def __init__(
        self,
        address: str,
        place: Place,
        limits: Limits,
        patience_s: float = PATIENCE_S,
        again_s: float = PATIENCE_AGAIN_S,
    ) -> None:
        self.address, self.place, self.limits = address, place, limits
        self.campaign = uuid.uuid4().hex
        self._patience_s, self._again_s = patience_s, again_s
        self._link: _Link | None = None
        self._ended: SimpleQueue[Outcome | DataFormatError] = SimpleQueue()
        self._numbers = itertools.count()
        self._threads = 1

    @property
    def workers(self) -> int:
        """Threads of the cluster, each with a slot; one while there is none, so that a trial waits there for it."""
        if self._link is not None:
            self._threads = max(self._link.threads, 1)
        return self._threads

    @property
    def room(self) -> int:
        """One in each slot, and as many that wait for a free one."""
        return 2 * self.workers

    def start(self, trial: Trial) -> None:
        """Send it; Dask chooses where it flies.

        Raises
        ------
        DataFormatError             no scheduler answers at the address
        UnsupportedProblemError     Dask is not installed
        """
        if self._link is None or not self._link.alive:
            self._connect()
        assert self._link is not None
        self._link.begin(self._fly(self._link.client, trial))

    def ended(self, wait_s: float) -> list[Outcome]:
        """What has come to its end, after waiting so long at most for the first.

        Raises
        ------
        DataFormatError             a worker cannot fly for us at all
        """
        found = []
        try:
            found.append(_checked(self._ended.get(timeout=wait_s)))
            while True:
                found.append(_checked(self._ended.get_nowait()))
        except Empty:
            return found

    def close(self) -> None:
        """Let go of the cluster; processes that fly for us there are ended."""
        if (link := self._link) is not None:
            self._threads, self._link = self.workers, None
            link.close(self.campaign)

    def _connect(self) -> None:
        """Find the scheduler; where it was and is gone, wait until it is there again."""
        patience_s = self._patience_s if self._link is None else self._again_s
        self.close()
        self._link = _Link(self.address, patience_s)

    async def _fly(self, client: Any, trial: Trial) -> None:
        """Send a trial and wait for what comes of it."""
        key = f"sooner-{self.campaign}-{next(self._numbers)}"
        future = None
        try:
            text = seats.asked(self.campaign, trial, self.place, self.limits)
            future = client.submit(FLOWN, text, key=key, pure=False, retries=0)
            self._ended.put(seats.told(trial, await future))
        except (Exception, asyncio.CancelledError) as error:
            failed = future is not None and future.status == "error"
            self._ended.put(_failed(trial, error) if failed else Outcome(trial, "lost", reason=str(error)))


def _checked(ended: Outcome | DataFormatError) -> Outcome:
    if isinstance(ended, DataFormatError):
        raise ended
    return ended


def _failed(trial: Trial, error: BaseException) -> Outcome | DataFormatError:
    """What Dask says where no answer came; a trial that fails does answer."""
    from distributed import KilledWorker
    from distributed.scheduler import NoValidWorkerError

    reason = f"{type(error).__name__}: {error}"
    if isinstance(error, KilledWorker):  # machine after machine went away under it
        return Outcome(trial, "killed", reason=reason)
    if isinstance(error, NoValidWorkerError):
        return Outcome(trial, "lost", reason=reason)
    if isinstance(error, (ImportError, OSError)):
        came = f"a worker cannot fly for us ({reason})"
        expected = "expected sooner, in this version, and the folder of the study wherever a worker of Dask runs"
        return DataFormatError(Fault("--scheduler", "", came, expected))
    return Outcome(trial, "error", reason=reason)


class _Link:
    """A client of Dask in a thread of its own: whatever happens there, the campaign never waits for it.

    Parameters
    ----------
    address : str
    patience_s : float
    """

    def __init__(self, address: str, patience_s: float) -> None:
        self.client: Any = None
        self.threads = 0
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(lambda loop, context: None)
        self._thread = threading.Thread(target=self._live, name="sooner-cluster", daemon=True)
        self._tasks: set[asyncio.Task[None]] = set()
        _import()
        self._thread.start()
        try:
            self._wait(self._open(address, patience_s), patience_s + 2 * LAND_S)
        except BaseException as error:
            self.close("")
            if not isinstance(error, Exception):
                raise
            why = _first_line(error) or f"nothing came within {patience_s:g} s"
            came = f"{address!r} came, and no scheduler of Dask answers there ({why})"
            expected = "expected an address as tcp://10.0.0.1:8786; what was recorded is kept, the same command goes on"
            raise DataFormatError(Fault("--scheduler", "", came, expected)) from None

    @property
    def alive(self) -> bool:
        """Connected, or about to be again."""
        return self.client is not None and self.client.status in ("running", "connecting")

    def begin(self, coroutine: Coroutine[Any, Any, None]) -> None:
        """Run it there, and wait for nothing."""
        self._loop.call_soon_threadsafe(self._begin, coroutine)

    def close(self, campaign: str) -> None:
        """Tell the workers that the campaign is over, and go."""
        with suppress(Exception):  # whatever is gone already need not be told
            self._wait(self._leave(campaign), 4 * LAND_S)
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(LAND_S)

    def _wait(self, coroutine: Coroutine[Any, Any, T], seconds: float) -> T:
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(seconds)

    def _live(self) -> None:
        asyncio.set_event_loop(self._loop)
        with _quiet():
            self._loop.run_forever()
        self._loop.close()

    def _begin(self, coroutine: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _open(self, address: str, patience_s: float) -> None:
        from distributed import Client

        self.client = Client(  # type: ignore[no-untyped-call]
            address, timeout=patience_s, asynchronous=True, set_as_default=False
        )
        await asyncio.wait_for(self.client, patience_s + LAND_S)  # Dask, which knows more, speaks first
        self._begin(self._count())

    async def _count(self) -> None:
        """Keep looking how many threads there are."""
        while True:
            with suppress(Exception):  # while there is no scheduler, it is what it was
                self.threads = sum((await self.client.nthreads()).values())
            await asyncio.sleep(COUNT_S)

    async def _leave(self, campaign: str) -> None:
        for task in [*self._tasks]:
            task.cancel()
        if self.client is None:
            return
        if self.client.status == "running":
            with suppress(Exception):
                await asyncio.wait_for(self.client.run(LAND, campaign, on_error="ignore"), LAND_S)
        with suppress(Exception):
            await asyncio.wait_for(self.client.close(), LAND_S)


def _first_line(error: BaseException) -> str:
    """What it says, and what is behind it."""
    said = [str(each) for each in (error, error.__cause__) if each is not None and str(each)]
    return ": ".join(text.splitlines()[0].rpartition(">: ")[2] for text in said)


def _import() -> None:
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise UnsupportedProblemError("a cluster needs Dask: pip install 'sooner[cluster]'") from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep from the terminal what Dask logs in this thread, unless its configuration says what to log."""
    import dask

    asked = dask.config.get("logging", None) or dask.config.get("distributed.logging", None)
    mine = threading.get_ident()

    def others(record: logging.LogRecord) -> bool:
        return record.thread != mine

    handlers = [] if asked else [handler for name in NOISY for handler in logging.getLogger(name).handlers]
    for handler in handlers:
        handler.addFilter(others)
    try:
        yield
    finally:
        for handler in handlers:
            handler.removeFilter(others)
