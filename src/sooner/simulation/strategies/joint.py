"""The whole team's whole remaining mission at once: routes that bring into view soon what is likely to be there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.belief.street_continuation import StreetContinuation
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.simulation.agents import Agent, Team
from sooner.simulation.ground import area
from sooner.simulation.strategies.lawnmower import lanes, rectangles
from sooner.simulation.strategies.presence import Presence
from sooner.simulation.strategies.strategy import Routes, Situation

__all__ = ["Joint", "JointSession", "chosen_starts", "lane_layouts", "route_value", "shared_lanes"]

Floats = NDArray[np.float64]

MOST_SECONDS = 3600  # that starts are chosen for


@dataclass(frozen=True)
class Joint:
    """Hill climbing over the routes of all agents until the end of the mission, from lanes, and on at every replan.

    J = sum_c w_c (T - f_c)^+,   w_c = n_c / N + target b_c

    with f_c the second of a cell's first view by any agent, T the seconds left, n_c the probability of a node not yet
    detected, N the nodes detected and expected, b_c the target's probability (see `Presence`). Agents are flown with
    their own controllers, a quarter of a second at a time.

    Parameters
    ----------
    start : str                "drawn": on the perimeter where the dice say; "chosen": there, too, but where lanes begin
                               that share out the ground best, as the lawnmower has its corners (see `chosen_starts`)
    streets : bool             whether unseen nodes are expected where streets go on (see `StreetContinuation`), or
                               as the estimator has them
    capture : float            share of the radius within which a waypoint is reached
    reach : float              share of the radius that counts as seen
    target : float             what finding the target is worth against all nodes, until it is detected
    rounds : int               a replan
    first_rounds : int         at the first
    moves : int                tried for each agent in a round
    crossings : int            moves between two agents tried in a round
    waypoints : int            of a route at most

    Raises
    ------
    InvalidProblemError        if a number makes no sense

    Examples
    --------
    >>> Joint().rounds, Joint(rounds=3).rounds
    (1, 3)
    """

    start: Literal["drawn", "chosen"] = "drawn"
    streets: bool = True
    capture: float = 0.5
    reach: float = 1.0
    target: float = 1.0
    rounds: int = 1
    first_rounds: int = 30
    moves: int = 40
    crossings: int = 10
    waypoints: int = 64

    def __post_init__(self) -> None:
        if self.start not in ("drawn", "chosen"):
            raise InvalidProblemError(f"start = {self.start!r} came; expected 'drawn' or 'chosen'")
        for name in ("capture", "reach"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InvalidProblemError(f"{name} = {value} came; expected a positive number")
        if not (np.isfinite(self.target) and self.target >= 0.0):
            raise InvalidProblemError(f"target = {self.target} came; expected at least 0")
        for name in ("rounds", "first_rounds", "moves", "crossings"):
            if getattr(self, name) < 0:
                raise InvalidProblemError(f"{name} = {getattr(self, name)} came; expected at least 0")
        if self.waypoints < 2:
            raise InvalidProblemError(f"{self.waypoints} waypoints came; expected at least 2")

    def starts(self, grid: Grid, agents: tuple[Agent, ...], drawn: Floats) -> Floats:
        """(A, 2) float: on the perimeter."""
        if self.start == "drawn":
            return drawn
        return chosen_starts(grid, agents, self.capture, self.reach).copy()

    def session(self, situation: Situation, rng: Generator) -> JointSession:
        """Begin a search."""
        return JointSession(self, situation, rng)


@dataclass(eq=False)
class JointSession:
    """Routes of the team, bettered at every replan.

    value : float        J of the routes of the last replan
    """

    strategy: Joint
    situation: Situation
    rng: Generator
    value: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        team, grid = Team(self.situation.agents), self.situation.grid
        self._presence = Presence(grid, self.situation.states)
        self._streets = StreetContinuation(grid) if self.strategy.streets else None
        self._low, self._high = area(grid)
        self._shape = np.array(grid.shape, np.int64)
        self._bodies = bodies(team, grid, self.strategy.capture, self.strategy.reach)
        self._weights = np.empty(grid.n_cells)
        self._dice = dice(self.rng)
        self._begun = False

    def watch(self, cells: NDArray[np.int32], target_ratios: Floats) -> None:
        """Take in one second's looks for a target."""
        self._presence.watch(cells, target_ratios)

    def found(self, cell: int) -> None:
        """A target was found; another is sought."""
        self._presence.found(cell)

    def remembered(self) -> Floats:
        """What was made of the looks so far."""
        return self._presence.shares.copy()

    def recall(self, kept: Floats) -> None:
        """Forget all looks since then."""
        self._presence.shares[:] = kept

    def routes(self, situation: Situation) -> Routes:
        """Routes until the end of the mission."""
        from sooner.simulation.strategies._coverage_kernels import improve

        strategy, states = self.strategy, situation.states
        self._presence.states = states
        expected = None
        if self._streets is not None:
            expected = self._streets.expected_void(states.void, states.explored, states.nodes)
        self._presence.weigh(strategy.target if situation.sought else 0.0, self._weights, expected)
        if situation.glimpse is not None:
            self._weights *= situation.glimpse
        seconds = int(situation.end_s - situation.now_s)
        rounds, routes = strategy.rounds, situation.routes
        if not self._begun:
            lanes_at_start = shared_lanes(
                situation.grid, situation.agents, self._bodies, self._weights, seconds, _starts(situation)
            )
            rounds, routes = strategy.first_rounds, lanes_at_start[0]
            self._begun = True
        packed, lengths = pack(routes, strategy.waypoints)
        self.value = improve(
            _starts(situation), self._bodies, packed, lengths, seconds, self._shape, float(situation.grid.cell_m),
            self._low, self._high, self._weights, rounds, strategy.moves, strategy.crossings, self._dice,
        )  # fmt: skip
        return tuple(route[:length].copy() for route, length in zip(packed, lengths, strict=True))


