"""What a pattern is drawn over: the free ground, where the person most likely is, and how far apart tracks lie."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.planners.leg_ground import LegGround

__all__ = ["Searched", "connected"]

_WITHIN_M = 0.03  # inside of what planners may fly in, so that places kept to the centimetre are too
_RAGGED = 50_000  # corners
_SHARES = (0.3, 0.6, 0.9)  # of the POC that a search area may hold
_FLOWN = (0.5, 0.8)  # of what all sorties fly, that may be flown over the search area


@dataclass(frozen=True, eq=False)
class Searched:
    """One connected part of the airspace, and the sorties that begin there.

    Parameters
    ----------
    ground : LegGround
    free : Polygon              metres
    numbers : tuple of int      of the searchers, in the order in which they take off
    """

    ground: LegGround
    free: Any
    numbers: tuple[int, ...]

    @cached_property
    def radius_m(self) -> float:
        """To which a drone sees all there is to see."""
        swath = self.ground.moves[0].swath
        return swath.radius_m - (self.ground.problem.grid.cell_m / 2 if swath.law == "edged" else 0.0)

    def spacings(self, spacing_m: float | None, overlap: float) -> tuple[float, ...]:
        """Metres between tracks: as asked for; or the width of a perfect swath, less the overlap; or by sweep width.

        By sweep width W the first is W, for a coverage C = W / S of one; wider ones follow, as thinner coverage of more
        ground may find more: POD = 1 - exp(-C) rises ever more slowly. None leaves strips out of sight.
        """
        if spacing_m is not None:
            return (spacing_m,)
        swath = self.ground.moves[0].swath
        widest = 2 * self.radius_m * (1 - overlap)
        if swath.law in ("seen", "edged"):
            return (widest,)
        pays = self.ground.poc > 0
        strength = float(np.average(swath.strength[pays], weights=self.ground.poc[pays])) if pays.any() else 0.0
        width = strength if swath.law == "cube" else strength * np.pi * swath.radius_m**2
        if width <= 0:
            return (widest,)
        return tuple(sorted({min(width * (1 - overlap) * wider, widest) for wider in (1.0, 1.5, 2.0)}))

    @cached_property
    def paying(self) -> NDArray[np.int64]:
        """(n,) int: cells that pay, and that sorties can fly over here, the likeliest first."""
        pays = np.flatnonzero(self.ground.within_reach)
        shapely.prepare(self.free)
        pays = pays[shapely.intersects_xy(self.free, *self.ground.problem.grid.centres_m[pays].T)]
        ranked: NDArray[np.int64] = pays[np.argsort(-self.ground.poc[pays], kind="stable")]
        return ranked

    def datums(self, spacing_m: float) -> list[NDArray[np.float64]]:
        """(2,) each: where the person most likely is. None where nothing pays.

        Of the likeliest cells the one nearest to their middle; and the middles of squares, as large as the sorties can
        cover, that hold the most POC.
        """
        if len(self.paying) == 0:
            return []
        centres = self.ground.problem.grid.centres_m[self.paying]
        poc = self.ground.poc[self.paying]
        likeliest = centres[poc >= poc[0] * (1 - 1e-9)]
        peak: NDArray[np.float64] = likeliest[np.argmin(np.hypot(*(likeliest - likeliest.mean(axis=0)).T))]
        return [peak, *(self._richest(side_m) for side_m in self._sides_m(spacing_m))]

    def _richest(self, side_m: float) -> NDArray[np.float64]:
        """(2,): the middle of the square of that side that holds the most POC; of equals the one in their middle."""
        from scipy.ndimage import uniform_filter

        grid = self.ground.problem.grid
        pays = np.zeros(grid.n_cells)
        pays[self.paying] = self.ground.poc[self.paying]
        cells = min(max(int(side_m / grid.cell_m), 1), 2 * max(grid.shape))
        held = uniform_filter(pays.reshape(grid.shape), cells, mode="constant").ravel()
        best = grid.centres_m[held >= held.max() * (1 - 1e-9)]
        place: NDArray[np.float64] = best[np.argmin(np.hypot(*(best - best.mean(axis=0)).T))]
        return place

    def flown_m(self) -> float:
        """Metres that all sorties fly from here, at most."""
        return sum(float(self.ground.budgets[n]) * self.ground.moves[n].pace.speed_mps for n in self.numbers)

    def _sides_m(self, spacing_m: float) -> list[float]:
        """Sides of squares that the sorties can cover, with more or less time left for ways and turns."""
        return [float(np.sqrt(share * self.flown_m() * spacing_m)) for share in _FLOWN]

    @cached_property
    def polygon(self) -> Any:
        """(Multi)Polygon: all cells that pay, also those that are only seen from beside them; ragged ones in a hull."""
        cells = self._ground_of(np.flatnonzero((self.ground.poc > 0) & (self.ground.moves[0].swath.strength > 0)))
        return cells if shapely.get_num_coordinates(cells) <= _RAGGED else cells.convex_hull

    def areas(self, spacing_m: float) -> Iterator[Any]:
        """Search areas worth a try, cut to the free ground: all of it, then rectangles about where the person may be.

        Those hold a share of the POC, or are squares about the datum as large as the sorties can cover.
        """
        if len(self.paying) == 0:
            return
        rectangles = [
            shapely.oriented_envelope(self._ground_of(self.paying[:count]))
            for count in (len(self.paying), *self._counts())
        ]
        peak, *richest = self.datums(spacing_m)
        for side, middle in zip(self._sides_m(spacing_m), richest, strict=True):
            rectangles += [_square(peak, side), _square(middle, side)]
        for rectangle in rectangles:
            area = self.free.intersection(rectangle)
            parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon" and part.area > 1.0]
            if parts:
                yield shapely.multipolygons(parts)

    def _counts(self) -> list[int]:
        """How many of the likeliest cells hold each share of the POC."""
        held = np.cumsum(self.ground.poc[self.paying])
        return [int(np.searchsorted(held, share * held[-1])) + 1 for share in _SHARES]

    def _ground_of(self, cells: NDArray[np.int64]) -> Any:
        """(Multi)Polygon: the ground of cells, run by run of each row."""
        grid = self.ground.problem.grid
        taken = np.zeros(grid.n_cells, np.int8)
        taken[cells] = 1
        rows = np.pad(taken.reshape(grid.shape), ((0, 0), (1, 1)))
        steps = np.diff(rows, axis=1)
        (row, first), (_, past) = np.nonzero(steps == 1), np.nonzero(steps == -1)
        half, south = grid.cell_m / 2, (grid.shape[0] - 1 - row) * grid.cell_m
        return shapely.union_all(
            shapely.box(first * grid.cell_m - half, south - half, past * grid.cell_m - half, south + half)
        )


def connected(ground: LegGround) -> list[Searched]:
    """The parts of the airspace from which sorties take off, each with its sorties in the order of departure."""
    free = ground.moves[0].airspace.inner.buffer(-_WITHIN_M, join_style="mitre")
    parts = [part for part in shapely.get_parts(free) if part.geom_type == "Polygon" and part.area > 1.0]
    if not parts:
        return []
    order = sorted(range(len(ground.moves)), key=lambda number: (ground.moves[number].departs_s, number))
    homes = shapely.points([ground.moves[number].home for number in order])
    nearest = np.array([shapely.distance(part, homes) for part in parts]).argmin(axis=0)
    found = [(part, tuple(np.array(order)[nearest == k].tolist())) for k, part in enumerate(parts)]
    return [Searched(ground, part, numbers) for part, numbers in found if numbers]


def _square(middle: NDArray[np.float64], side_m: float) -> Any:
    (x, y), half = middle, side_m / 2
    return shapely.box(x - half, y - half, x + half, y + half)
