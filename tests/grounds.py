"""Random ground to fly over: concave areas with holes, no-fly zones, winds, slopes; and searches along legs over it."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from sooner.errors import InfeasibleProblemError, InvalidProblemError, UnsupportedProblemError
from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.motion.pace import Pace, Terrain
from sooner.planners import Planner
from sooner.planners.planner import follow, refuse_unhandled
from sooner.problem import Searcher, SearchProblem
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves, places_of
from sooner.sensors.swath import Swath


def star(rng: np.random.Generator, centre, radius: float, corners: int) -> Any:
    """A polygon round a centre whose border goes in and out."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
    far = radius * rng.uniform(0.25, 1.0, corners)
    return shapely.make_valid(
        shapely.Polygon(np.column_stack([centre[0] + far * np.cos(angles), centre[1] + far * np.sin(angles)])),
        method="structure",
        keep_collapsed=False,
    )


@dataclass(frozen=True)
class Ground:
    """A search area as it was drawn (with its holes), zones where nobody may fly, and the margin to both."""

    area: Any
    zones: tuple[Any, ...]
    margin_m: float
    side_m: float

    @property
    def free(self) -> Any:
        """Where a drone may be."""
        free = self.area
        for zone in self.zones:
            free = free.difference(zone.buffer(self.margin_m))
        polygons = [part for part in shapely.get_parts(free) if part.geom_type == "Polygon" and part.area > 1e-6]
        return shapely.union_all(polygons)

    def allows(self, points) -> bool:
        """Whether a polyline stays in the area as drawn and a margin away from every zone: without `Airspace`."""
        line = shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])
        if line.difference(self.area).length > 1e-6 or shapely.distance(line, self.area) > 0:
            return False
        return all(shapely.distance(line, zone) >= self.margin_m * 0.99 for zone in self.zones) and not any(
            shapely.relate_pattern(line, zone, "T********") for zone in self.zones
        )


def ground(rng: np.random.Generator, side_m: float = 1000.0) -> Ground:
    """An area with a concave border, up to three holes, up to four no-fly zones that may cross it or cut it in two."""
    area = star(rng, (side_m / 2, side_m / 2), side_m / 2, int(rng.integers(3, 40)))
    for _ in range(int(rng.integers(0, 4))):
        area = area.difference(star(rng, rng.uniform(0, side_m, 2), side_m * rng.uniform(0.03, 0.2), 7))
    zones = []
    for _ in range(int(rng.integers(0, 5))):
        where = rng.uniform(0, side_m, 2)
        if rng.random() < 0.3:
            zones.append(shapely.LineString([where, rng.uniform(0, side_m, 2)]).buffer(5.0, cap_style="flat"))
        else:
            zones.append(star(rng, where, side_m * rng.uniform(0.03, 0.25), int(rng.integers(3, 12))))
    zones = [zone for zone in zones if not zone.is_empty]
    return Ground(area, tuple(zones), float(rng.choice([0.0, 1.0, 10.0])), side_m)


def pace(rng: np.random.Generator, grid: Grid) -> Pace:
    """Any pace: with or without wind, slopes, and time lost at corners."""
    speed = float(rng.uniform(5, 15))
    accel = float(rng.choice([1.0, 3.0, math.inf]))
    airspeed = None if rng.random() < 0.5 else float(rng.uniform(6, 16))
    strength, heading = 0.9 * (airspeed or 0.0) * rng.random(), rng.uniform(0, 2 * np.pi)
    wind = (float(strength * math.cos(heading)), float(strength * math.sin(heading)))
    if rng.random() < 0.5:
        return Pace(speed, accel, airspeed, wind)
    heights = np.cumsum(rng.normal(0, grid.cell_m / 10, grid.shape), axis=0)
    return Pace(speed, accel, airspeed, wind, 2.0, 1.5, Terrain(heights, grid.cell_m))


