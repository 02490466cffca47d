"""Exact: the best plan over regions by integer programming, and the proof that there is none better."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from threading import Thread
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sooner.bounds.region_lp import ASSUMES, PROOF, Levels, RegionLP
from sooner.bounds.region_network import RegionNetwork
from sooner.planners.planner import Part, Planner, Ticks
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.region_walk import walk_of
from sooner.problem import Incumbent, Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround, single_region_searcher

__all__ = ["Exact"]

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

MARGIN = 1e-6  # of a bound: dual tolerances of 1e-7 over ten thousand columns of a program worth ten thousand, tenfold
WORTH = 1e4  # of the best known plan in the program's unit
HEARTBEAT_S = 0.05
SPARE_S = 1e-4  # left unused where the solver's tolerance has let a plan take a little too long


@dataclass(frozen=True)
class Exact:
    """Prove the optimum: for up to some 25 regions in a minute, for more as near as time allows.

    What a plan collects does not depend on the order of its actions. So the integer program asks how often each is
    flown: n_a whole, sum of n_a w_a <= T, every atom worth its concave gains of as many looks as its actions make. One
    walk can fly these numbers if and only if they are connected and every region has an even number of flights to and
    from it, but for the two ends (Euler 1736): with t_r = 1 where the walk ends and 0 elsewhere,

        sum of n_e over the edges at r + [r is the first] + t_r = 2 d_r,   d_r whole,   sum of t_r = 1.

    Connected they mostly are, since edges pay. Where a set S of regions comes out apart, its regions receive binary
    visits v_r, with n_a <= N_a v_r for all that touches r, and the cut: edges that leave S + t(S) >= 2 v_r. What hangs
    together with the start is a plan meanwhile. Atoms have windows of gain levels around the best plan, continued
    upwards beyond both ends (`sooner.bounds.region_lp.Levels`), so that every program is a relaxation.

    Annealing comes first, and the linear program's bound. Solver runs have time limits that double, and fit what is
    left where the stop rule says so; a run cannot be broken off sooner, so that closing waits for its end. Where the
    stop rule tells no share, the same work is done without heartbeats.

    The bound is HiGHS's own dual bound plus `MARGIN`, a millionth of it; or the linear program's, where that is
    smaller.

    Parameters
    ----------
    inner : Planner        what gives the first plan: annealing
    gap : float            share of the value at which the solver may stop
    share : float          of the run that the inner planner has
    ticks : int            that it has, where nobody knows how long the run is
    width : int            gain levels on each side of the best plan's looks
    first_s : float        time limit of the first run of the solver
    """

    inner: Planner = RegionAnneal()
    gap: float = 1e-5
    share: float = 0.1
    ticks: int = 60
    width: int = 2
    first_s: float = 5.0

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over regions."""
        return single_region_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield annealed plans, then the linear program's bounds, then those of the integer program."""
        run = _Run(problem, RegionNetwork.of(problem))
        part = Part(0.0, self.share, self.ticks)
        share, _ = yield from part.run(self.inner, problem, rng, 0.0, run.take)
        for value, counts in RegionLP().solutions(run.network):
            run.proved(value, PROOF)
            run.relaxed = counts
            share = yield run.best
        program = run.program(self.width)
        limit, done = self.first_s, run.best.gap <= 0.0
        while not done:
            solving = _Solving(program, self.gap, run.fitted(limit, share))
            while share is not None and solving.going_on:
                share = yield run.best
            done, program = run.learned(program, solving.found())
            limit *= 2.0
            share = yield run.best


