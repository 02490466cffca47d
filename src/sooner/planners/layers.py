"""Layers of the hierarchy: the same planner on mixtures of different size, side by side [Lin2014, section IV-C]."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from numpy.random import Generator

__all__ = ["in_parallel"]

Layer = TypeVar("Layer")
Found = TypeVar("Found")


def in_parallel(
    work: Callable[[Layer, Generator], Found], layers: Sequence[Layer], rng: Generator, threads: int
) -> Iterator[Found]:
    """What `work` finds for each layer, in order; each has its own stream, so threads change nothing but the time.

    `threads` = 0 stands for as many as there are processors.
    """
    streams = rng.spawn(len(layers))
    threads = threads or os.cpu_count() or 1
    if threads <= 1:
        yield from map(work, layers, streams)
        return
    pool = ThreadPoolExecutor(threads)
    try:
        for job in [pool.submit(work, layer, stream) for layer, stream in zip(layers, streams, strict=True)]:
            yield job.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
