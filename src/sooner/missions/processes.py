"""The same work for many seeds, in one process or in several; what comes of a seed does not depend on which."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from sooner.errors import DataFormatError, Fault

__all__ = ["for_each_seed"]

T = TypeVar("T")
DEAD_WITH_PARENT = 1  # PR_SET_PDEATHSIG

_work: Callable[[int], Any]


def for_each_seed(work: Callable[[int], T], seeds: range, workers: int = 1) -> Iterator[T]:
    """What the work makes of each seed, in the order of seeds.

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
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin, (work, os.getpid()))
    try:
        yield from pool.map(_do, seeds, chunksize=max(1, min(16, len(seeds) // (4 * workers))))
        pool.shutdown()
    except BrokenProcessPool:
        expected = "expected memory for all of them: ask for fewer"
        raise DataFormatError(Fault("--workers", "", "a process was ended from outside", expected)) from None
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in set(multiprocessing.active_children()) - others:  # interrupted: nobody waits for their answers
            process.terminate()


def _begin(work: Callable[[int], Any], parent: int) -> None:
    global _work
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asked
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEAD_WITH_PARENT, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
    _work = work


def _do(seed: int) -> Any:
    return _work(seed)
