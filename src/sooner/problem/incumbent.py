"""Incumbent: the best plan so far, and what is proved about the rest."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite

from sooner.problem.plan import Plan

__all__ = ["Incumbent", "gap"]


@dataclass(frozen=True)
class Incumbent:
    """One tick of a planner: its best plan, that plan's value, and a value that no plan can exceed.

    Parameters
    ----------
    plan : Plan
    value : float            exactly as `evaluate` gives it
    bound : float            inf while nothing is proved
    bound_proof : str        the name of the proof, "" while nothing is proved
    bound_assumes : str      what the proof takes for granted
    """

    plan: Plan
    value: float
    bound: float = inf
    bound_proof: str = ""
    bound_assumes: str = ""

    @property
    def gap(self) -> float:
        """(bound - value) / |bound|; inf while nothing is proved."""
        return gap(self.value, self.bound)


def gap(value: float, bound: float) -> float:
    """Share of the bound that the value may still miss; 0 means proved, inf that nothing is known.

    >>> gap(0.9, 1.0)
    0.09999999999999998
    """
    if not (isfinite(value) and isfinite(bound)):
        return inf
    if bound <= value:
        return 0.0
    return (bound - value) / abs(bound) if bound else inf
