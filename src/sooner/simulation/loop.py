"""The closed loop: look, believe, detect, plan, and fly for a second, until the time is up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.simulation.agents import STEP_S
from sooner.simulation.episode import Beliefs, Call, Episode, Looks
from sooner.simulation.scene import Scene
from sooner.simulation.sensing import LookLog
from sooner.simulation.strategies.strategy import Routes, Situation, Strategy
from sooner.simulation.world import Purpose, Truth, generator, noise_seed

__all__ = ["Keep", "simulate"]


@dataclass(frozen=True)
class Keep:
    """What an episode keeps besides what its score needs: all looks, and beliefs every so many seconds (0: never)."""

    looks: bool = False
    beliefs_s: int = 0


def simulate(scene: Scene, strategy: Strategy, seed: int, keep: Keep = Keep()) -> Episode:
    """Fly one search.

    Each second: all agents look at all cells in view; Bayes' law; nodes are detected; the target is tracked and
    perhaps called; at a replan the strategy is asked; the target moves while agents fly on    [Wolek2020, section IV].
    What the world holds and what a sensor reads at a place and second depends on the seed alone, not on the strategy.

    Examples
    --------
    >>> from sooner.grid import Grid
    >>> from sooner.simulation import World
    >>> from sooner.simulation.strategies import Lawnmower
    >>> from sooner.streets import OccupancyGraph
    >>> street = [(row, 10) for row in range(20)]
    >>> grid = Grid((20, 20), "square8", 5.0)
    >>> graph = OccupancyGraph.of(grid, [grid.index(cell) for cell in street], [(n, n + 1) for n in range(19)])
    >>> flown = simulate(Scene(World(graph), seconds=120), Lawnmower(), seed=1)
    >>> bool(flown.nodes_curve[-1] > 0.9)
    True
    """
    return _Flight(scene, strategy, seed, keep).flown()


@dataclass(eq=False)
class _Flight:
    """One search while it is flown."""

    scene: Scene
    strategy: Strategy
    seed: int
    keep: Keep
    sums: list[float] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)
    plans: list[Routes] = field(default_factory=list)
    snapshots: list[tuple[int, NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]] = field(
        default_factory=list
    )

    def __post_init__(self) -> None:
        scene = self.scene
        self.truth: Truth = scene.world.truth(self.seed, scene.seconds)
        self.noise = noise_seed(self.seed)
        self.log = LookLog(scene.sensing.most_looks, self.keep.looks)
        self.belief = scene.estimator.begun(scene.world, scene.sensing.most_looks)
        self.places = scene.starts(self.strategy, self.seed)
        self.velocities = np.zeros_like(self.places)
        self.track = np.empty((scene.seconds + 1, *self.places.shape))
        self.routes = _PackedRoutes(len(scene.agents))
        self.above = False

    def flown(self) -> Episode:
        scene, team = self.scene, self.scene.team
        v_max, a_max, capture = team.v_max, team.a_max, self.strategy.capture * team.radius_m
        rng = generator(self.seed, Purpose.STRATEGY)
        session, watch = None, None
        from sooner.simulation._flight_kernels import fly

        for second in range(scene.seconds):
            self.track[second] = self.places
            self._look(second)
            if second % scene.replan_s == 0:
                self.belief.predict()
                situation = self._situation(second)
                if session is None:
                    session = self.strategy.session(situation, rng)
                    watch = getattr(session, "watch", None)
                self._watched_by(watch)
                self.routes.take(session.routes(situation), situation.routes)
                self.plans.append(self.routes.left)
            else:
                self._watched_by(watch)
            self._snapshot(second)
            self.truth.move(second, self.places)
            routes = self.routes
            fly(
                self.places, self.velocities, v_max, a_max, capture, routes.waypoints, routes.lengths, routes.reached,
                1.0, STEP_S,
            )  # fmt: skip
        self.track[scene.seconds] = self.places
        return self._episode()

    def _look(self, second: int) -> None:
        scene = self.scene
        targets = scene.target_cells[self.truth.nodes_at(second)]
        scene.sensing.look(second, self.places, scene.world.nodes, targets, self.noise, self.log)
        total, cell = self.belief.see(second, self.log)
        self.sums.append(total)
        above = total >= scene.estimator.odds
        if above and (not self.above or scene.estimator.detector == "cbht"):
            self.calls.append(Call(second, cell, self._target_near(second, cell)))
        self.above = above

    def _watched_by(self, watch: Callable[[NDArray[np.int32], NDArray[np.float64]], None] | None) -> None:
        """A session that keeps a belief of its own is shown this second's looks for a target."""
        if watch is not None:
            now = slice(self.log.start, self.log.end)
            watch(self.log.cells[now], self.log.target_ratios[now])

    def _target_near(self, second: int, cell: int) -> int:
        """The nearest target within the largest radius of view of a cell's centre, -1 if there is none."""
        apart = self.truth.places_at(second) - self.scene.grid.centres_m[cell]
        if not len(apart):
            return -1
        metres = np.hypot(apart[:, 0], apart[:, 1])
        nearest = int(metres.argmin())
        return nearest if metres[nearest] <= self.scene.sensing.radius_m.max() else -1

    def _situation(self, second: int) -> Situation:
        scene = self.scene
        return Situation(
            grid=scene.grid,
            agents=scene.agents,
            now_s=float(second),
            end_s=float(scene.seconds),
            replan_s=float(scene.replan_s),
            places_m=self.places,
            velocities_mps=self.velocities,
            routes=self.routes.left,
            states=self.belief.states,
            detected_target=bool(self.calls),
            graph=scene.world.graph,
        )

    def _snapshot(self, second: int) -> None:
        if self.keep.beliefs_s and second % self.keep.beliefs_s == 0:
            self.belief.settle()
            states = self.belief.states
            self.snapshots.append((second, states.void.copy(), states.occupied.copy(), states.explored.copy()))

    def _episode(self) -> Episode:
        return Episode(
            scene=self.scene,
            strategy=self.strategy,
            seed=self.seed,
            targets=self.scene.world.states.current[self.truth.path],
            places_m=self.track,
            node_seconds=self.belief.node_seconds,
            sums=np.array(self.sums),
            calls=tuple(self.calls),
            plans=tuple(self.plans),
            looks=self._looks() if self.keep.looks else None,
            beliefs=self._beliefs() if self.snapshots else None,
        )

    def _looks(self) -> Looks:
        log, end = self.log, self.log.end
        return Looks(
            firsts=np.array([*log.firsts, end], np.int64),
            cells=log.cells[:end].copy(),
            agents=log.agents[:end].copy(),
            map_levels=log.map_levels[:end].copy(),
            target_levels=log.target_levels[:end].copy(),
        )

    def _beliefs(self) -> Beliefs:
        seconds, void, occupied, explored = zip(*self.snapshots, strict=True)
        return Beliefs(np.array(seconds, np.int64), np.array(void), np.array(occupied), np.array(explored))


