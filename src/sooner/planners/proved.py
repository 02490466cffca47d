"""Proved: any planner with a proof running beside it, so that every plan comes with a value that none can exceed."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf

from numpy.random import Generator

from sooner.bounds import Bound, bounds
from sooner.planners.planner import Planner, Ticks, follow
from sooner.problem import Incumbent, SearchProblem

__all__ = ["Proved"]

Prover = Callable[[SearchProblem, Callable[[], float]], Iterator[Bound]]


@dataclass(frozen=True)
class Proved:
    """Run `inner` on this thread and `prover` on another; yield the best plan with the tightest bound so far.

    The proof never changes the plan: it is told the value of the best one, and tells back what none can exceed. On
    two processors it waits after its first bound, so that the planner has both of them while it looks for the right
    hills; a good plan also makes the proof quicker. When the planner has finished, the proof may go on for `linger`
    seconds, or until the stop rule says so.

    Parameters
    ----------
    inner : Planner
    prover : callable        (problem, best value so far) to bounds, each no larger than the last
    linger : float           seconds
    waits : float            share of the run after which the proof goes on from its first bound
    """

    inner: Planner
    prover: Prover = bounds
    linger: float = 2.0
    waits: float = 0.6 if (os.cpu_count() or 1) <= 2 else 0.0

    def handles(self, problem: SearchProblem) -> str | None:
        """What the inner planner handles."""
        return self.inner.handles(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield at every tick of the inner planner, then ten times a second while the proof lingers."""
        proof = _Proof(problem, self.prover)
        best: Incumbent | None = None
        share: float | None = 0.0
        try:
            advance = follow(self.inner.plans(problem, rng))
            while (incumbent := advance(share)) is not None:
                best = incumbent
                proof.value = best.value
                share = yield proof.attached(best)
                if share is None or share >= self.waits:
                    proof.go_on()
            proof.go_on()
            until = time.monotonic() + self.linger
            while best is not None and proof.running and time.monotonic() < until:
                proof.wait(0.1)
                yield proof.attached(best)
            if best is not None:
                yield proof.attached(best)
        finally:
            proof.stop()


class _Proof:
    """A thread that tightens a bound until it is told to stop."""

    def __init__(self, problem: SearchProblem, prover: Prover) -> None:
        self.value = -inf
        self.bound: Bound | None = None
        self._stopped, self._going_on = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, args=(problem, prover), name="proof", daemon=True)
        self._error: BaseException | None = None
        self._thread.start()

    @property
    def running(self) -> bool:
        return self._thread.is_alive()

    def wait(self, seconds: float) -> None:
        self._thread.join(seconds)

    def go_on(self) -> None:
        """Let it go on after its first bound."""
        self._going_on.set()

    def stop(self) -> None:
        """Ask it to stop, and wait for the end of its present step."""
        self._stopped.set()
        self._going_on.set()
        self._thread.join()

    def attached(self, incumbent: Incumbent) -> Incumbent:
        """The incumbent with the tightest bound there is; a proof that broke is our fault, and says so."""
        if self._error is not None:
            raise self._error
        found = self.bound
        if found is None or found.value >= incumbent.bound:
            return incumbent
        return replace(incumbent, bound=found.value, bound_proof=found.proof, bound_assumes=found.assumes)

    def _run(self, problem: SearchProblem, prover: Prover) -> None:
        try:
            for found in prover(problem, lambda: self.value):
                if self.bound is None or found.value < self.bound.value:
                    self.bound = found
                self._going_on.wait()
                if self._stopped.is_set():
                    return
        except BaseException as error:  # carried over to the planner's thread
            self._error = error
