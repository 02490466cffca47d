"""The world while a search is flown: where targets and agents are, and what agents read. It believes nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.simulation.agents import STEP_S
from sooner.simulation.episode import Looks
from sooner.simulation.scene import Scene
from sooner.simulation.sensing import LookLog
from sooner.simulation.strategies.strategy import Routes
from sooner.simulation.world import Truth, noise_seed

__all__ = ["Flight", "left_of"]


class Flight:
    """One search while it is flown: `look`, then `go_on` for a second, until it is `over`.

    Parameters
    ----------
    scene : Scene
    seed : int              settles where targets walk and what sensors read at each place and second, whatever flies
    starts_m : (A, 2)       where agents start
    capture : float         share of its radius of view within which an agent takes a waypoint for reached, in flight
    keep_looks : bool       whether looks of past seconds stay in the log

    Attributes
    ----------
    second : int                        now
    places_m, velocities_mps : (A, 2)   of the agents, changed in place
    track_m : (T + 1, A, 2)             where they were, up to now
    log : LookLog                       what was read
    truth : Truth                       where the targets are
    """

    def __init__(
        self, scene: Scene, seed: int, starts_m: NDArray[np.float64], capture: float, keep_looks: bool = False
    ) -> None:
        self.scene = scene
        self.second = 0
        self.truth: Truth = scene.world.truth(seed, scene.seconds)
        self.log = LookLog(scene.sensing.most_looks, keep_looks)
        self.places_m = starts_m
        self.velocities_mps = np.zeros_like(starts_m)
        self.track_m = np.empty((scene.seconds + 1, *starts_m.shape))
        self.track_m[0] = starts_m
        self._noise = noise_seed(seed)
        self._capture_m = capture * scene.team.radius_m
        self._limits = scene.team.v_max, scene.team.a_max
        self._routes = _PackedRoutes(len(scene.agents))

    @property
    def over(self) -> bool:
        """Whether the mission has ended."""
        return self.second >= self.scene.seconds

    @property
    def routes(self) -> Routes:
        """Waypoints not reached yet, by agent; an agent that has reached all keeps its last."""
        return self._routes.left

    def look(self) -> None:
        """All agents look at all cells in view."""
        scene = self.scene
        targets = scene.target_cells[self.truth.nodes_at(self.second)]
        scene.sensing.look(self.second, self.places_m, scene.world.nodes, targets, self._noise, self.log)

    def reroute(self, routes: Routes) -> None:
        """Fly these from now on, one route for each agent."""
        self._routes.take(routes)

    def go_on(self) -> None:
        """A second passes: the targets move while the agents fly."""
        from sooner.simulation._flight_kernels import fly

        routes = self._routes
        self.truth.move(self.second, self.places_m)
        fly(
            self.places_m, self.velocities_mps, *self._limits, self._capture_m, routes.waypoints, routes.lengths,
            routes.reached, 1.0, STEP_S,
        )  # fmt: skip
        self.second += 1
        self.track_m[self.second] = self.places_m

    def target_near(self, cell: int, second: int) -> int:
        """The nearest target within the largest radius of view of a cell's centre then, -1 if there was none."""
        apart = self.truth.places_at(second) - self.scene.grid.centres_m[cell]
        if not len(apart):
            return -1
        metres = np.hypot(apart[:, 0], apart[:, 1])
        nearest = int(metres.argmin())
        return nearest if metres[nearest] <= self.scene.sensing.radius_m.max() else -1

    def looks(self) -> Looks:
        """All looks so far, where the log keeps them."""
        log, end = self.log, self.log.end
        return Looks(
            firsts=np.array([*log.firsts, end], np.int64),
            cells=log.cells[:end].copy(),
            agents=log.agents[:end].copy(),
            map_levels=log.map_levels[:end].copy(),
            target_levels=log.target_levels[:end].copy(),
        )


def left_of(route: NDArray[np.float64], reached: int) -> NDArray[np.float64]:
    """The (k, 2) waypoints of a route that are not reached yet; its last always is among them.

    >>> left_of(np.array([[0.0, 0.0], [5.0, 0.0]]), 2)
    array([[5., 0.]])
    """
    return route[max(min(reached, len(route) - 1), 0) :]


class _PackedRoutes:
    """Routes of all agents in one array, as the kernel that flies them takes them."""

    def __init__(self, n_agents: int) -> None:
        self.waypoints = np.zeros((n_agents, 1, 2))
        self.lengths = np.zeros(n_agents, np.int64)
        self.reached = np.zeros(n_agents, np.int64)

    @property
    def left(self) -> Routes:
        return tuple(
            left_of(self.waypoints[agent, :length], reached).copy()
            for agent, (reached, length) in enumerate(zip(self.reached.tolist(), self.lengths.tolist(), strict=True))
        )

    def take(self, routes: Routes) -> None:
        if len(routes) != len(self.lengths):
            raise InvalidProblemError(f"routes for {len(routes)} agents came; the team has {len(self.lengths)}")
        for agent, route in enumerate(routes):
            if np.ndim(route) == 0 or (len(route) and np.shape(route)[1:] != (2,)):
                came = f"a route of shape {np.shape(route)} came for agent {agent}"
                raise InvalidProblemError(f"{came}; expected (k, 2), metres east and north of each waypoint")
        longest = max(max(len(route) for route in routes), 1)
        self.waypoints = np.zeros((len(routes), longest, 2))
        self.lengths = np.array([len(route) for route in routes], np.int64)
        self.reached = np.zeros(len(routes), np.int64)
        for agent, route in enumerate(routes):
            self.waypoints[agent, : len(route)] = route
        if not np.isfinite(self.waypoints).all():
            raise InvalidProblemError("a waypoint that is not a number came; expected metres east and north")