@dataclass(eq=False)
class _Run:
    """The best plan and bound so far."""

    problem: SearchProblem
    network: RegionNetwork
    best: Incumbent = field(init=False)
    relaxed: Floats = field(init=False)
    began: float = field(default_factory=time.monotonic)

    def take(self, incumbent: Incumbent) -> Incumbent:
        """Keep the first plan, then better ones."""
        if not hasattr(self, "best"):
            self.best = incumbent
        elif incumbent.value > self.best.value:
            self.best = replace(self.best, plan=incumbent.plan, value=incumbent.value)
        return self.best

    def proved(self, bound: float, proof: str) -> None:
        """Keep the smaller bound."""
        if bound < self.best.bound:
            self.best = replace(self.best, bound=bound, bound_proof=proof, bound_assumes=ASSUMES)

    def fitted(self, limit: float, share: float | None) -> float:
        """Seconds for a run of the solver: all that is left where that is not much more than the limit."""
        if share is None or share <= 0.0:
            return limit
        left = max((time.monotonic() - self.began) * (1.0 - share) / share, 0.01)
        return left if left < 2.5 * limit else limit

    def program(self, width: int) -> _Program:
        """The first integer program: windows around the best plan that also hold the linear program's looks."""
        ground = self.network.ground
        counts = np.bincount(self.best.plan.actions[0], minlength=ground.n_actions)
        levels = Levels.around(self.network, self.network.looks(counts), width)
        return _Program(self.network, levels.widened(self.network.looks(self.relaxed)) or levels, (), self.best.value)

    def learned(self, program: _Program, found: Any) -> tuple[bool, _Program]:
        """Take what the solver found; answers whether that is the end, and else the next program."""
        if found.status not in (0, 1):  # neither solved nor out of time: the solver has given up
            return True, program
        if found.mip_dual_bound is not None and np.isfinite(found.mip_dual_bound) and not program.spare_s:
            bound = program.value(found.mip_dual_bound)
            self.proved(bound + MARGIN * abs(bound), "integer program over regions")
        if found.x is None:
            return False, program
        counts, end = program.numbers(found.x)
        whole = self._flown(counts, end)
        wider = program.levels.widened(self.network.looks(counts))
        apart = _apart(self.network.ground, counts)
        if not whole:
            return False, replace(program, spare_s=SPARE_S)
        if wider is None and not apart:
            return found.status == 0, program
        return False, replace(program, levels=wider or program.levels, apart=(*program.apart, *apart))

    def _flown(self, counts: Whole, end: int) -> bool:
        """Judge what hangs together with the start as a plan; answers whether it was legal."""
        ground = self.network.ground
        kept = counts.copy()
        for inside in _apart(ground, counts):
            kept[inside[ground.ends[:, 0]]] = 0
        walk = walk_of(ground, kept.astype(np.int32), end)
        if not walk:
            return True
        plan = Plan.of(walk)
        moves, searcher = self.problem.searcher.moves, self.problem.searcher
        if moves.fault(self.problem.grid, searcher, plan.actions[0]) is not None:
            return False
        self.take(Incumbent(plan, evaluate(self.problem, plan).value))
        return True


def _apart(ground: RegionGround, counts: Whole) -> list[NDArray[np.bool_]]:
    """Sets of regions, (R,) bool, in which something is flown and to which nobody comes from the start."""
    flown = np.flatnonzero(counts)
    one, other = ground.ends[flown].T
    graph = coo_array((np.ones(len(flown)), (one, other)), shape=(ground.n_regions, ground.n_regions))
    _, labels = connected_components(graph, directed=False)
    return [labels == label for label in np.unique(labels[one]) if label != labels[ground.first]]


