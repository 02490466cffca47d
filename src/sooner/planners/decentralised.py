"""Decentralised: each searcher plans for itself, knowing only the plans that it has heard over limited links."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.planners.planner import Part, Planner, Ticks
from sooner.planners.team import Team, least_flight, left_for
from sooner.problem import Incumbent, Plan, SearchProblem, evaluate

__all__ = ["Decentralised", "Exchange", "Links", "Message"]

Flight = NDArray[np.int64]
PLANNING = 0.97  # share of the run for planning: what the searchers are left with must be told before it is over


@dataclass(frozen=True)
class Links:
    """What searchers hear of one another before they take off.

    Parameters
    ----------
    range_m : float        between starts that hear each other; 0: only those at the same place do, inf: all
    loss : float           probability that a message in range is lost, each by itself
    relays : bool          a message carries all plans that its sender knows; False: only its own

    Raises
    ------
    InvalidProblemError    for a negative range, or a loss that is no probability
    """

    range_m: float = inf
    loss: float = 0.0
    relays: bool = True

    def __post_init__(self) -> None:
        if not self.range_m >= 0:
            raise InvalidProblemError(f"a range of {self.range_m} m came; expected at least 0")
        if not 0.0 <= self.loss <= 1.0:
            raise InvalidProblemError(f"a loss of {self.loss} came; expected a probability")

    def in_range(self, problem: SearchProblem) -> NDArray[np.bool_]:
        """(A, A) bool: pairs of searchers whose starts are near enough; none hears itself."""
        starts = [problem.grid.index(searcher.start) for searcher in problem.searchers]
        places = problem.grid.centres_m[starts]
        apart_m = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
        return np.asarray((apart_m <= self.range_m) & ~np.eye(len(starts), dtype=bool))


@dataclass(frozen=True)
class Message:
    """One message: after which turn, from whom to whom, and whether it was heard. Turn 0 is before any planning."""

    turn: int
    sender: int
    receiver: int
    heard: bool


@dataclass(frozen=True, eq=False)
class Exchange:
    """How a team has planned, and what it is left with.

    Parameters
    ----------
    plan : Plan                    each searcher's own flight
    value : float                  of all of them together, as the judge says
    believed : (A,) float          what each believes the flights are worth that it knows of, its own among them
    knows : (A, A) bool            row by row, whose flights each knows as they are at last
    messages : tuple of Message    all that were sent within range, in order
    """

    plan: Plan
    value: float
    believed: NDArray[np.float64]
    knows: NDArray[np.bool_]
    messages: tuple[Message, ...]

    @property
    def sent(self) -> int:
        """Messages sent within range."""
        return len(self.messages)

    @property
    def lost(self) -> int:
        """Messages lost on the way."""
        return sum(not message.heard for message in self.messages)


@dataclass(frozen=True)
class Decentralised:
    """Rounds of best responses over links that lose messages.

    Searchers take turns. Whoever's turn it is plans for what the flights that it has heard of leave, keeps the new
    flight where it believes that the flights it knows are then worth more, and sends what it knows. A flight that was
    not heard is never counted; one that was changed since is counted as it was heard. Over links that lose nothing
    and reach everybody this is `Team`, to the last action; without any, everyone flies the best flight alone.

    Nobody on board knows what the team's flights are worth together, so the planner yields a first joint plan as a
    sign of life and, at the end, what the searchers are left with, for better or worse.

    Parameters
    ----------
    inner : Planner         plans for one searcher, over cells or over regions
    links : Links
    rounds : int            rounds of improvement after the first
    ticks : int             ticks for each plan, where the stop rule does not share out time
    tell : callable         is shown the `Exchange` at its end
    """

    inner: Planner
    links: Links = Links()
    rounds: int = 2
    ticks: int = 20
    tell: Callable[[Exchange], None] | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        Team(self.inner, self.rounds, self.ticks)  # refuses the same numbers

    def handles(self, problem: SearchProblem) -> str | None:
        """What `Team` handles."""
        return Team(self.inner).handles(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield a first joint plan at every tick of the inner planner, and at the end what the team is left with."""
        losses = np.random.default_rng(deepcopy(rng).integers(2**63))  # apart, so that planning draws as in `Team`
        radio = _Radio(problem, self.links, losses)
        for number in range(len(problem.searchers)):
            radio.plan(number, least_flight(problem, number, rng))
        for number in range(len(problem.searchers)):
            radio.send(0, number)
        first = radio.joint
        share: float | None = 0.0
        turns = len(problem.searchers) * (1 + self.rounds)
        for turn in range(turns):
            number = turn % len(problem.searchers)
            believed = radio.believed(number)

            def take(proposal: Incumbent, number: int = number) -> Incumbent:
                nonlocal believed
                worth = radio.believed(number, proposal.plan.actions[0])
                if worth > believed:
                    radio.plan(number, proposal.plan.actions[0])
                    believed = worth
                return first

            part = Part(PLANNING * turn / turns, PLANNING * (turn + 1) / turns, self.ticks)
            asked = left_for(problem, number, radio.heard(number))
            share, _ = yield from part.run(self.inner, asked, rng, share, take)
            radio.send(turn + 1, number)
        exchange = radio.exchange
        if self.tell is not None:
            self.tell(exchange)
        yield Incumbent(exchange.plan, exchange.value)


