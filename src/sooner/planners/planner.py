"""What a planner is: settings that turn a problem into better and better plans."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from itertools import count
from typing import Protocol

from numpy.random import Generator as Random

from sooner.errors import UnsupportedProblemError
from sooner.problem import CellMoves, Incumbent, SearchProblem

__all__ = ["Part", "Planner", "Ticks", "follow", "refuse_unhandled", "single_cell_searcher"]

Ticks = Generator[Incumbent, float | None, None]
"""Yields incumbents; is sent the share of the run that is used up, in [0, 1], or None where nobody knows."""


class Planner(Protocol):
    """A frozen dataclass whose fields are its settings, with the paper's values as defaults."""

    def handles(self, problem: SearchProblem) -> str | None:
        """Why it cannot plan for this problem, in a sentence; None if it can."""

    def plans(self, problem: SearchProblem, rng: Random) -> Iterator[Incumbent]:
        """Yield the best plan so far, often. Values never fall, bounds never rise.

        A `yield` may take the share of the run that is used up: `share = yield incumbent` (see `Ticks`).
        """


def single_cell_searcher(problem: SearchProblem) -> str | None:
    """What most planners handle: one searcher that moves over cells, and a person who stays; None if it is so."""
    if len(problem.searchers) != 1:
        return f"it plans for one searcher; this problem has {len(problem.searchers)}"
    if not isinstance(problem.searcher.moves, CellMoves):
        return "it plans moves over cells"
    if problem.drift is not None:
        return "it plans for a person who stays; wrap it in Receding for one who drifts"
    if problem.objective.target is not None:
        return "it plans for the most by the end; wrap it in Soonest to reach a target early"
    return None


def refuse_unhandled(problem: SearchProblem, planner: Planner) -> None:
    """Raise UnsupportedProblemError, with the planner's own sentence, where it does not handle the problem."""
    why = planner.handles(problem)
    if why is not None:
        raise UnsupportedProblemError(f"{type(planner).__name__} cannot plan this: {why}")


def follow(ticks: Iterator[Incumbent]) -> Callable[[float | None], Incumbent | None]:
    """A function that takes the share used up and returns the next incumbent, or None at the end.

    Plain iterators, which cannot be sent anything, are followed as well.
    """
    started = False

    def advance(share: float | None) -> Incumbent | None:
        nonlocal started
        try:
            if started and isinstance(ticks, Generator):
                sent: Incumbent = ticks.send(share)
                return sent
            started = True
            return next(ticks)
        except StopIteration:
            return None

    return advance


@dataclass(frozen=True)
class Part:
    """The part of a run that one inner planner has: up to a share of the whole, or some ticks where nobody knows.

    Parameters
    ----------
    begin, until : float      shares of the whole run
    ticks : int               how many ticks, where no shares are sent
    """

    begin: float
    until: float
    ticks: int

    def run(
        self,
        planner: Planner,
        problem: SearchProblem,
        rng: Random,
        share: float | None,
        take: Callable[[Incumbent], Incumbent],
        enough: Callable[[], bool] = lambda: False,
    ) -> Generator[Incumbent, float | None, tuple[float | None, bool]]:
        """Yield `take(incumbent)` for each tick of the inner planner while the part lasts and it is not `enough`.

        Returns the last share that was sent, and whether the inner planner came to its own end.
        """
        advance = follow(planner.plans(problem, rng))
        for tick in count(1):
            incumbent = advance(self._used(share))
            if incumbent is None:
                return share, True
            share = yield take(incumbent)
            if enough() or (tick >= self.ticks if share is None else share >= self.until):
                break
        return share, False

    def _used(self, share: float | None) -> float | None:
        if share is None:
            return None
        return min(max((share - self.begin) / max(self.until - self.begin, 1e-12), 0.0), 1.0)