@dataclass(frozen=True, eq=False)
class _Program:
    """The integer program: columns n (A), v (R), t (R), d (R), z; v is free but for regions of sets that came apart.

    Parameters
    ----------
    network : RegionNetwork
    levels : Levels
    apart : of (R,) bool      sets of regions with cuts
    known : float             value of a plan, which sets the unit
    spare_s : float           time that is left unused; such a program bounds nothing
    """

    network: RegionNetwork
    levels: Levels
    apart: tuple[NDArray[np.bool_], ...]
    known: float
    spare_s: float = 0.0

    @property
    def unit(self) -> float:
        """Of the program's objective."""
        return max(self.known, float(self.levels.gains.max()), 1e-300) / WORTH

    def value(self, objective: float) -> float:
        """The value that an objective of the program, which is minimised, stands for."""
        return -objective * self.unit + self.levels.base + self.network.ground.leg_value

    def numbers(self, x: Floats) -> tuple[Whole, int]:
        """How often each action is flown, and where the walk ends."""
        ground = self.network.ground
        ends = slice(ground.n_actions + ground.n_regions, ground.n_actions + 2 * ground.n_regions)
        return np.round(x[: ground.n_actions]).astype(np.int64), int(np.argmax(x[ends]))

    def solved(self, gap: float, limit: float) -> Any:
        """HiGHS's answer."""
        network, levels, ground = self.network, self.levels, self.network.ground
        n_actions, n_regions = ground.n_actions, ground.n_regions
        last = np.ones(n_regions) if ground.last < 0 else np.eye(n_regions)[ground.last]
        most = np.concatenate([network.most, np.ones(n_regions), last, np.full(n_regions, np.inf), levels.most])
        least = np.concatenate([np.zeros(n_actions + 3 * n_regions), levels.least])
        whole = np.zeros(len(most))
        whole[: n_actions + 3 * n_regions] = 1
        cost = np.zeros(len(most))
        cost[n_actions + 3 * n_regions :] = -levels.paid / self.unit
        options = {"time_limit": limit, "mip_rel_gap": gap}
        return milp(cost, integrality=whole, bounds=Bounds(least, most), constraints=self._rows(), options=options)

    def _rows(self) -> LinearConstraint:
        """Looks, seconds, parity, one end, visits and cuts."""
        ground = self.network.ground
        n_actions, n_regions = ground.n_actions, ground.n_regions
        rows = _Rows(n_actions + 3 * n_regions + len(self.levels.atoms))
        t, d = n_actions + n_regions, n_actions + 2 * n_regions
        self._look_rows(rows, d + n_regions)
        limit = self.network.limit_s - self.spare_s
        rows.add([(0, action, w) for action, w in enumerate(ground.seconds)], [-np.inf], [limit])
        ends = ground.ends[n_regions:]
        parity = [(int(region), n_regions + e, 1.0) for e, pair in enumerate(ends) for region in pair]
        parity += [(r, column + r, value) for r in range(n_regions) for column, value in ((t, 1.0), (d, -2.0))]
        first = -1.0 * (np.arange(n_regions) == ground.first)
        rows.add(parity, first, first)
        rows.add([(0, t + r, 1.0) for r in range(n_regions)], [1.0], [1.0])
        for region in np.flatnonzero(np.any(self.apart, axis=0)) if self.apart else ():
            touching = np.flatnonzero((ground.ends == region).any(axis=1) & (self.network.most > 0))
            room = [(i, n_actions + region, -float(self.network.most[a])) for i, a in enumerate(touching)]
            rows.add([(i, a, 1.0) for i, a in enumerate(touching)] + room, *_up_to_zero(len(touching)))
        for inside in self.apart:
            crossing = np.flatnonzero(inside[ground.ends[:, 0]] != inside[ground.ends[:, 1]])
            members = np.flatnonzero(inside)
            into = [(i, column, -1.0) for i in range(len(members)) for column in (*crossing, *(t + members))]
            visits = [(i, n_actions + r, 2.0) for i, r in enumerate(members)]
            rows.add(into + visits, *_up_to_zero(len(members)))
        return rows.constraint()

    def _look_rows(self, rows: _Rows, z: int) -> None:
        ground, atoms = self.network.ground, self.levels.atoms
        entries = [(atom, z + column, 1.0) for column, atom in enumerate(atoms.tolist())]
        entries += [(a, b, -1.0) for a, b in zip(ground.atoms.tolist(), self.network.actions.tolist(), strict=True)]
        low = self.levels.lo.astype(np.float64)
        rows.add(entries, np.full(len(low), -np.inf), -low)


class _Rows:
    """Rows of a constraint matrix, block by block."""

    def __init__(self, n_columns: int) -> None:
        self.n_columns, self.count = n_columns, 0
        self.entries: list[NDArray[np.float64]] = []
        self.least: list[Any] = []
        self.most: list[Any] = []

    def add(self, entries: list[tuple[Any, Any, float]], least: Any, most: Any) -> None:
        """A block of rows: (row within the block, column, value), and what lies below and above each row."""
        block = np.array(entries, np.float64).reshape(-1, 3)
        block[:, 0] += self.count
        self.entries.append(block)
        self.least.append(least)
        self.most.append(most)
        self.count += len(most)

    def constraint(self) -> LinearConstraint:
        """All of them."""
        where, columns, values = np.concatenate(self.entries).T
        places = (where.astype(np.int32), columns.astype(np.int32))
        matrix = coo_array((values, places), shape=(self.count, self.n_columns)).tocsr()
        return LinearConstraint(matrix, np.concatenate(self.least), np.concatenate(self.most))


def _up_to_zero(count: int) -> tuple[Floats, Floats]:
    return np.full(count, -np.inf), np.zeros(count)


class _Solving:
    """A run of the solver on a thread of its own, which HiGHS lets the others run beside."""

    def __init__(self, program: _Program, gap: float, limit: float) -> None:
        self._found: Any = None
        self._error: BaseException | None = None
        self._thread = Thread(target=self._run, args=(program, gap, limit), name="exact")
        self._thread.start()

    @property
    def going_on(self) -> bool:
        """Whether it still runs after a heartbeat's wait."""
        self._thread.join(HEARTBEAT_S)
        return self._thread.is_alive()

    def found(self) -> Any:
        """The solver's answer, once there is one."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._found

    def _run(self, program: _Program, gap: float, limit: float) -> None:
        try:
            self._found = program.solved(gap, limit)
        except BaseException as error:  # carried over to the planner's thread
            self._error = error