def route_value(
    grid: Grid,
    agents: tuple[Agent, ...],
    places_m: Floats,
    routes: Routes,
    weights: Floats,
    seconds: int,
    *,
    capture: float = 0.5,
    reach: float = 1.0,
) -> float:
    """J of routes that agents fly from rest.

    >>> grid, east = Grid((1, 9), "square8", 5.0), np.array([[40.0, 0.0]])
    >>> route_value(grid, (Agent(),), np.zeros((1, 2)), (east,), np.eye(9)[8], 60) > 40.0
    True
    """
    starts = np.hstack([places_m, np.zeros_like(places_m)])
    return _values(grid, bodies(Team(agents), grid, capture, reach), starts, routes, weights, seconds)[0]


def _values(
    grid: Grid, body: Floats, starts: Floats, routes: Routes, weights: Floats, seconds: int
) -> tuple[float, Floats]:
    """J of the routes of a team, and (A,) what each would be worth without the others."""
    from sooner.simulation.strategies._coverage_kernels import value_of

    packed, lengths = pack(routes, max(max(len(route) for route in routes), 1))
    alone, shape = np.empty(len(routes)), np.array(grid.shape, np.int64)
    value = value_of(starts, body, packed, lengths, seconds, shape, float(grid.cell_m), weights, alone)
    return float(value), alone


@lru_cache(maxsize=32)
def chosen_starts(grid: Grid, agents: tuple[Agent, ...], capture: float = 0.5, reach: float = 1.0) -> Floats:
    """(A, 2) float: where on the perimeter lanes begin that bring the whole ground into view soonest, every cell alike.

    Of the bands, columns and rectangles of `lane_layouts` the best, each lane flown on from where, led back, it enters
    the ground; in one and a half times what the team would need for the ground without turns.

    >>> chosen_starts(Grid((40, 40), "square8", 5.0), (Agent(),) * 4)[:, 0].tolist()
    [-2.5, -2.5, -2.5, -2.5]
    """
    team = Team(agents)
    low, high = area(grid)
    seconds = int(1.5 * np.prod(high - low) / (2.0 * reach * team.radius_m * team.v_max).sum()) + 2
    body = bodies(team, grid, capture, reach)
    return shared_lanes(grid, agents, body, np.ones(grid.n_cells), min(seconds, MOST_SECONDS))[1][:, :2]


