"""First routes along legs: lanes over the best ground, spirals, and walks over a lattice as wide as the swath."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from math import ceil, pi

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.planners.anneal import Anneal
from sooner.planners.leg_ground import LegGround, Route, Routes
from sooner.planners.leg_spirals import spiral_routes
from sooner.planners.patterns.no_gap import NoGap
from sooner.planners.planner import follow
from sooner.problem import CellMoves, Gains, Searcher, SearchProblem
from sooner.problem.leg_moves import place_numbers, places_of

__all__ = ["first_routes", "lane_routes", "lattice_routes"]

WIDER = 1.35  # lanes that leave gaps, or overlap less, for time that is short
GAPLESS_TICKS = 2  # the way home, and the tracks as they are drawn
HALVINGS = 12  # of the share of the ground that lanes cover
LATTICE_TICKS = 24  # of the walk over a lattice
MOST_LATTICE = 40_000  # nodes
OVERLAPPED = 0.9  # of the swath between arms of a spiral, where there is time to leave no gap


def lane_routes(ground: LegGround, angle: float, spacing: float) -> list[Route]:
    """Routes along parallel lanes over the richest ground, as much of it as the budgets allow.

    Ground is worth flying over where its smoothed POC lies above a level; the level is bisected until the lanes just
    fit. Consecutive parts of the lanes go to consecutive searchers.

    Parameters
    ----------
    angle : float           of the lanes, radians counter-clockwise from east
    spacing : float         metres between them
    """
    lanes = _Lanes(ground, angle, spacing)
    best = [ground.least(number) for number in range(len(ground.moves))]
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = (low + high) / 2
        fitted, whole = _shared(ground, lanes.over(share))
        if whole:
            low, best = share, fitted
        else:
            high = share
    cut, _ = _shared(ground, lanes.over(high))
    if low > 1.0 - 0.5**HALVINGS * 2:  # there is time left: over all of it again, the other way
        again = _Lanes(ground, angle + pi / 2, spacing).over(1.0)
        cut, _ = _shared(ground, np.concatenate([lanes.over(1.0), again, lanes.over(1.0)]))
    return max((best, cut), key=lambda routes: Routes(ground, routes, ground.coarse).value)


def _shared(ground: LegGround, inner: Route) -> tuple[list[Route], bool]:
    """Places in order, as routes of one searcher after the other, and whether all of them fit."""
    routes = []
    for number in range(len(ground.moves)):
        own = np.flatnonzero(ground.reaches(number, inner))
        route, used = ground.fitting(number, inner[own])
        routes.append(route)
        inner = np.delete(inner, own[: used - 1 if 0 < used < len(own) else used], axis=0)
    return routes, len(inner) == 0


class _Lanes:
    """Stretches of parallel lanes, each with the POC per metre around it."""

    def __init__(self, ground: LegGround, angle: float, spacing: float) -> None:
        from scipy.ndimage import gaussian_filter

        grid, moves = ground.problem.grid, ground.moves[0]
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        rich = np.where(ground.within_reach, ground.poc * (moves.swath.strength > 0), 0.0).reshape(grid.shape)
        smooth = gaussian_filter(rich, max(spacing / grid.cell_m, 0.5), mode="constant")
        centres = grid.centres_m[ground.within_reach]
        self.ground, self.along, self.across = ground, along, across
        if len(centres) == 0:
            self.level, self.places = np.zeros(0), np.zeros((0, 2))
            self.lane = np.zeros(0, np.int64)
            return
        offset, run = centres @ across, centres @ along
        lanes = np.arange(ceil((np.ptp(offset) + grid.cell_m) / spacing))
        first = offset.min() + (np.ptp(offset) - (len(lanes) - 1) * spacing) / 2
        if moves.swath.law == "seen":  # over centres of cells, where lanes run along rows
            first = round(first / grid.cell_m) * grid.cell_m
        steps = np.arange(run.min(), run.max() + spacing / 2, spacing / 2)
        places = (first + lanes * spacing)[:, None, None] * across + steps[None, :, None] * along
        places = places_of(place_numbers(places.reshape(-1, 2)))
        held = np.any([ground.reaches(number, places) for number in range(len(ground.moves))], axis=0)
        self.lane, self.places = np.repeat(lanes, len(steps))[held], places[held]
        cols = np.clip(np.rint(self.places[:, 0] / grid.cell_m).astype(int), 0, grid.shape[1] - 1)
        rows = np.clip(grid.shape[0] - 1 - np.rint(self.places[:, 1] / grid.cell_m).astype(int), 0, grid.shape[0] - 1)
        self.level = smooth[rows, cols]

    def over(self, share: float) -> Route:
        """(n, 2): both ends of every stretch over the best share of the ground, to and fro."""
        if len(self.level) == 0:
            return np.zeros((0, 2))
        kept = self.level >= np.quantile(self.level, 1.0 - share)
        kept &= self.level > 0
        lane, places = self.lane[kept], self.places[kept]
        ends: list[NDArray[np.float64]] = []
        for turn, which in enumerate(np.unique(lane)):
            own = places[lane == which]
            ends.append(own[[0, -1]] if turn % 2 == 0 else own[[-1, 0]])
        return np.concatenate(ends) if ends else np.zeros((0, 2))


def lattice_routes(ground: LegGround, angle: float, pitch: float, rng: Generator) -> list[Route]:
    """Routes from walks over a square lattice through home, annealed one searcher after the other.

    A step of the walk stands for a stretch of swath; corners are paid for by taking steps away until the route fits.

    Parameters
    ----------
    angle : float           of the lattice, radians
    pitch : float           metres between neighbours
    """
    east_north = ground.problem.grid.centres_m
    east, north = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    moves, origin = ground.moves[0], np.array(ground.moves[0].home)
    if moves.swath.law == "seen":
        origin = np.rint(origin / ground.problem.grid.cell_m) * ground.problem.grid.cell_m
    off = east_north - origin
    cols, rows = np.rint(off @ east / pitch).astype(int), -np.rint(off @ north / pitch).astype(int)
    near = ground.within_reach
    if not near.any():
        return [ground.least(number) for number in range(len(ground.moves))]
    west, top = min(cols[near].min(), 0), min(rows[near].min(), 0)
    shape = (max(int(rows[near].max()), 0) - top + 1, max(int(cols[near].max()), 0) - west + 1)
    if shape[0] * shape[1] > MOST_LATTICE:
        return [ground.least(number) for number in range(len(ground.moves))]
    node_rows, node_cols = np.divmod(np.arange(shape[0] * shape[1]), shape[1])
    nodes = origin + pitch * ((node_cols + west)[:, None] * east - (node_rows + top)[:, None] * north)
    mass = np.bincount(
        (rows[near] - top) * shape[1] + cols[near] - west, ground.poc[near], minlength=shape[0] * shape[1]
    )
    nodes = places_of(place_numbers(nodes))
    detect = 1.0 if moves.swath.law == "seen" else 1.0 - np.exp(-moves.swath.width_m / pitch)
    obstacles = ~ground.reaches(0, nodes).reshape(shape)
    home = (-top, -west)
    obstacles[home] = False
    coarse = Grid(shape, "square4", pitch, obstacles if obstacles.any() else None)
    gains, routes = Gains.independent(mass, np.full(len(mass), detect)), []
    for number in range(len(ground.moves)):
        if not ground.reaches(number, np.array([moves.home])).all():
            routes.append(ground.least(number))
            continue
        route, walk = _walked(ground, number, coarse, gains, nodes, home, rng)
        looked = np.bincount(walk, minlength=len(mass))
        gains = gains.after(looked)
        routes.append(route)
    return routes


def _walked(
    ground: LegGround,
    number: int,
    coarse: Grid,
    gains: Gains,
    nodes: Route,
    home: tuple[int, int],
    rng: Generator,
) -> tuple[Route, NDArray[np.int64]]:
    """One searcher's route over the lattice, and the nodes that it passes."""
    moves, speed = ground.moves[number], ground.moves[number].pace.speed_mps
    steps = max(2 * int(ground.budgets[number] * speed / coarse.cell_m / 2), 2)
    back = home if moves.end == moves.home else None
    for _ in range(4):
        problem = SearchProblem(coarse, gains, (Searcher(home, steps, back, CellMoves()),))
        advance, walk = follow(Anneal(starts=12, threads=1).plans(problem, rng)), np.zeros(1, np.int64)
        for tick in range(LATTICE_TICKS):
            incumbent = advance(tick / LATTICE_TICKS)
            if incumbent is None:
                break
            walk = incumbent.plan.actions[0]
        inner = _corners(nodes[walk])
        whole = ground.kept(number, inner)
        taken = ground.seconds(number, whole)
        if taken <= ground.budgets[number] or steps <= 2:
            return whole if taken <= ground.budgets[number] else ground.fitting(number, inner)[0], walk
        steps = max(2 * int(steps * ground.budgets[number] / taken * 0.98 / 2), 2)
    route, used = ground.fitting(number, inner)
    return route, walk[: max(int(len(walk) * used / max(len(inner), 1)), 1)]


