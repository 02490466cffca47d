"""Every agent believes and plans for itself, from the looks that it has made or heard of."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sooner.simulation.agents import STEP_S
from sooner.simulation.command import CommandPost, Kept, Told
from sooner.simulation.estimation import TeamBelief
from sooner.simulation.in_flight import Flight, left_of
from sooner.simulation.links import Links
from sooner.simulation.network import LookStore, Network, Report
from sooner.simulation.scene import Scene
from sooner.simulation.strategies.strategy import Routes, Strategy

__all__ = ["DecentralisedCommand"]

Floats = NDArray[np.float64]
NONE = 1 << 62  # a second that never comes
MOST_KEPT = 4  # beliefs that an agent keeps to go back to


class DecentralisedCommand:
    """A command post aboard each agent, which believes what the looks say that the agent has, and leads it alone.

    A look that comes late is put where it belongs: when an agent plans, it goes back to what it believed before, and
    hears all that it has from then on again, second by second. So it always plans from what a command post would
    believe that heard exactly these looks, each at its time. None is too old for that: looks of one agent come in
    their order, so an agent keeps what it believed when nothing could be missing any more, and all looks since. Between
    its plans an agent takes in what it sees and hears of that very second; late looks wait.

    Each agent plans for the whole team and flies its own part. The others it thinks where they are if they flew on
    along the last route that it heard of; of those not heard of since its last plan, it thinks that they fly what that
    plan had in mind for them. All know where all start, and strategies draw alike.

    A node or a target is detected when the first agent detects it. An agent calls what its belief has newly detected,
    also where late looks say that it had been there to detect a while ago: the call then says where the target was.

    Parameters
    ----------
    scene : Scene          with links
    strategy : Strategy
    links : Links
    seed : int             of what the strategy draws, and of what is lost on the way
    """

    def __init__(self, scene: Scene, strategy: Strategy, links: Links, seed: int) -> None:
        self.scene = scene
        self.network = Network(links, scene.starts(strategy, seed), seed)
        self._capture_m = strategy.capture * scene.team.radius_m
        self._store = LookStore()
        self._aboard = [_Aboard(CommandPost(scene, strategy, seed), agent) for agent in range(len(scene.agents))]
        self.agents_node_seconds = np.array([each.post.node_seconds for each in self._aboard])

    @property
    def belief(self) -> TeamBelief:
        """What the agent believes that has the most looks, the first of equals."""
        return self.beliefs[int(self.network.clocks.sum(axis=1).argmax())]

    @property
    def beliefs(self) -> tuple[TeamBelief, ...]:
        """What each agent believes now."""
        return tuple(each.post.belief for each in self._aboard)

    @property
    def node_seconds(self) -> NDArray[np.int64]:
        """(M,) int64: when the first agent detected each cell's node, -1 not yet."""
        never = np.iinfo(np.int64).max
        first = np.where(self.agents_node_seconds >= 0, self.agents_node_seconds, never).min(axis=0)
        return np.where(first < never, first, -1)

    def see(self, flight: Flight) -> Told:
        """Each agent takes in what it sees and hears now.

        Returns
        -------
        Told       the most that an agent's detector holds, and what any of them calls
        """
        second, clocks = flight.second, self.network.clocks
        self._store.add(second, flight.log)
        since = self.network.exchange(second, flight.places_m, flight.velocities_mps, flight.routes)
        most, cells = 0.0, dict[tuple[int, int], None]()
        for agent, each in enumerate(self._aboard):
            total, called = each.take_in(second, int(since[agent]), clocks[agent], self._store, self.scene.replan_s)
            most = max(most, total)
            cells |= dict.fromkeys(called)
            seconds = self.agents_node_seconds[agent]
            seconds[each.post.belief.states.nodes & (seconds < 0)] = second
        self._store.forget(min(each.oldest for each in self._aboard) + 1)
        return most, tuple(cells)

    def plan(self, flight: Flight) -> Routes | None:
        """Of each agent's plan for the team, its own part."""
        routes, changed = list(flight.routes), False
        for agent, each in enumerate(self._aboard):
            told = self._reckoned(flight, agent, each)
            answer = each.plan(flight.second, told)
            if answer is not None:
                routes[agent], changed = answer[agent], True
            each.keep(flight.second, self.network.clocks[agent])
        return tuple(routes) if changed else None

    def _reckoned(self, flight: Flight, agent: int, aboard: _Aboard) -> list[Report]:
        """Where an agent thinks that all are now, and what they have yet to fly."""
        told = []
        for other, heard in enumerate(self.network.reports[agent]):
            thought = aboard.thought[other]
            last = heard if thought is None or heard is not aboard.heard[other] else thought
            told.append(self._flown_on(other, last, flight.second))
        aboard.heard = list(self.network.reports[agent])
        return told

    def _flown_on(self, agent: int, last: Report, second: int) -> Report:
        """Where an agent is if it goes on along its route."""
        from sooner.simulation._flight_kernels import fly

        if last.second == second:
            return last
        team, one = self.scene.team, slice(agent, agent + 1)
        place, velocity, reached = last.place_m[None].copy(), last.velocity_mps[None].copy(), np.zeros(1, np.int64)
        route = last.route if len(last.route) else np.zeros((1, 2))
        fly(
            place, velocity, team.v_max[one], team.a_max[one], self._capture_m[one], route[None],
            np.array([len(last.route)]), reached, float(second - last.second), STEP_S,
        )  # fmt: skip
        return Report(second, place[0], velocity[0], left_of(last.route, int(reached[0])))