def shared_lanes(
    grid: Grid, agents: tuple[Agent, ...], body: Floats, weights: Floats, seconds: int, starts: Floats | None = None
) -> tuple[Routes, Floats]:
    """The best of the layouts of lanes, each with its parts shared out among agents as well as may be.

    starts : (A, 4) float or None      places and velocities; None: every agent begins where its lanes enter the ground

    Returns the routes, and the starts, (A, 4).
    """
    from sooner.simulation.strategies._task_kernels import most_valuable

    def begun(way: Floats) -> Floats:
        return np.tile(_entrance(grid, way), (len(agents), 1)) if starts is None else starts

    found = []
    for parts in lane_layouts(grid, agents):
        values = np.empty((len(agents), len(parts)))
        choices = np.empty(values.shape, np.int64)
        for part, (inside, ways) in enumerate(parts):
            here = np.where(inside, weights, 0.0)
            alone = np.array([_values(grid, body, begun(way), (way,) * len(agents), here, seconds)[1] for way in ways])
            values[:, part], choices[:, part] = alone.max(axis=0), alone.argmax(axis=0)
        chosen = np.empty(len(parts), np.int64)
        most_valuable(values, chosen)
        routes = tuple(parts[part][1][choices[agent, part]] for agent, part in enumerate(chosen))
        begins = np.array([begun(route)[agent] for agent, route in enumerate(routes)])
        found.append((_values(grid, body, begins, routes, weights, seconds)[0], routes, begins))
    _, routes, begins = max(found, key=lambda layout: layout[0])
    return routes, begins


def _entrance(grid: Grid, way: Floats) -> Floats:
    """(4,) float: at rest where the first leg, led back, enters the ground."""
    low, high = area(grid)
    back = way[0] - way[1]
    if not back.any():  # a lane of no length enters from the west
        back = np.array([-1.0, 0.0])
    room = np.where(back > 0.0, high - way[0], way[0] - low)
    metres = room[back != 0.0] / np.abs(back[back != 0.0])
    return np.append(np.clip(way[0] + metres.min() * back, low, high), [0.0, 0.0])


def lane_layouts(grid: Grid, agents: tuple[Agent, ...]) -> list[list[tuple[NDArray[np.bool_], Routes]]]:
    """Ways to cut the ground into as many parts as agents: the (M,) cells of each, and ways to sweep it in lanes.

    Bands, columns, and rectangles as `rectangles` cuts them; lanes north to south or east to west, from each corner, as
    wide as each agent sees.
    """
    low, high = area(grid)
    n = len(agents)
    widths = sorted({2.0 * agent.radius_m for agent in agents})
    layouts = []
    for across, up in ((1, n), (n, 1)):
        size = (high - low) / (across, up)
        layouts.append([(low + size * (e, u), low + size * (e + 1, u + 1)) for u in range(up) for e in range(across)])
    layouts.append(rectangles(grid, n))
    return [[(_inside(grid, *part), _sweeps(*part, widths)) for part in layout] for layout in layouts]


def _inside(grid: Grid, low: Floats, high: Floats) -> NDArray[np.bool_]:
    return np.asarray(((grid.centres_m >= low) & (grid.centres_m < high)).all(axis=1))


def _sweeps(low: Floats, high: Floats, widths: Sequence[float]) -> Routes:
    ways = []
    for width, east, north in product(widths, (False, True), (False, True)):
        corner = np.where([east, north], high, low)
        ways.append(lanes(low, high, corner, width, 0.5))
        ways.append(lanes(low[::-1], high[::-1], corner[::-1], width, 0.5)[:, ::-1])
    return tuple(ways)


def bodies(team: Team, grid: Grid, capture: float, reach: float) -> Floats:
    """(A, 4) float: v_max, a_max, metres at which a waypoint is reached, radius of view in cells."""
    return np.column_stack(
        [team.v_max, team.a_max, capture * team.radius_m, reach * team.radius_m / float(grid.cell_m)]
    )


def dice(rng: Generator) -> NDArray[np.uint64]:
    """(2,) uint64: a key for random numbers in kernels, and how many were drawn."""
    return np.array([rng.integers(1 << 62), 0], np.uint64)


def pack(routes: Routes, most: int) -> tuple[Floats, NDArray[np.int64]]:
    """(A, most, 2) waypoints and (A,) int64 lengths; what is beyond the most is left out."""
    packed = np.zeros((len(routes), most, 2))
    lengths = np.array([min(len(route), most) for route in routes], np.int64)
    for agent, length in enumerate(lengths):
        packed[agent, :length] = routes[agent][:length]
    return packed, lengths


def _starts(situation: Situation) -> Floats:
    return np.hstack([situation.places_m, situation.velocities_mps])
