"""Expanding square and sector searches as planners [IAMSAR2019, vol. III, pp. 12-10 and 12-11]."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from sooner.decomposition.patterns import Tracks, expanding_square, sector_search
from sooner.planners.leg_ground import leg_searchers
from sooner.planners.patterns.best_of import best_of
from sooner.planners.patterns.checked import check_datum, check_positive
from sooner.planners.patterns.searched import Searched
from sooner.planners.patterns.spaced import Spaced
from sooner.planners.planner import Ticks
from sooner.problem import SearchProblem

__all__ = ["ExpandingSquare", "Sector"]

_RADII = (1.0, 1.5, 2.0, 3.0, 5.0)  # track spacings at the rim, where legs lie one radius apart


@dataclass(frozen=True)
class ExpandingSquare(Spaced):
    """Outwards in squares from the datum; the first leg in any of eight directions, the judge chooses.

    Parameters
    ----------
    datum : (float, float) or None   metres in the frame of `Grid.centres_m`; None: where the POC peaks, or
                                     the square that all sorties can cover holds most of it
    """

    datum: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_datum(self.datum)

    def drawn(self, searched: Searched) -> Iterator[Tracks]:
        """About every datum, at every spacing, in every direction."""
        for spacing in searched.spacings(self.spacing_m, self.overlap):
            for datum in searched.datums(spacing) if self.datum is None else [self.datum]:
                for eighth in range(8):
                    yield expanding_square(searched.free, datum, spacing, eighth * np.pi / 4)


@dataclass(frozen=True)
class Sector:
    """Triangles that meet in the datum, two passes of them; of several radii and directions the judge chooses.

    Parameters
    ----------
    datum : (float, float) or None   metres in the frame of `Grid.centres_m`; None: where the POC peaks, or
                                     the square that all sorties can cover holds most of it
    radius_m : float or None         of the pattern; None: of several the best
    """

    datum: tuple[float, float] | None = None
    radius_m: float | None = None

    def __post_init__(self) -> None:
        check_datum(self.datum)
        check_positive("radius_m", self.radius_m)

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs, any number of them."""
        return leg_searchers(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the best after every radius and direction."""
        return best_of(problem, self._drawn)

    def _drawn(self, searched: Searched) -> Iterator[Tracks]:
        spacing = searched.spacings(None, 0.0)[0]
        longest = [searched.flown_m() / (9 * passes) for passes in (1, 2)]
        radii = sorted({min(spacing * times, longest[0]) for times in _RADII} | set(longest))
        for radius in radii if self.radius_m is None else [self.radius_m]:
            for datum in searched.datums(spacing) if self.datum is None else [self.datum]:
                for turn in range(4):
                    yield sector_search(searched.free, datum, radius, turn * np.pi / 6, passes=2)