class _Radio:
    """Who knows which flight of whom, and all that was said."""

    def __init__(self, problem: SearchProblem, links: Links, rng: Generator) -> None:
        self.problem, self.links, self.rng = problem, links, rng
        self.in_range = links.in_range(problem)
        # for each searcher, the flights that it knows: version and actions, by number
        self.known: list[dict[int, tuple[int, Flight]]] = [{} for _ in problem.searchers]
        self.messages: list[Message] = []

    def plan(self, number: int, flight: Flight) -> None:
        """A searcher changes its own flight; nobody else knows."""
        version, _ = self.known[number].get(number, (0, flight))
        self.known[number][number] = version + 1, flight

    def send(self, turn: int, sender: int) -> None:
        """A searcher tells everybody in range what it knows; each hears all of that or nothing."""
        said = self.known[sender] if self.links.relays else {sender: self.known[sender][sender]}
        for receiver in np.flatnonzero(self.in_range[sender]).tolist():
            heard = bool(self.rng.random() >= self.links.loss)
            self.messages.append(Message(turn, sender, receiver, heard))
            if heard:
                self._hear(receiver, said)

    def _hear(self, receiver: int, said: dict[int, tuple[int, Flight]]) -> None:
        known = self.known[receiver]
        for number, (version, flight) in said.items():
            if number != receiver and version > known.get(number, (0, flight))[0]:
                known[number] = version, flight

    def heard(self, number: int) -> dict[int, Flight]:
        """The flights of others that a searcher knows."""
        return {other: flight for other, (_, flight) in sorted(self.known[number].items()) if other != number}

    def believed(self, number: int, own: Flight | None = None) -> float:
        """What a searcher believes the flights are worth that it knows of, with this one as its own."""
        flights = {other: flight for other, (_, flight) in sorted(self.known[number].items())}
        if own is not None:
            flights[number] = own
        known = replace(self.problem, searchers=tuple(self.problem.searchers[other] for other in flights))
        return evaluate(known, Plan(tuple(flights.values()))).value

    @property
    def joint(self) -> Incumbent:
        """Everyone's own flight, and what they are worth together."""
        plan = Plan(tuple(known[number][1] for number, known in enumerate(self.known)))
        return Incumbent(plan, evaluate(self.problem, plan).value)

    @property
    def exchange(self) -> Exchange:
        """All of it, at the end."""
        joint, team = self.joint, range(len(self.known))
        latest = [self.known[number][number][0] for number in team]
        knows = [[self.known[one].get(other, (0,))[0] == latest[other] for other in team] for one in team]
        believed = np.array([self.believed(number) for number in team])
        return Exchange(joint.plan, joint.value, believed, np.array(knows), tuple(self.messages))
