"""How planning grows with the map: time to the first plan and bound, cost per iteration, peak memory.

    python benchmarks/speed/growth.py [--seconds S] [SIZE:STEPS ...]

Each size runs in a process of its own, so that peak memory is its own. Kernels are warmed on a small map first.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time

from sooner.bounds import bounds
from sooner.planners import max_seconds, solve
from sooner.planners.registry import make_planner
from sooner.scenarios import many_hills


def measure(size: int, steps: int, seconds: float) -> None:
    """One row: a map of size x size cells, a flight of `steps`, `seconds` for the planner and as many for the bound."""
    warm = many_hills(1, 40).problem(60)
    solve(warm, make_planner("anneal"), max_seconds(0.5))
    for _ in zip(range(3), bounds(warm, lambda: 0.0), strict=False):
        pass
    problem = many_hills(0, size).problem(steps)
    began = time.perf_counter()
    reference = problem.teleport.value
    ready = time.perf_counter() - began
    solution = solve(problem, make_planner("anneal"), max_seconds(seconds))
    first, last = solution.trace[0], solution.trace[-1]
    each = 1e3 * (last.seconds - first.seconds) / max(last.ticks - first.ticks, 1)
    print(f"{size:5d} {steps:6d}  teleport {ready:6.2f} s", end="  ")
    print(f"first plan {first.seconds:6.2f} s {100 * first.value / reference:6.2f} %", end="  ")
    print(
        f"after {last.seconds:6.1f} s {100 * last.value / reference:6.2f} %  {each:7.1f} ms a tick",
        end="  ",
        flush=True,
    )
    began, marks = time.perf_counter(), []
    for found in bounds(problem, lambda: last.value):
        marks.append((time.perf_counter() - began, 100 * found.value / reference))
        if marks[-1][0] > seconds:
            break
    better = next((m for m in marks if m[1] < 99.999), marks[-1])
    print(f"bound {better[1]:6.2f} % at {better[0]:5.1f} s, {marks[-1][1]:6.2f} % at {marks[-1][0]:5.1f} s", end="  ")
    print(f"peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:6.0f} MB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", nargs="*", default=["100:900", "300:3000", "1000:10000"])
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--here", action="store_true", help="measure in this process")
    given = parser.parse_args()
    for size in given.sizes:
        if given.here:
            cells, steps = size.split(":")
            measure(int(cells), int(steps), given.seconds)
        else:
            subprocess.run([sys.executable, __file__, "--here", "--seconds", str(given.seconds), size], check=True)


if __name__ == "__main__":
    main()
