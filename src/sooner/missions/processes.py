"""The same work for many seeds, in one process or in several; what comes of a seed does not depend on which."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any, TypeVar

from sooner.errors import DataFormatError, Fault

__all__ = ["for_each_seed"]

T = TypeVar("T")
DEAD_WITH_PARENT = 1  # PR_SET_PDEATHSIG
CHUNK_S = 0.1  # of work sent to a process at once: what an interruption may lose
MOST = 16  # seeds sent at once; what comes of them fits into one write to a pipe, so that an end never cuts it
AHEAD = 3  # chunks for each process that are under way

_work: Callable[[int], Any]


def for_each_seed(work: Callable[[int], T], seeds: range, workers: int = 1) -> Iterator[T]:
    """What the work makes of each seed, in the order of seeds.

    Where Ctrl-C comes while it waits for other processes, what these have made comes still, then KeyboardInterrupt.

    Parameters
    ----------
    work : callable        from a seed; for several workers it must be possible to send it to another process
    seeds : range
    workers : int          processes that work at once, at least 1

    Raises
    ------
    DataFormatError        where a process was ended from outside, as where memory runs out

    Examples
    --------
    >>> list(for_each_seed(abs, range(-2, 1)))
    [2, 1, 0]
    """
    workers = min(workers, len(seeds))
    if workers <= 1:
        yield from map(work, seeds)
        return
    if sys.platform != "win32":
        resource_tracker.ensure_running()  # where it begins only with the first process, it lets signals through
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin, (work, os.getpid()))
    try:
        yield from _in_order(pool, seeds, workers)
    except BrokenProcessPool:
        expected = "expected memory for all of them: ask for fewer"
        raise DataFormatError(Fault("--workers", "", "a process was ended from outside", expected)) from None
    else:
        pool.shutdown()
    finally:
        # Nobody waits for what is under way. It is not cancelled: the pool's own thread would fail on that.
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        pool.shutdown()


def _in_order(pool: ProcessPoolExecutor, seeds: range, workers: int) -> Iterator[Any]:
    """What comes of the seeds, of which as many are sent at once as take about `CHUNK_S`."""
    ahead: deque[Future[tuple[float, list[Any]]]] = deque()
    sent, size = 0, 1
    try:
        while ahead or sent < len(seeds):
            with _deaf():  # sending begins processes, as long as there are fewer than may be
                while sent < len(seeds) and len(ahead) < AHEAD * workers:
                    ahead.append(pool.submit(_do, seeds[sent : sent + size]))
                    sent += size
            seconds, made = ahead[0].result()
            ahead.popleft()
            yield from made
            size = max(1, min(MOST, 2 * size, int(CHUNK_S * len(made) / max(seconds, 1e-9))))
    except KeyboardInterrupt:
        for chunk in ahead:
            if chunk.done() and chunk.exception() is None:
                yield from chunk.result()[1]
        raise


@contextmanager
def _deaf() -> Iterator[None]:
    """Let signals wait; processes that begin meanwhile never hear them.

    Another thread may still be handed one, of which Python tells the main thread: that, too, is told later. A process
    whose beginning is interrupted half way has nothing to begin with, and says so.
    """
    if sys.platform == "win32":
        yield
        return
    ends, heard = (signal.SIGINT, signal.SIGTERM), []
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ends)
    main = threading.current_thread() is threading.main_thread()
    handlers = {number: signal.signal(number, lambda told, _: heard.append(told)) for number in ends if main}
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    if heard:
        signal.raise_signal(heard[0])


def _begin(work: Callable[[int], Any], parent: int) -> None:
    global _work
    for number in (signal.SIGINT, signal.SIGTERM):  # an end is for the process that asked, and it ends the others
        signal.signal(number, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEAD_WITH_PARENT, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
    _work = work


def _do(seeds: range) -> tuple[float, list[Any]]:
    """Seconds it took, and what came of each seed."""
    begun = time.perf_counter()
    made = [_work(seed) for seed in seeds]
    return time.perf_counter() - begun, made