def swath(rng: np.random.Generator, grid: Grid) -> Swath:
    """Any law."""
    radius = grid.cell_m * float(rng.uniform(0.4, 2.5))
    law = rng.choice(["seen", "edged", "even", "cube"])
    if law in ("seen", "edged"):
        return Swath.seen(grid, radius) if law == "seen" else Swath.edged(grid, radius)
    return Swath.of_width(grid, rng.uniform(0, radius, grid.shape), radius, law)


def leg_world(
    rng: np.random.Generator,
    cells: int = 16,
    searchers: int = 1,
    budget_s: float = 300.0,
    *,
    space: Airspace | None = None,
    ends: bool | None = None,
    side_m: float = 1000.0,
) -> SearchProblem:
    """A search along legs: homes within `space`, drawn at random; raises what `SearchProblem` raises."""
    grid = Grid((cells, cells), cell_m=side_m / cells)
    space = space or Airspace.of_cells(np.ones(grid.shape, bool), grid.cell_m)
    poc = rng.random(grid.n_cells) ** 4
    flies, sees = pace(rng, grid), swath(rng, grid)
    team = []
    for _ in range(searchers):
        home, end = places_in(rng, space, 2)
        closed = rng.random() < 0.7 if ends is None else ends
        end = (home if rng.random() < 0.7 else end) if closed else None
        budget = budget_s * float(rng.uniform(0.2, 1.0))
        moves = LegMoves(space, flies, sees, tuple(home), None if end is None else tuple(end))
        team.append(Searcher((0, 0), budget, moves=moves))
    return SearchProblem(grid, effort_gains(0.9 * poc / poc.sum()), tuple(team))


@dataclass(frozen=True)
class Flown:
    """What came of one random area: what was refused and why, or what the flights were worth and what broke a rule."""

    refused: str = ""
    value: float = 0.0
    share: float = 0.0
    broken: tuple[str, ...] = ()


def fly_area(seed: int, planner: Planner, ticks: int = 8) -> Flown:
    """Draw an area and a search over it, anything at all; plan it, or keep the words of the refusal."""
    rng = np.random.default_rng(seed)
    drawn = ground(rng)
    try:
        problem = _any_search(rng, drawn)
        refuse_unhandled(problem, planner)
        advance = follow(planner.plans(problem, rng))
        for tick in range(ticks):
            incumbent = advance(tick / ticks)
            if incumbent is None:
                break
            best = incumbent
    except (InvalidProblemError, InfeasibleProblemError, UnsupportedProblemError) as error:
        return Flown(f"{type(error).__name__}: {error}")
    broken, shares = [], []
    for number, (searcher, actions) in enumerate(zip(problem.searchers, best.plan.actions, strict=True)):
        points, each = places_of(actions), searcher.moves
        seconds = seconds_of(points[turns(points)], each.pace, 0.5)
        if seconds > searcher.budget:  # steps were too long, or the sortie is
            through, stopping = (seconds_of(way, each.pace, 0.01) for way in (points[turns(points)], points))
            seconds = min(through, stopping)  # a drone may stop wherever its plan has a place
        shares.append(seconds / searcher.budget)
        if not drawn.allows(points):
            broken.append(f"sortie {number} leaves the area or enters a zone")
        if seconds > searcher.budget * 1.001 + 0.01:
            broken.append(f"sortie {number} takes {seconds} s of {searcher.budget} s")
        if tuple(points[0]) != each.home or (each.end is not None and tuple(points[-1]) != each.end):
            broken.append(f"sortie {number} does not fly from its home to where it lands")
    return Flown("", best.value, float(np.mean(shares)), tuple(broken))


def _any_search(rng: np.random.Generator, drawn: Ground) -> SearchProblem:
    """One to three sorties, wherever they start and land: in the area, on a zone, beyond the border."""
    space = Airspace(drawn.free)
    cells = int(rng.integers(8, 25))
    grid = Grid((cells, cells), cell_m=drawn.side_m / cells)
    flies, sees = pace(rng, grid), swath(rng, grid)
    if rng.random() < 0.02:
        flies = Pace(10.0, 2.0, 8.0, (8.0, 1.0))
    inside = places_in(rng, space, 4) if rng.random() < 0.9 else rng.uniform(0, drawn.side_m, (4, 2)).round(2)
    poc = rng.random(grid.n_cells) ** 4
    team, home = [], tuple(inside[0])
    for number in range(int(rng.integers(1, 4))):
        end = (home, tuple(inside[1 + number]), None)[int(rng.integers(0, 3))]
        budget = float(np.exp(rng.uniform(np.log(5.0), np.log(900.0))))
        team.append(Searcher((0, 0), budget, moves=LegMoves(space, flies, sees, home, end)))
    return SearchProblem(grid, effort_gains(0.9 * poc / poc.sum()), tuple(team))


