"""What patterns along tracks have in common: how far apart these lie, and that the judge chooses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

from numpy.random import Generator

from sooner.decomposition.patterns import Tracks
from sooner.planners.leg_ground import leg_searchers
from sooner.planners.patterns.best_of import best_of
from sooner.planners.patterns.checked import check_overlap, check_positive
from sooner.planners.patterns.searched import Searched
from sooner.planners.planner import Ticks
from sooner.problem import SearchProblem

__all__ = ["Spaced"]


@dataclass(frozen=True)
class Spaced(ABC):
    """A pattern of tracks some spacing apart, drawn in the few ways that its definition leaves open.

    Parameters
    ----------
    spacing_m : float or None   between tracks; None: the swath's width less the overlap, or by sweep width
    overlap : float             share of the swath that neighbours see both
    """

    spacing_m: float | None = None
    overlap: float = 0.0

    def __post_init__(self) -> None:
        check_positive("spacing_m", self.spacing_m)
        check_overlap(self.overlap)

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs, any number of them."""
        return leg_searchers(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the best after every way in which the pattern is drawn."""
        return best_of(problem, self.drawn)

    @abstractmethod
    def drawn(self, searched: Searched) -> Iterator[Tracks]:
        """The pattern over ground that hangs together, in one way after another."""
