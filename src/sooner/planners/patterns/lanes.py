"""Parallel track and creeping line searches as planners [IAMSAR2019, vol. III, sec. 12]."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import shapely

from sooner.decomposition.patterns import Tracks, creeping_line, parallel_track
from sooner.planners.patterns.searched import Searched
from sooner.planners.patterns.spaced import Spaced

__all__ = ["CreepingLine", "ParallelTrack"]


@dataclass(frozen=True)
class ParallelTrack(Spaced):
    """Legs parallel to the long side of the search area, one track spacing apart.

    Search areas are all of the free ground and rectangles about where the person may be; the search commences in any
    of four corners; the judge chooses.
    """

    def drawn(self, searched: Searched) -> Iterator[Tracks]:
        """Over every search area, at every spacing, from every corner."""
        return _laned(searched, parallel_track, self.spacing_m, self.overlap)


@dataclass(frozen=True)
class CreepingLine(Spaced):
    """Legs parallel to the short side of the search area, from one end of it to the other; else as `ParallelTrack`."""

    def drawn(self, searched: Searched) -> Iterator[Tracks]:
        """Over every search area, at every spacing, from every corner."""
        return _laned(searched, creeping_line, self.spacing_m, self.overlap)


def _laned(
    searched: Searched, pattern: Callable[..., Tracks], spacing_m: float | None, overlap: float
) -> Iterator[Tracks]:
    for spacing in searched.spacings(spacing_m, overlap):
        for area in searched.areas(spacing):
            for corner in _corners(area):
                yield pattern(area, spacing, commence=corner)


def _corners(area: Any) -> list[tuple[float, float]]:
    """The corners of the smallest rectangle around."""
    return [(float(x), float(y)) for x, y in shapely.get_coordinates(shapely.oriented_envelope(area))[:4]]