def _corners(points: Route) -> Route:
    """Where a walk over the lattice turns or turns back; without its first place, which is home."""
    if len(points) < 3:
        return points[1:]
    steps = np.diff(points, axis=0)
    turns = np.append(np.abs(np.diff(steps, axis=0)).max(axis=1) > 1e-9, True)
    kept: Route = points[1:][turns]
    return kept


def _counted_m(ground: LegGround, width: float) -> float:
    """How wide a lane over centres of cells counts, where cells are seen by their centres; else the width."""
    swath, cell_m = ground.moves[0].swath, ground.problem.grid.cell_m
    return (2 * int(swath.radius_m / cell_m) + 1) * cell_m if swath.law == "seen" else width


def _is_enough(ground: LegGround, width: float) -> bool:
    """Whether the sorties are long enough to sweep all the ground that pays, if no metre were flown twice."""
    flown_m = sum(each.pace.speed_mps * budget for each, budget in zip(ground.moves, ground.budgets, strict=True))
    return bool(ground.within_reach.sum() * ground.problem.grid.cell_m**2 <= width * flown_m)


def _gapless(ground: LegGround, rng: Generator) -> list[Route]:
    """Routes that leave nothing unseen, as far as they go."""
    *_, last = islice(NoGap().plans(ground.problem, rng), GAPLESS_TICKS)
    return [places_of(actions) for actions in last.plan.actions]


def first_routes(ground: LegGround, rng: Generator) -> Iterator[list[Route]]:
    """One set of first routes after another, the quickest to find first."""
    width = max(ground.moves[0].swath.width_m, ground.problem.grid.cell_m)
    counted = _counted_m(ground, width)
    for apart in (counted, width) if counted > width else (width, WIDER * width):
        for angle in (0.0, pi / 2, pi / 4, 3 * pi / 4):
            yield lane_routes(ground, angle, apart)
    for apart, sense in ((width, 1.0), (width, -1.0), (OVERLAPPED * width, 1.0)):
        spirals = spiral_routes(ground, apart, sense)
        if spirals is not None:
            yield spirals
    if _is_enough(ground, width):
        yield _gapless(ground, rng)
    if max(each.pace.speed_mps**2 / each.pace.accel_mps2 for each in ground.moves) > width / 2:
        return  # at every corner a drone loses more than it sees between two of them
    for angle, pitch in dict.fromkeys(((0.0, counted), (0.0, width), (pi / 4, width))):
        yield lattice_routes(ground, angle, pitch, rng)
