"""When to stop: small rules, combined with | (any) and & (all)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sooner.errors import InvalidProblemError
from sooner.problem.incumbent import gap

__all__ = ["Progress", "StopRule", "gap_below", "max_seconds", "max_ticks", "never", "value_reached"]


@dataclass(frozen=True)
class Progress:
    """What a stop rule sees: seconds and ticks so far, best value and bound."""

    seconds: float
    ticks: int
    value: float
    bound: float


@dataclass(frozen=True)
class StopRule:
    """A question about progress, and, where the rule has a horizon, how much of it is used up.

    Parameters
    ----------
    met : Progress -> bool
    share : Progress -> float or None     in [0, 1]; None where nobody can tell how long it will take

    Examples
    --------
    >>> rule = max_seconds(10) | gap_below(0.01)
    >>> rule.met(Progress(seconds=3.0, ticks=7, value=0.995, bound=1.0))
    True
    >>> rule.share(Progress(seconds=3.0, ticks=7, value=0.5, bound=1.0))
    0.3
    """

    met: Callable[[Progress], bool]
    share: Callable[[Progress], float | None]

    def __or__(self, other: StopRule) -> StopRule:
        return StopRule(
            lambda p: self.met(p) or other.met(p),
            lambda p: max((s for s in (self.share(p), other.share(p)) if s is not None), default=None),
        )

    def __and__(self, other: StopRule) -> StopRule:
        def share(p: Progress) -> float | None:
            mine, theirs = self.share(p), other.share(p)
            return None if mine is None or theirs is None else min(mine, theirs)

        return StopRule(lambda p: self.met(p) and other.met(p), share)


def max_seconds(seconds: float) -> StopRule:
    """Stop when `seconds` of wall-clock time have gone."""
    if not seconds >= 0:
        raise InvalidProblemError(f"{seconds} s came; expected a number of at least 0")
    return StopRule(lambda p: p.seconds >= seconds, lambda p: min(p.seconds / seconds, 1.0) if seconds > 0 else 1.0)


def max_ticks(ticks: int) -> StopRule:
    """Stop after `ticks` yields of the planner: the same seed then gives the same plan on any machine."""
    if ticks < 1:
        raise InvalidProblemError(f"{ticks} ticks came; expected at least 1")
    return StopRule(lambda p: p.ticks >= ticks, lambda p: min(p.ticks / ticks, 1.0) if ticks > 0 else 1.0)


def gap_below(share: float) -> StopRule:
    """Stop when (bound - value) / |bound| is proved to be at most `share`; wrap the planner in `Proved` for a proof."""
    return StopRule(lambda p: gap(p.value, p.bound) <= share, lambda p: None)


def value_reached(value: float) -> StopRule:
    """Stop when the best plan is worth at least `value`."""
    return StopRule(lambda p: p.value >= value, lambda p: None)


def never() -> StopRule:
    """Go on until the planner has finished, or someone interrupts."""
    return StopRule(lambda p: False, lambda p: None)
