"""A search along legs as planners see it: places one may fly to, what lies there, and routes that fit their budgets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.motion.pace import Pace
from sooner.planners import _leg_kernels as kernels
from sooner.problem import Plan, SearchProblem
from sooner.problem.leg_moves import LegMoves, place_numbers, places_of

__all__ = ["LegGround", "Routes", "leg_searchers"]

Route = NDArray[np.float64]
MOST_POINTS = 4000  # of one route
ROOM = 64  # points that a route may grow by, at least
COARSE = 1.6  # cells for each radius of the coarse level, at least


def leg_searchers(problem: SearchProblem) -> str | None:
    """What planners of legs handle: searchers along legs that share airspace and sensor; None if it is so."""
    moves = [searcher.moves for searcher in problem.searchers]
    if not all(isinstance(each, LegMoves) for each in moves):
        return "it plans moves along legs"
    if problem.drift is not None:
        return "it plans for a person who stays"
    if problem.objective.target is not None:
        return "it plans for the most by the end, not for a target soonest"
    first = moves[0]
    assert isinstance(first, LegMoves)
    for each in moves[1:]:
        assert isinstance(each, LegMoves)
        if each.airspace is not first.airspace or each.swath is not first.swath:
            return "it plans drones that share one airspace and one sensor"
        if _over_terrain(each.pace) and _over_terrain(first.pace) and each.pace.terrain is not first.pace.terrain:
            return "it plans drones over one terrain"
    if problem.gains.table.shape[1] != 1 or not np.allclose(problem.gains.ratio, np.exp(-1.0)):
        return "it plans gains of effort (`effort_gains`)"
    return None


def _over_terrain(pace: Pace) -> bool:
    """Whether slopes matter to how fast legs are flown."""
    return bool(pace.arrays()[7].size)


@dataclass(frozen=True, eq=False)
class Level:
    """The ground in cells of one size, as the kernels take it.

    Parameters
    ----------
    poc : (N,) float
    ground : tuple              metres of a cell, rows, columns, place of the south-west cell's centre
    sight : tuple               radius, law, strength (N,)
    pays : (n,) int             cells worth flying to
    """

    poc: NDArray[np.float64]
    ground: tuple[float, int, int, float, float]
    sight: tuple[float, int, NDArray[np.float64]]
    pays: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LegGround:
    """What all routes of a problem share.

    Parameters
    ----------
    problem : SearchProblem     whose searchers `leg_searchers` accepts
    """

    problem: SearchProblem

    @cached_property
    def fine(self) -> Level:
        """The ground as the judge sees it."""
        grid, swath = self.problem.grid, self.moves[0].swath
        ground = (float(grid.cell_m), *grid.shape, 0.0, 0.0)
        return Level(
            self.poc, ground, (float(swath.radius_m), swath.code, swath.strength), np.flatnonzero(self.within_reach)
        )

    @cached_property
    def coarse(self) -> Level:
        """The same in larger cells, over which routes change faster; the fine one where they would be no larger."""
        grid, swath = self.problem.grid, self.moves[0].swath
        reach = swath.radius_m - (grid.cell_m / 2 if swath.law == "edged" else 0.0)
        times = int(reach / COARSE / grid.cell_m)
        if times < 2 or swath.law == "seen":
            return self.fine
        height, width = (-(-side // times) for side in grid.shape)
        rows, cols = np.divmod(np.arange(grid.n_cells), grid.shape[1])
        of = (height - 1 - (grid.shape[0] - 1 - rows) // times) * width + cols // times
        parts = np.bincount(of, minlength=height * width)
        poc: NDArray[np.float64] = np.bincount(of, self.poc, minlength=height * width).astype(np.float64)
        pays = np.bincount(of, self.within_reach, minlength=height * width)
        strength = np.bincount(of, swath.strength, minlength=height * width) / np.maximum(parts, 1)
        cell_m, radius = times * float(grid.cell_m), float(swath.radius_m)
        if swath.law == "edged":
            strength, radius = np.where(strength > 0, cell_m, 0.0), reach + cell_m / 2
        off = (times - 1) / 2 * float(grid.cell_m)
        return Level(poc, (cell_m, height, width, off, off), (radius, swath.code, strength), np.flatnonzero(pays))

    @cached_property
    def moves(self) -> tuple[LegMoves, ...]:
        """How each searcher moves."""
        return tuple(each.moves for each in self.problem.searchers if isinstance(each.moves, LegMoves))

    @cached_property
    def poc(self) -> NDArray[np.float64]:
        """(N,) float: what all effort on a cell would pay."""
        return np.ascontiguousarray(self.problem.gains.first / -np.expm1(-1.0))

    @cached_property
    def paces(self) -> tuple[Any, ...]:
        """How fast each searcher flies, as the kernels take it."""
        told = [each.pace.arrays() for each in self.moves]
        heights, cell_m = max(((each[7], each[8]) for each in told), key=lambda over: over[0].size)
        return np.array([each[:7] for each in told], np.float64), heights, cell_m

    @property
    def walls(self) -> NDArray[np.float64]:
        """Of the airspace."""
        return self.moves[0].airspace.walls

    @cached_property
    def budgets(self) -> NDArray[np.float64]:
        """(R,) float: seconds of each searcher."""
        return np.array([float(searcher.budget) for searcher in self.problem.searchers])

    @cached_property
    def ends(self) -> NDArray[np.bool_]:
        """(R,) bool: whether each must come home."""
        return np.array([each.end is not None for each in self.moves])

    @cached_property
    def within_reach(self) -> NDArray[np.bool_]:
        """(N,) bool: cells that pay, and that some searcher could fly over in time if its ways were straight."""
        centres = self.problem.grid.centres_m
        space = self.moves[0].airspace
        found = np.zeros(self.problem.grid.n_cells, bool)
        sensible = np.flatnonzero((self.poc > 0) & (self.moves[0].swath.strength > 0))
        sensible = sensible[space.sees(centres[sensible])]
        for one, each in zip(self.problem.searchers, self.moves, strict=True):
            far = np.hypot(*(centres[sensible] - each.home).T)
            back = 0.0 if each.end is None else np.hypot(*(centres[sensible] - each.end).T)
            near = (far + back) / each.pace.speed_mps <= one.budget
            found[sensible[near]] |= space.joined(each.home, centres[sensible[near]])
        return found

    def reaches(self, number: int, places: Route) -> NDArray[np.bool_]:
        """(n,) bool: which places one searcher can fly to at all."""
        return self.moves[number].airspace.joined(self.moves[number].home, places)

    def seconds(self, number: int, route: Route) -> float:
        """How long a route of one searcher takes."""
        return self.moves[number].seconds(route)

    def joined(self, points: Route) -> Route:
        """The polyline through places, with ways around whatever stands between two of them."""
        space = self.moves[0].airspace
        parts = [points[:1]]
        for here, there in pairwise(points):
            parts.append(there[None] if space.clear(here, there) else space.way(here, there)[1:])
        return np.concatenate(parts)

    def kept(self, number: int, inner: Route) -> Route:
        """A route of one searcher through places, from home to its end, kept as plans are."""
        moves = self.moves[number]
        ends = [] if moves.end is None else [np.array([moves.end])]
        points = np.concatenate([np.array([moves.home]), inner, *ends])
        apart = np.append(True, np.hypot(*np.diff(points, axis=0).T) > kernels.KEPT_M)
        apart[-1] = moves.end is not None or apart[-1]
        return places_of(place_numbers(self.joined(points[apart])))

    def least(self, number: int) -> Route:
        """The shortest route of one searcher: its way home, or where it stands."""
        return self.kept(number, np.zeros((0, 2)))

    def fitting(self, number: int, inner: Route) -> tuple[Route, int]:
        """The longest first part of a route, by places, that can still come home in time; and how many places it has.

        Bisected, as to fly on to a further place takes longer; where a slope or the wind makes that wrong, a shorter
        part is found than there might be.
        """
        low, high = 0, len(inner)
        best = self.least(number)
        whole = self.kept(number, inner)
        if self.seconds(number, whole) <= self.budgets[number]:
            return whole, high
        while high - low > 1:
            middle = (low + high) // 2
            tried = self.kept(number, inner[:middle])
            if self.seconds(number, tried) <= self.budgets[number]:
                low, best = middle, tried
            else:
                high = middle
        return best, low

    def plan(self, routes: list[Route]) -> Plan:
        """Routes as a plan."""
        return Plan(tuple(place_numbers(route) for route in routes))


@dataclass(eq=False)
class Routes:
    """Routes that change in place, with the effort that they put on the ground.

    Parameters
    ----------
    ground : LegGround
    routes : of (n, 2)          legal ones
    level : Level
    """

    ground: LegGround
    routes: list[Route]
    level: Level

    def __post_init__(self) -> None:
        longest = max(len(route) for route in self.routes)
        room = min(2 * longest + ROOM, MOST_POINTS)
        shape = (len(self.routes), max(room, longest), 2)
        self.points, self.counts = np.zeros(shape), np.array([len(route) for route in self.routes], np.int64)
        for kept, route in zip(self.points, self.routes, strict=True):
            kept[: len(route)] = route
        size = len(self.level.poc)
        self.seconds, self.effort = np.zeros(len(self.routes)), np.zeros(size)
        self._scratch = np.empty(size, np.int64), np.empty(size), np.empty(size)
        self.best_points, self.best_counts = self.points.copy(), self.counts.copy()
        self.value = self.best_value = self.load()
        self.told = -np.inf  # the best value that the judge was asked about

    def load(self) -> float:
        """Work out everything anew, without what rounding has added up to."""
        level = self.level
        return float(
            kernels.load(
                *(self.points, self.counts, self.seconds, self.effort, level.poc, level.ground, level.sight),
                *(self.ground.paces, *self._scratch),
            )
        )

    @property
    def best(self) -> list[Route]:
        """The best routes so far."""
        return [kept[:count].copy() for kept, count in zip(self.best_points, self.best_counts, strict=True)]
