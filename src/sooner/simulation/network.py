"""Who has heard of which looks: messages between agents, and vector clocks that keep any look from coming twice.

The protocol is that of G. Wuu and A. Bernstein, "Efficient solutions to the replicated log and dictionary problems"
(PODC 1984), with an agent's looks of one second for an event. An agent has of every other one all looks up to some
second, and none after it: its row of the clock. A message carries all looks that not everybody is known to have, and
what its sender knows of everybody's clocks. So every message heard is an acknowledgement too, and there are no others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sooner.simulation.links import Links
from sooner.simulation.sensing import LookLog
from sooner.simulation.strategies.strategy import Routes
from sooner.simulation.world import Purpose, generator

__all__ = ["LookStore", "Network", "Report"]

Floats = NDArray[np.float64]
Clock = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Report:
    """Where an agent was in a second, how it flew and along what; it goes with the looks that it made then.

    second : int
    place_m, velocity_mps : (2,) float
    route : (k, 2) float       what it had not reached yet, before it planned again in that second
    """

    second: int
    place_m: Floats
    velocity_mps: Floats
    route: Floats


@dataclass(frozen=True, eq=False)
class _Message:
    """What an agent had when it sent it: see `Network`."""

    sender: int
    clock: list[int]
    known: Clock
    reports: tuple[Report, ...]


class Network:
    """What each agent has heard.

    Parameters
    ----------
    links : Links
    places_m : (A, 2) float      where agents start: all know that of all
    seed : int                   of what is lost: by second, sender and receiver, whatever range and delay

    Attributes
    ----------
    clocks : (A, A) int64        [i, k]: i has all looks that k made up to this second, and no later ones; -1 none
    known : (A, A, A) int64      [i, j, k]: what i knows j's clock of k to be, at least
    reports : list of lists      [i][k]: the newest of k that i has
    """

    def __init__(self, links: Links, places_m: Floats, seed: int) -> None:
        n = len(places_m)
        self.links = links
        self.clocks = np.full((n, n), -1, np.int64)
        self.known = np.full((n, n, n), -1, np.int64)
        start = [Report(0, place.copy(), np.zeros(2), np.empty((0, 2))) for place in places_m]
        self.reports = [list(start) for _ in range(n)]
        self._rng = generator(seed, Purpose.LINKS)
        self._due: dict[int, list[tuple[_Message, list[int]]]] = {}

    @property
    def held(self) -> NDArray[np.int64]:
        """(A,) int64: of how many looks, by second and agent, an agent does not know yet that all have them.

        It sends these again with its next ones; without relays, those of its own.
        """
        acknowledged = self.known.min(axis=1)
        if not self.links.relays:
            return np.diagonal(self.clocks - acknowledged).copy()
        return np.asarray((self.clocks - acknowledged).sum(axis=1))

    def exchange(self, second: int, places_m: Floats, velocities_mps: Floats, routes: Routes) -> NDArray[np.int64]:
        """All send what they have, with their looks of this second; what is due now is heard.

        Returns
        -------
        (A,) int64      the earliest second of the looks that are new to each agent; never later than `second`
        """
        before = self.clocks.copy()
        agents = range(len(places_m))
        for agent in agents:
            self.clocks[agent, agent] = second
            self.known[agent, agent] = self.clocks[agent]
            self.reports[agent][agent] = Report(
                second, places_m[agent].copy(), velocities_mps[agent].copy(), routes[agent]
            )
        hears = self._hears(places_m)
        self._due[second + self.links.delay_s] = [
            (self._message(agent), np.flatnonzero(hears[agent]).tolist()) for agent in agents if hears[agent].any()
        ]
        for message, receivers in self._due.pop(second, ()):
            for receiver in receivers:
                self._hear(receiver, message)
        since: NDArray[np.int64] = np.where(self.clocks > before, before + 1, second).min(axis=1)
        return since

    def _hears(self, places_m: Floats) -> NDArray[np.bool_]:
        """(A, A) bool: whether a message sent now reaches each other agent, row by sender."""
        heard = self._rng.random((len(places_m), len(places_m))) >= self.links.loss
        if self.links.range_m < np.inf:
            apart_m = np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1))
            heard &= apart_m <= self.links.range_m
        np.fill_diagonal(heard, False)
        return heard

    def _message(self, sender: int) -> _Message:
        return _Message(sender, self.clocks[sender].tolist(), self.known[sender].copy(), tuple(self.reports[sender]))

    def _hear(self, receiver: int, message: _Message) -> None:
        """Take in what is new; a clock that is behind ours tells nothing."""
        clock, reports = self.clocks[receiver], self.reports[receiver]
        for agent, (ours, theirs) in enumerate(zip(clock.tolist(), message.clock, strict=True)):
            if theirs > ours and (self.links.relays or agent == message.sender):
                clock[agent] = theirs
                reports[agent] = message.reports[agent]
        known = self.known[receiver]
        np.maximum(known, message.known, out=known)
        known[receiver] = clock


class LookStore:
    """Looks of past seconds, as far as anybody may still have to go over them again."""

    def __init__(self) -> None:
        self._logs: dict[int, dict[bytes, LookLog]] = {}
        self._all: dict[int, LookLog] = {}

    def add(self, second: int, log: LookLog) -> None:
        """Keep the newest second of a log."""
        self._all[second] = _part(log, slice(log.start, log.end))
        self._logs[second] = {}

    def of(self, second: int, who: NDArray[np.bool_]) -> LookLog:
        """The looks that some agents, (A,) bool, made in a second, in the order of all of them."""
        whole = self._all[second]
        if who.all():
            return whole
        logs, key = self._logs[second], who.tobytes()
        if key not in logs:
            logs[key] = _part(whole, who[whole.agents])
        return logs[key]

    def forget(self, before: int) -> None:
        """Nobody will ask again for seconds before this one."""
        for second in [second for second in self._all if second < before]:
            del self._all[second], self._logs[second]

    def __len__(self) -> int:
        """How many seconds are kept."""
        return len(self._all)


def _part(log: LookLog, which: slice | NDArray[np.bool_]) -> LookLog:
    part = LookLog(0)
    for name, column in vars(log).items():
        if isinstance(column, np.ndarray):
            setattr(part, name, column[which].copy())
    part.end = len(part.cells)
    return part