def turns(points) -> list[int]:
    """Where a polyline begins, turns and ends; it is flown through what lies straight ahead."""
    kept = [0]
    for k in range(1, len(points) - 1):
        here, there = points[k] - points[kept[-1]], points[k + 1] - points[k]
        if not here.any():
            kept[-1] = k
        elif there.any() and math.atan2(abs(here[0] * there[1] - here[1] * there[0]), here @ there) > 1e-6:
            kept.append(k)
    return [*kept, len(points) - 1]


def places_in(rng: np.random.Generator, space: Airspace, count: int) -> np.ndarray:
    """(count, 2): places that may be flown to."""
    west, south, east, north = space.free.bounds
    found = np.zeros((0, 2))
    for _ in range(200):
        tried = np.column_stack([rng.uniform(west, east, 50), rng.uniform(south, north, 50)]).round(2)
        found = np.concatenate([found, tried[space.sees(tried)]])
        if len(found) >= count:
            return found[:count]
    raise InvalidProblemError("an airspace without places came")


def seconds_of(points, flies: Pace, step_m: float = 0.05) -> float:
    """Time of a flight that stops at every corner, in small steps: an integrator of its own."""
    total = 0.0
    for start, end in pairwise(points):
        length = math.dist(start, end)
        if length > 0:
            total += _leg_seconds(np.asarray(start), np.asarray(end), length, flies, step_m)
    return total


def _leg_seconds(start, end, length, flies, step_m) -> float:
    course = (end - start) / length
    wind = np.array(flies.wind)
    cruise = flies.speed_mps
    if flies.airspeed_mps is not None:
        across = wind @ [-course[1], course[0]]
        cruise = min(cruise, wind @ course + math.sqrt(flies.airspeed_mps**2 - across**2))
    steps = max(int(length / step_m), 2)
    middle = (np.arange(steps) + 0.5) / steps
    most = np.full(steps, cruise)
    if flies.terrain is not None:
        pieces = max(math.ceil(2 * length / flies.terrain.cell_m), 1)
        knots = np.arange(pieces + 1) / pieces
        rise = np.diff(_heights(start + knots[:, None] * (end - start), flies.terrain)) / (length / pieces)
        piece = (middle * pieces).astype(int)
        with np.errstate(divide="ignore"):
            up = np.where(rise > 0, (flies.climb_mps or math.inf) / rise, math.inf)
            down = np.where(rise < 0, (flies.descent_mps or math.inf) / -rise, math.inf)
        most = np.minimum(most, np.minimum(up, down)[piece])
    if math.isinf(flies.accel_mps2):
        return float((length / steps / most).sum())
    at = np.arange(steps + 1) / steps * length
    caps = np.minimum(np.append(most, math.inf), np.append(math.inf, most)) ** 2
    caps[0] = caps[-1] = 0.0
    gain = 2 * flies.accel_mps2 * at
    squares = np.minimum.accumulate(caps - gain) + gain
    squares = np.minimum.accumulate((squares + gain)[::-1])[::-1] - gain
    speeds = np.sqrt(np.maximum(squares, 0.0))
    return float((2 * np.diff(at) / (speeds[1:] + speeds[:-1])).sum())


def _heights(points, terrain: Terrain):
    from scipy.ndimage import map_coordinates

    rows = terrain.heights.shape[0] - 1 - points[:, 1] / terrain.cell_m
    return map_coordinates(terrain.heights, [rows, points[:, 0] / terrain.cell_m], order=1, mode="nearest")
