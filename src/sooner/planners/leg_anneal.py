"""Simulated annealing of routes of straight legs: the default planner of sorties.

Routes are changed a few points at a time: a point or a whole lane is shifted, points are put in where much is left to
find and taken out where little is, stretches are turned round or handed from one sortie to another. Time is that of the
flown legs, and no change is made that would come home late or meet a wall (Metropolis et al. 1953; Kirkpatrick, Gelatt
and Vecchi 1983). First routes come from lanes and lattices, as annealing alone seldom finds its way to lanes.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from sooner.planners import _leg_kernels as kernels
from sooner.planners.leg_ground import LegGround, Route, Routes, leg_searchers
from sooner.planners.leg_seeds import first_routes
from sooner.planners.planner import Ticks
from sooner.planners.rounds import Rounds
from sooner.problem import Incumbent, Plan, SearchProblem, evaluate

__all__ = ["LegAnneal"]


@dataclass(frozen=True)
class LegAnneal:
    """Anneal the routes of all sorties together: several sets of them at first, then the better half, and so forth.

    Temperatures are shares of what a point of the first routes collects on average.

    Parameters
    ----------
    starts : int                sets of routes at first, the best of the first ones
    halvings : ((share, n))     from this share of a round on, only the best n sets go on
    hot, cold : float           temperature at the beginning and the end of a round
    price : float               of a second, as a share of what a second collects on average
    reach : (float, float)      metres by which points are shifted, in sensor radii, at first and at last
    mix : (8,) floats           shares of the changes: shift a point, shift a lane, insert, remove, insert and remove,
                                reverse, move a stretch, exchange tails
    coarse : float              share of a round that is annealed over coarser cells
    moves : int                 changes of each thread between two yields
    patience : int              ticks after which a run starts again from the best
    threads : int               sets of routes annealed at the same time
    """

    starts: int = 4
    halvings: tuple[tuple[float, int], ...] = ((0.15, 2),)
    hot: float = 0.05
    cold: float = 0.003
    price: float = 0.2
    reach: tuple[float, float] = (1.5, 0.3)
    mix: tuple[float, ...] = (0.3, 0.2, 0.15, 0.05, 0.1, 0.05, 0.1, 0.05)
    coarse: float = 0.6
    moves: int = 4_000
    patience: int = 400
    threads: int = 2

    def handles(self, problem: SearchProblem) -> str | None:
        """Sorties along legs, any number of them."""
        return leg_searchers(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the way home at once, then first routes, then anneal for as long as somebody asks."""
        ground = LegGround(problem)
        best = _Best(ground, [ground.least(number) for number in range(len(ground.moves))])
        share = yield best.incumbent
        if not ground.within_reach.any():
            return
        starts = []
        for routes in first_routes(ground, rng):
            starts.append(Routes(ground, routes, ground.coarse))
            best.offer(starts[-1])
            share = yield best.incumbent
        rounds = Rounds(self.patience)
        with ThreadPoolExecutor(self.threads) as pool:
            while True:
                rounds = rounds.begun(share)
                starts.sort(key=lambda each: each.best_value, reverse=True)
                chains = [_Chain(self, ground, each.best, rng) for each in starts[: self.starts]]
                while (now := rounds.now(share)) < 1.0:
                    self._halve(chains, now)
                    self._anneal(chains, now, pool)
                    for chain in chains:
                        best.offer(chain.routes)
                    share = yield best.incumbent
                    rounds.tick += 1
                kept = (best.routes, *(chain.routes.best for chain in chains))
                starts = [Routes(ground, each, ground.coarse) for each in kept]

    def _halve(self, chains: list[_Chain], now: float) -> None:
        """Let the better sets of routes go on."""
        keep = min((max(n, self.threads) for share, n in self.halvings if now >= share), default=len(chains))
        if keep < len(chains):
            chains.sort(key=lambda chain: chain.routes.best_value, reverse=True)
            del chains[keep:]

    def _anneal(self, chains: list[_Chain], now: float, pool: ThreadPoolExecutor) -> None:
        """One tick: every thread makes the same number of changes, shared among its sets of routes."""

        def run(own: list[_Chain]) -> None:
            for chain in own:
                chain.run(now, self.moves // len(own))

        list(pool.map(run, [own for k in range(self.threads) if (own := chains[k :: self.threads])]))


class _Best:
    """The best routes so far, by the judge's word."""

    def __init__(self, ground: LegGround, routes: list[Route]) -> None:
        self.ground, self.routes = ground, routes
        plan = ground.plan(routes)
        self.incumbent = Incumbent(plan, evaluate(ground.problem, plan).value)

    def offer(self, routes: Routes) -> None:
        """Ask the judge where routes seem better than those of the same set before."""
        if routes.best_value <= routes.told * (1 + 1e-9):
            return
        routes.told = routes.best_value
        plan: Plan = self.ground.plan(routes.best)
        value = evaluate(self.ground.problem, plan).value
        if value > self.incumbent.value:
            self.incumbent, self.routes = Incumbent(plan, value), routes.best


class _Chain:
    """One set of routes, annealed on one thread."""

    def __init__(self, settings: LegAnneal, ground: LegGround, routes: list[Route], rng: Generator) -> None:
        self.settings, self.ground = settings, ground
        self.words = rng.integers(1, 2**32, 2)
        self.routes = Routes(ground, routes, ground.coarse)
        points = max(int(self.routes.counts.sum()), 1)
        value = max(self.routes.value, float(ground.poc.max()))
        self.unit = value / points
        self.price = settings.price * value / max(float(self.routes.seconds.sum()), 1.0)
        self.weights = np.cumsum(settings.mix)

    def run(self, now: float, moves: int) -> None:
        """So many changes, so far into the round."""
        settings, ground = self.settings, self.ground
        if now >= settings.coarse and self.routes.level is not ground.fine:
            self.routes = Routes(ground, self.routes.best, ground.fine)
        routes, level = self.routes, self.routes.level
        hot, cold = settings.hot * self.unit, settings.cold * self.unit
        first, last = settings.reach
        reach = ground.moves[0].swath.radius_m * first * (last / first) ** now
        routes.value = routes.load()
        routes.value, routes.best_value = kernels.anneal(
            routes.points, routes.counts, routes.seconds, routes.effort, routes.value,
            routes.best_points, routes.best_counts, routes.best_value,
            ground.budgets, ground.ends, level.pays, moves, hot * (cold / hot) ** now,
            self.price * (1.0 - now), reach, self.weights, self.words,
            level.poc, level.ground, level.sight, ground.paces, ground.walls,
        )  # fmt: skip
