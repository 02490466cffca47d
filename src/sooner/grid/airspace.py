"""Airspace: where a drone may be, and the straight legs and shortest ways that stay within."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["KEPT_M", "Airspace"]

KEPT_M = 0.01  # to which plans keep places; ways stay a few times as far from borders, so that rounding never crosses
MOST_WALLS = (400, 2000)  # stretches of border that ways are planned along: a few, or more where few lose much ground
LOSES_MUCH = 0.03  # share of the ground
SIMPLER_M = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)  # by which a border may be drawn simpler, on the safe side


@dataclass(frozen=True, eq=False)
class Airspace:
    """Where a drone may be: search area and transit, less no-fly zones, with its margin already kept.

    The judge asks `holds`, which is exact. Planners fly within `walls`, which lie a few centimetres inside, or more
    where the border has so many corners that it is drawn simpler; what they find is always held.

    Parameters
    ----------
    free : shapely geometry     Polygon or MultiPolygon, metres east and north of the south-west cell's centre

    Raises
    ------
    InvalidProblemError         if it is empty, not valid, or not of polygons

    Examples
    --------
    >>> around = Airspace(shapely.box(0, 0, 100, 100).difference(shapely.box(40, 0, 60, 60)))
    >>> around.holds([[20, 30], [80, 30]]), around.holds([[20, 30], [20, 80], [80, 80], [80, 30]])
    (False, True)
    >>> around.way((20, 30), (80, 30)).round()
    array([[20., 30.],
           [40., 60.],
           [60., 60.],
           [80., 30.]])
    """

    free: Any

    def __post_init__(self) -> None:
        if self.free.geom_type not in ("Polygon", "MultiPolygon") or self.free.is_empty:
            raise InvalidProblemError(f"an airspace of {self.free.geom_type} without ground came; expected polygons")
        if not self.free.is_valid:
            raise InvalidProblemError(f"an airspace came whose {shapely.is_valid_reason(self.free)}; mend its border")
        shapely.prepare(self.free)

    @classmethod
    def of_cells(cls, free: NDArray[np.bool_], cell_m: float) -> Airspace:
        """The ground of free cells, (H, W) bool, row 0 north."""
        height, width = free.shape
        if free.all():
            return cls(shapely.box(-cell_m / 2, -cell_m / 2, (width - 0.5) * cell_m, (height - 0.5) * cell_m))
        rows, cols = np.nonzero(free)
        if len(rows) == 0:
            raise InvalidProblemError("an airspace without a free cell came; expected some ground to fly over")
        south = (height - 1 - rows) * cell_m
        squares = shapely.box(
            cols * cell_m - cell_m / 2, south - cell_m / 2, cols * cell_m + cell_m / 2, south + cell_m / 2
        )
        return cls(shapely.union_all(squares))

    def holds(self, points: ArrayLike) -> bool:
        """Whether every leg of a polyline, (n, 2) metres, stays within; its border belongs to it."""
        line = np.asarray(points, np.float64)
        shape = shapely.Point(line[0]) if len(line) == 1 else shapely.LineString(line)
        return bool(shapely.covers(self.free, shape))

    def leaves(self, points: ArrayLike) -> int | None:
        """The first leg of a polyline (n, 2) that does not stay within; None where all do."""
        line = np.asarray(points, np.float64)
        if self.holds(line):
            return None
        if len(line) == 1:
            return 0
        legs = shapely.linestrings(np.stack([line[:-1], line[1:]], axis=1))
        return int(np.argmin(shapely.covers(self.free, legs)))

    # ------------------------------------------------------------ as planners see it

    @cached_property
    def inner(self) -> Any:
        """What planners fly in: `free` less a few centimetres, and simpler where its border turns often."""
        drawn = [self._simpler(SIMPLER_M[0])]
        for most in MOST_WALLS:
            while shapely.get_num_coordinates(drawn[-1]) > most and len(drawn) < len(SIMPLER_M):
                drawn.append(self._simpler(SIMPLER_M[len(drawn)]))
            shrunk = next((each for each in drawn if shapely.get_num_coordinates(each) <= most), drawn[-1])
            if shrunk.area >= (1.0 - LOSES_MUCH) * drawn[0].area:
                break
        shapely.prepare(shrunk)
        return shrunk

    def _simpler(self, simpler_m: float) -> Any:
        """By half of what was taken away: where a ring begins, GEOS moves the border by up to twice what it is told."""
        shrunk = self.free.buffer(-3 * KEPT_M - simpler_m, join_style="mitre")
        return shrunk.simplify(simpler_m / 2) if simpler_m else shrunk

    @cached_property
    def walls(self) -> NDArray[np.float64]:
        """(E, 4) float: both ends of every stretch of `inner`'s border."""
        rings = [shapely.get_coordinates(ring) for ring in _rings(self.inner)]
        ends = [np.concatenate([ring[:-1], ring[1:]], axis=1) for ring in rings]
        return np.ascontiguousarray(np.concatenate(ends)) if ends else np.zeros((0, 4))

    @cached_property
    def turns(self) -> NDArray[np.float64]:
        """(n, 2) float: places that shortest ways turn at: just inside of the border's reflex corners."""
        found = [_reflex(shapely.get_coordinates(ring)) for ring in _rings(self._nodes)]
        return np.ascontiguousarray(np.concatenate([*found, np.zeros((0, 2))]))

    @cached_property
    def _nodes(self) -> Any:
        return shapely.orient_polygons(self.inner.buffer(-2 * KEPT_M, join_style="mitre"))

    @cached_property
    def _between(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Metres between turns along free legs, and the turn before each on the way from another."""
        from scipy.sparse.csgraph import dijkstra

        from sooner.grid._airspace_kernels import visible

        direct = visible(self.turns, self.turns, self.walls)
        np.fill_diagonal(direct, 0.0)
        far, before = dijkstra(np.where(np.isfinite(direct), direct, 0.0), return_predecessors=True)
        return far, before

    def sees(self, points: ArrayLike) -> NDArray[np.bool_]:
        """(n,) bool: which places, (n, 2), planners may fly to: those within `inner`."""
        x, y = np.asarray(points, np.float64).reshape(-1, 2).T
        return np.asarray(shapely.contains_xy(self.inner, x, y))

    def joined(self, place: ArrayLike, points: ArrayLike) -> NDArray[np.bool_]:
        """(n,) bool: which places, (n, 2), planners may fly to from another: those in the same part of `inner`."""
        home, (x, y) = np.asarray(place, np.float64), np.asarray(points, np.float64).reshape(-1, 2).T
        for part in shapely.get_parts(self.inner):
            if shapely.contains_xy(part, *home):
                shapely.prepare(part)
                return np.asarray(shapely.contains_xy(part, x, y))
        return np.zeros(len(x), bool)

    def clear(self, start: ArrayLike, end: ArrayLike) -> bool:
        """Whether the straight leg between two places that planners may fly to is free."""
        from sooner.grid._airspace_kernels import clear

        (x0, y0), (x1, y1) = np.asarray(start, np.float64), np.asarray(end, np.float64)
        return bool(clear(x0, y0, x1, y1, self.walls))

    def way(self, start: ArrayLike, end: ArrayLike) -> NDArray[np.float64]:
        """(n, 2) float: the shortest way within, both ends among it.

        Raises
        ------
        InvalidProblemError         where there is none
        """
        from sooner.grid._airspace_kernels import visible

        a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
        if self.clear(a, b):
            return np.stack([a, b])
        if len(self.turns):
            far, before = self._between
            first = visible(a[None], self.turns, self.walls)[0]
            last = visible(self.turns, b[None], self.walls)[:, 0]
            total = first[:, None] + far + last[None]
            k, j = np.unravel_index(int(np.argmin(total)), total.shape)
            if np.isfinite(total[k, j]):
                chain = [int(j)]
                while chain[-1] != k:
                    chain.append(int(before[k, chain[-1]]))
                return np.concatenate([a[None], self.turns[chain[::-1]], b[None]])
        raise InvalidProblemError(
            f"no way from {a.round(1).tolist()} to {b.round(1).tolist()} stays within the area and out of no-fly zones"
        )

    def metres_from(self, start: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
        """(n,) float: length of the shortest way from a place to each of others, (n, 2); inf where there is none."""
        from sooner.grid._airspace_kernels import visible

        a, others = np.asarray(start, np.float64)[None], np.ascontiguousarray(points, np.float64)
        found = visible(a, others, self.walls)[0]
        if len(self.turns):
            far, _ = self._between
            to_turn = (visible(a, self.turns, self.walls)[0][:, None] + far).min(axis=0)
            found = np.minimum(found, (to_turn[:, None] + visible(self.turns, others, self.walls)).min(axis=0))
        return np.asarray(found)


def _rings(shape: Any) -> list[Any]:
    """Every closed line of the border of polygons."""
    parts = [part for part in shapely.get_parts(shape) if not part.is_empty]
    return [ring for part in parts for ring in (part.exterior, *part.interiors)]


def _reflex(ring: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners of a ring, ground on its left, where the ground's angle is above half a turn."""
    points = ring[:-1]
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    turned = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.asarray(points[turned < 0])