class _PackedRoutes:
    """Routes of all agents in one array, as the kernel that flies them takes them."""

    def __init__(self, n_agents: int) -> None:
        self.waypoints = np.zeros((n_agents, 1, 2))
        self.lengths = np.zeros(n_agents, np.int64)
        self.reached = np.zeros(n_agents, np.int64)

    @property
    def left(self) -> Routes:
        """Waypoints not reached yet, by agent; an agent that has reached all keeps its last."""
        return tuple(
            self.waypoints[agent, max(min(reached, length - 1), 0) : length].copy()
            for agent, (reached, length) in enumerate(zip(self.reached.tolist(), self.lengths.tolist(), strict=True))
        )

    def take(self, routes: Routes, before: Routes) -> None:
        """Fly these from now on; the very tuple of `before` changes nothing."""
        if routes is before:
            return
        if len(routes) != len(self.lengths):
            raise InvalidProblemError(f"routes for {len(routes)} agents came; the team has {len(self.lengths)}")
        longest = max(max(len(route) for route in routes), 1)
        self.waypoints = np.zeros((len(routes), longest, 2))
        self.lengths = np.array([len(route) for route in routes], np.int64)
        self.reached = np.zeros(len(routes), np.int64)
        for agent, route in enumerate(routes):
            self.waypoints[agent, : len(route)] = route
        if not np.isfinite(self.waypoints).all():
            raise InvalidProblemError("a waypoint that is not a number came; expected metres east and north")