@dataclass(frozen=True, eq=False)
class _Checkpoint:
    """What was believed after a second, and how many calls there had been."""

    second: int
    kept: Kept
    calls: int


class _Aboard:
    """One agent's command post, and what it can go back to."""

    def __init__(self, post: CommandPost, agent: int) -> None:
        self.post = post
        self.agent = agent
        self.thought: list[Report | None] = [None] * len(post.scene.agents)
        self.heard: list[Report] = []
        self._late = NONE
        self._spare: Kept | None = None
        self._calls: list[tuple[int, int]] = []
        self._checkpoints = [_Checkpoint(-1, post.kept(), 0)]

    @property
    def oldest(self) -> int:
        """The second of the oldest belief that it can go back to."""
        return self._checkpoints[0].second

    def take_in(self, second: int, since: int, clock: NDArray[np.int64], store: LookStore, replan_s: int) -> Told:
        """Hear looks that are new from `since` on: what the detector holds now, and what it newly calls."""
        before = len(self._calls)
        if since < second:
            self._late = min(self._late, since)
        if self._late < second and second % replan_s == 0:
            self._go_back(self._late)
            for past in range(self._checkpoints[-1].second + 1, second):
                self._hear(past, clock, store)
                if past % replan_s == 0:
                    self.post.belief.predict()
                    self.keep(past, clock)
            self._late = NONE
        total = self._hear(second, clock, store)
        return total, tuple(self._calls[before:])

    def plan(self, second: int, told: list[Report]) -> Routes | None:
        """Routes for the whole team, which are kept in mind; None to go on unchanged."""
        routes: Routes = tuple(report.route for report in told)
        places, velocities = np.array([r.place_m for r in told]), np.array([r.velocity_mps for r in told])
        answer = self.post.decide(second, places, velocities, routes)
        planned = routes if answer is None else answer
        self.thought = [Report(second, *state) for state in zip(places, velocities, planned, strict=True)]
        return answer

    def keep(self, second: int, clock: NDArray[np.int64]) -> None:
        """Keep what is believed now, if looks can come that are later but not if some can come that are earlier."""
        others = [seen for agent, seen in enumerate(clock.tolist()) if agent != self.agent]
        if second > max(others):
            return
        self._checkpoints.append(_Checkpoint(second, self.post.kept(self._spare), len(self._calls)))
        self._spare = None
        seconds = [each.second for each in self._checkpoints]
        wanted = sorted({bisect_right(seconds, seen) - 1 for seen in others})
        for n in reversed(range(len(seconds))):
            if n not in wanted or 0 < wanted.index(n) <= len(wanted) - MOST_KEPT:
                self._drop(n)

    def _drop(self, number: int) -> None:
        """A checkpoint that nobody's looks lead back to; its arrays are used again."""
        self._spare = self._checkpoints.pop(number).kept

    def _go_back(self, since: int) -> None:
        """Believe what was believed before the second `since`."""
        while self._checkpoints[-1].second >= since:
            self._drop(-1)
        last = self._checkpoints[-1]
        self.post.restore(last.kept)
        del self._calls[last.calls :]

    def _hear(self, second: int, clock: NDArray[np.int64], store: LookStore) -> float:
        total, cells = self.post.hear(second, store.of(second, clock >= second))
        self._calls.extend((cell, second) for cell in cells)
        return total
