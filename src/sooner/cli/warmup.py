"""`sooner warmup`."""

from __future__ import annotations

import time

from sooner.cli.exits import DONE, say
from sooner.missions.warmup import warm_up

__all__ = ["warmup"]


def warmup(quiet: bool) -> int:
    """Compile everything."""
    began = time.perf_counter()
    for name in warm_up():
        if not quiet:
            say(f"{time.perf_counter() - began:6.1f} s  {name}")
    print(f"compiled in {time.perf_counter() - began:.1f} s")
    return DONE
