"""Bound: a value that no plan can pass, with the name of its proof."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Bound", "Known", "known_value"]

Known = Callable[[], float] | float  # value of the best plan so far, asked again whenever it may have risen


@dataclass(frozen=True)
class Bound:
    """A proven upper bound on the value of every plan.

    Parameters
    ----------
    value : float
    proof : str               short name of the argument
    assumes : str             what the argument takes for granted, in one sentence
    """

    value: float
    proof: str
    assumes: str


def known_value(known: Known) -> float:
    """The best value known at this moment; minus infinity where nothing is."""
    return float(known() if callable(known) else known)
