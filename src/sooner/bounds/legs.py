"""What no sorties along legs can find: ground swept grows with metres flown, and metres are bounded by time.

Only two things about flights are used, so the bounds hold for every legal plan, of any number of sorties:

**Metres.** A sortie of T seconds flies at most `longest_m`. From rest to rest no leg of l metres is quicker than

    t(l) = l / v + v / a      or, below v^2 / a metres, 2 sqrt(l / a)

with v the greatest speed over the ground. t is concave, so a way of L metres whose legs are no longer than D takes at
least L t(D) / D; the airspace's extent is such a D, and L / 2 is where a way comes home to where it began. In a wind w
a course along the unit vector u takes at least 1 / sqrt(A^2 - w^2) - (w u) / (A^2 - w^2) seconds a metre, A the
airspeed, with equality across the wind; summed over the way this is L / sqrt(A^2 - w^2) - (w d) / (A^2 - w^2), d from
home to its end. What is flown before the first and after the last cell that pays comes into view finds nothing.

**Cells in view.** A disc of radius R whose centre goes L metres, moved together with a convex tile K, sweeps at most
|D + K| + (2 R + width of K) L. Tiles around the centres of cells do not overlap, and lie within that area whenever the
centre has been in view: so no more than this over |K| cells are ever in view (`most_in_view`). K is the cell with its
corners cut off, as far as pays.

**Effort.** Let f(r) be the effort a metre at distance r, k = its strength, and E(r) the integral of f from r to R: who
comes as near as r from beyond R has put at least E(r) on the cell, whichever way he came, and will put as much again
when he leaves. Let each sortie begin and end with a straight way from beyond R, for nothing (`_Law.granted`); this
only adds effort. Let m be the integral along all ways of f(r) exp(-E(r)). As E(r) is at no time more than the effort
so far, nor the effort to come, nor E_0 = E(0), effort e costs m >= integral from 0 to e of exp(-min(x, e - x, E_0)) dx;
so a cell is found with POD <= G(m), which is concave:

    G = 1 - (1 - m / 2)^2                                       while 1 - m / 2 >= exp(-E_0)
    G = 1 - exp(-2 E_0 - (m - 2 + 2 exp(-E_0)) exp(E_0))        beyond

Of all cells together m grows by no more than S a metre, the greatest sum over cells of f(r) exp(-E(r)) at any place.

**Prices.** For any prices x of m, y of a cell in view and z of one that the drone comes nearer to than r_0, none
negative and x not asked for the last,

    value <= sum_c max(0, max_m [p_c G_c(m) - x m] - y, p_c - y - z)
             + x (S L + what is granted) + y most_in_view(R) + z most_in_view(r_0)

as the prices paid total at most the last three terms [cf. Koopman1956]. Of many prices the best are kept; each is a
bound. Where strengths differ, m is weighed by 1 or by 1 / k, whichever proves more.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import e, floor, hypot, inf, pi, sqrt

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.bounds.bound import Bound
from sooner.problem import SearchProblem
from sooner.problem.leg_moves import ROUNDING_S, LegMoves
from sooner.sensors.swath import Swath

__all__ = ["leg_bounds", "longest_m", "most_in_view"]

TOUCH_M = 1e-5  # nearer than this to the border of what is in view counts as in view
SLACK = 1.0 + 1e-6  # for turns so slight that drones do not stop at them, and for rounding
CUT = np.linspace(0.0, 0.25, 26)  # of a cell's corners, as shares of its side
PARTS = 24  # of half a cell's side, in which places are taken together
CLOSEST = (0.0, 0.35, 0.6, 0.85)  # sides of a cell that are tried
TRIES = 240  # of prices, at most
TRIED_CELLS = 5e6  # cells whose profit is worked out for them

Floats = NDArray[np.float64]
ASSUMES = "cells count by their centres; any ways through the airspace, no faster than pace and wind allow"


def leg_bounds(problem: SearchProblem) -> Iterator[Bound]:
    """Yield bounds on what any sorties along legs collect, the quickest first; none where nothing is proved.

    The sensor must be the same for all sorties and gains those of effort.

    Examples
    --------
    >>> from sooner.grid import Grid
    >>> from sooner.grid.airspace import Airspace
    >>> from sooner.motion.pace import Pace
    >>> from sooner.problem import Searcher
    >>> from sooner.problem.gains import effort_gains
    >>> grid = Grid((20, 20), cell_m=10.0)
    >>> moves = LegMoves(Airspace.of_cells(np.ones((20, 20), bool), 10.0), Pace(5.0, 2.0), Swath.seen(grid, 15.0), (5, 5))
    >>> poc = np.full((20, 20), 1 / 400)
    >>> [bound] = leg_bounds(SearchProblem(grid, effort_gains(poc), (Searcher((19, 0), 60.0, moves=moves),)))
    >>> bound.proof, round(bound.value, 3)
    ('swept area', 0.348)
    """  # noqa: E501
    ground = _Ground.of(problem)
    if ground is None:
        return
    if len(ground.poc) == 0:
        yield Bound(0.0, "out of reach", ASSUMES)
        return
    if ground.swath.law in ("seen", "edged"):
        yield Bound(ground.richest * SLACK, "swept area", ASSUMES)
        return
    best = inf
    for law in _Law.all(ground):
        found = _least(ground, law)
        if found < best:
            best = found
            yield Bound(best * SLACK, "effort swept", ASSUMES)


@dataclass(frozen=True, eq=False)
class _Ground:
    """What is left of a problem: cells in reach with their POC and strength, metres flown in sight of them, discs in
    view where flights begin, and ways that are granted where they begin and end.
    """

    poc: Floats
    strength: Floats
    swath: Swath
    cell_m: float
    metres: float
    discs: int
    grants: int

    @classmethod
    def of(cls, problem: SearchProblem) -> _Ground | None:
        moves = [each.moves for each in problem.searchers]
        sight = _swath(problem)
        if sight is None:
            return None
        poc = problem.gains.first / -np.expm1(-1.0)
        pays = np.flatnonzero((poc > 0) & (sight.strength > 0))
        found, metres, grants, homes = np.zeros(len(pays), bool), 0.0, 0, set[object]()
        for number, (each, searcher) in enumerate(zip(moves, problem.searchers, strict=True)):
            assert isinstance(each, LegMoves)
            here, before, flown = _in_reach(each, float(searcher.budget), problem.grid.centres_m[pays])
            found |= here
            metres += flown
            if here.any():
                homes.add(each.home if before == 0.0 else number)
                grants += 2
        poc, strength = poc[pays][found], sight.strength[pays][found]
        return cls(poc, strength, sight, float(problem.grid.cell_m), metres, len(homes), grants)

    def in_view(self, radius_m: float) -> float:
        """No more cells than this come nearer than a radius."""
        return most_in_view(radius_m / self.cell_m, self.metres / self.cell_m, self.discs)

    @property
    def richest(self) -> float:
        """What the richest of so many cells hold."""
        most = floor(self.in_view(self.swath.radius_m + TOUCH_M) + 1e-9)
        return float(np.sort(self.poc)[::-1][:most].sum())


def _swath(problem: SearchProblem) -> Swath | None:
    """The sensor of all sorties; None where the proofs do not hold."""
    moves = [each.moves for each in problem.searchers]
    gains = problem.gains
    if problem.drift is not None or problem.objective.target is not None or problem.grid.connectivity == "hex":
        return None
    if gains.table.shape[1] != 1 or not np.allclose(gains.ratio, np.exp(-1.0)):
        return None
    if not all(isinstance(each, LegMoves) for each in moves):
        return None
    sights = [each.swath for each in moves if isinstance(each, LegMoves)]
    first = sights[0]
    for each in sights[1:]:
        if each is not first and (each.law, each.radius_m) != (first.law, first.radius_m):
            return None
        if each is not first and not np.array_equal(each.strength, first.strength):
            return None
    return first


# ------------------------------------------------------------ metres


def longest_m(moves: LegMoves, budget_s: float) -> float:
    """The most metres over the ground that one sortie can fly in so many seconds.

    Examples
    --------
    >>> from sooner.grid import Grid
    >>> from sooner.grid.airspace import Airspace
    >>> from sooner.motion.pace import Pace
    >>> space, sight = Airspace(shapely.box(0, 0, 3000, 4000)), Swath.seen(Grid((1, 1)), 1.0)
    >>> straight = longest_m(LegMoves(space, Pace(10.0, 2.0), sight, (9.0, 9.0)), 100.0)
    >>> and_back = longest_m(LegMoves(space, Pace(10.0, 2.0), sight, (9.0, 9.0), (9.0, 9.0)), 100.0)
    >>> round(straight, 2), round(and_back, 2)
    (950.0, 900.0)
    """
    pace, seconds = moves.pace, budget_s + ROUNDING_S
    wind = hypot(*pace.wind)
    fastest = pace.speed_mps if pace.airspeed_mps is None else min(pace.speed_mps, pace.airspeed_mps + wind)
    west, south, east, north = moves.airspace.free.bounds
    extent = hypot(east - west, north - south)
    returns = moves.end == moves.home
    straight = 2 * _dash(seconds / 2, fastest, pace.accel_mps2) if returns else _dash(seconds, fastest, pace.accel_mps2)
    found = min(straight, seconds * extent / _dash_s(extent, fastest, pace.accel_mps2))
    if moves.end is not None and pace.airspeed_mps is not None:
        spare = pace.airspeed_mps**2 - wind**2
        carried = np.dot(pace.wind, np.subtract(moves.end, moves.home)) / spare
        found = min(found, sqrt(spare) * (seconds + float(carried)))
    return max(found, 0.0) * SLACK


def _dash(seconds: float, speed: float, accel: float) -> float:
    """Metres from rest to rest."""
    if seconds * accel >= 2 * speed:
        return speed * seconds - speed**2 / accel
    return accel * seconds**2 / 4


def _dash_s(metres: float, speed: float, accel: float) -> float:
    """Seconds from rest to rest, t(l)."""
    return metres / speed + speed / accel if metres * accel >= speed**2 else 2 * sqrt(metres / accel)


def _in_reach(moves: LegMoves, budget_s: float, centres: Floats) -> tuple[NDArray[np.bool_], float, float]:
    """Cells that one sortie can bring into view, metres before the first, and metres flown in sight of any."""
    most, radius = longest_m(moves, budget_s), moves.swath.radius_m + TOUCH_M
    there = np.maximum(np.hypot(*(centres - moves.home).T) - radius, 0.0)
    back = np.zeros(len(centres)) if moves.end is None else np.hypot(*(centres - moves.end).T) - radius
    back = np.maximum(back, 0.0)
    here = there + back <= most
    part = _part(moves)
    shapely.prepare(part)
    here[here] = shapely.dwithin(part, shapely.points(centres[here]), radius)
    if not here.any():
        return here, 0.0, 0.0
    before = float(there[here].min())
    return here, before, max(most - before - float(back[here].min()), 0.0)


def _part(moves: LegMoves) -> shapely.Geometry:
    """The part of the airspace that home lies in, with those that it touches."""
    parts = shapely.get_parts(moves.airspace.free)
    joined = shapely.intersects(parts, shapely.Point(moves.home))
    while True:
        part = shapely.union_all(parts[joined])
        touched = joined | shapely.intersects(parts, part)
        if (touched == joined).all():
            return part
        joined = touched


# ------------------------------------------------------------ cells in view


def most_in_view(radius: float, length: float, discs: int = 1) -> float:
    """No more cells than this have their centres within a radius of ways; lengths in cells.

    Examples
    --------
    >>> round(most_in_view(1.2, 100.0), 1), round(most_in_view(10.0, 100.0), 1)
    (385.6, 2495.3)
    """
    area = 1.0 - 2.0 * CUT**2
    border = 4.0 * (1.0 - 2.0 * CUT) + 4.0 * sqrt(2.0) * CUT
    width = 2.0 * np.hypot(0.5, 0.5 - CUT)
    begins = pi * radius**2 + border * radius + area
    return float(((discs * begins + (2.0 * radius + width) * length) / area).min())


# ------------------------------------------------------------ effort


@dataclass(frozen=True, eq=False)
class _Law:
    """Effort a metre k g(r), and k q(r) of it on the way from R to r; strengths k, weighed by 1 or by 1 / k.

    Cells that the drone comes nearer to than `closest`, r_0, pay z for all that they are worth, and no x; so they do
    not count in S. Plain is who forgets that drones come from afar: E = 0, m is effort, G = 1 - exp(-m); it proves more
    of weak sensors. Cells of the inverse cube that are hard to see count as somewhat easier, as S would otherwise be
    theirs alone.
    """

    cube: bool
    radius: float
    strength: Floats
    weighed: bool
    plain: bool = False
    closest: float = 0.0

    @classmethod
    def all(cls, ground: _Ground) -> Iterator[_Law]:
        """Every way to weigh and count that may prove something."""
        even = ground.swath.law == "even"
        for weighed in (True, False) if np.ptp(ground.strength) > 0 else (False,):
            if even:
                yield from (cls.of(ground, weighed, plain) for plain in (True, False))
            else:
                yield from (cls.of(ground, weighed, closest=share * ground.cell_m) for share in CLOSEST)

    @classmethod
    def of(cls, ground: _Ground, weighed: bool, plain: bool = False, closest: float = 0.0) -> _Law:
        if ground.swath.law == "even":
            return cls(False, ground.swath.radius_m, ground.strength, weighed, plain)
        strength = np.maximum(ground.strength, ground.strength.max() / 4) ** 2 / (8 * pi)
        return cls(True, ground.swath.radius_m, strength, weighed, closest=closest)

    @property
    def extremes(self) -> tuple[float, float]:
        return float(self.strength.min()), float(self.strength.max())

    @property
    def weight(self) -> Floats:
        return 1.0 / self.strength if self.weighed else np.ones(len(self.strength))

    def q(self, r: Floats) -> Floats:
        if not self.cube:
            return np.maximum(self.radius - r, 0.0) * (not self.plain)
        with np.errstate(divide="ignore"):
            found: Floats = np.clip((r**-2.0 - self.radius**-2.0) / 2, 0.0, 1e300)
        return found

    def most(self, near: Floats, far: Floats) -> Floats:
        """No more than this is weight k g exp(-k q) of any strength anywhere between two distances."""
        low, high = self.extremes
        q = self.q(np.minimum(far, self.radius))
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            best = np.full_like(q, low) if self.weighed else np.clip(1 / q, low, high)
            found = np.exp(-best * q) * (1.0 if self.weighed else best)
            if self.cube:  # k exp(-k / 2 r^2) / r^3 is most where r^2 = k / 3
                peak = (3 / e) ** 1.5 * np.exp(high / self.radius**2 / 2) / low**0.5
                found = np.minimum(np.nan_to_num(found * near**-3.0, nan=0.0), peak / (low if self.weighed else 1.0))
        return np.where((near <= self.radius) & (far >= self.closest), found, 0.0)

    def granted(self, r: Floats) -> Floats:
        """No more than this is weight (1 - exp(-k q)) of any strength at a distance."""
        low, high = self.extremes
        return -np.expm1(-low * self.q(r)) / low if self.weighed else -np.expm1(-high * self.q(r))


def _sums(law: _Law, cell_m: float) -> tuple[float, float]:
    """S, and the most that is granted at once: sums over centres of cells around any place.

    The place lies in one of many small squares; of each centre the distances from there bound the summand.
    """
    reach = int(law.radius / cell_m) + 2
    parts = PARTS if reach <= 12 else PARTS // 3 if reach <= 60 else 2
    side = 0.5 / parts  # places in a quarter of a cell stand for all
    steps = np.abs(np.arange(-reach, reach + 1)[:, None] - (np.arange(parts) + 0.5) * side)
    nearest, farthest = np.maximum(steps - side / 2, 0.0) * cell_m, (steps + side / 2) * cell_m  # (n, parts)
    rate = granted = 0.0
    for k in range(parts):
        near = np.hypot(nearest[:, None, [k]], nearest[None])
        far = np.hypot(farthest[:, None, [k]], farthest[None])
        rate = max(rate, float(law.most(near, far).sum(axis=(0, 1)).max()))
        granted = max(granted, float(law.granted(near).sum(axis=(0, 1)).max()))
    return rate, granted


def _least(ground: _Ground, law: _Law) -> float:
    """The least of the bound over prices, as far as it is found."""
    from scipy.optimize import minimize

    rate, granted = _sums(law, ground.cell_m)
    supply = rate * ground.metres + granted * ground.grants
    cells, poc, weight = ground.in_view(ground.swath.radius_m + TOUCH_M), ground.poc, law.weight
    closer = ground.in_view(law.closest)
    whole = np.minimum(law.strength * float(law.q(np.zeros(1))[0]), 600.0)

    def bound(prices: Floats) -> float:
        x, y, *z = np.exp(np.clip(prices, -60.0, 20.0))
        pays = _profit(poc, whole, x * weight)
        for each in z:
            pays = np.maximum(pays, poc - each)
        return float(np.maximum(pays - y, 0.0).sum() + x * supply + y * cells + sum(z) * closer)

    typical = float(np.median(poc / weight))
    z = [float(np.median(poc))] if law.closest else []
    tried = [np.log([typical * share, float(np.median(poc)) * 1e-3, *z]) for share in (1e-3, 0.01, 0.1, 0.3, 1.0, 3.0)]
    start, tries = min(tried, key=bound), int(np.clip(TRIED_CELLS / len(poc), 24, TRIES))
    found = minimize(bound, start, method="Nelder-Mead", options={"maxfev": tries, "xatol": 1e-3, "fatol": 1e-7})
    return min(float(found.fun), bound(start), float(poc.sum()))


def _profit(poc: Floats, whole: Floats, price: Floats) -> Floats:
    """max over m >= 0 of p G(m) - x m; `whole` is E_0."""
    share = np.minimum(price / poc, 1.0)
    once = poc * (1.0 - share) ** 2
    effort = np.log(np.maximum(1.0 / share, 1.0)) + whole
    m = 2.0 * -np.expm1(-whole) + (effort - 2.0 * whole) * np.exp(-whole)
    often = poc * -np.expm1(-effort) - price * m
    return np.where(share >= np.exp(-whole), once, often)
