"""Annealing over regions: how often each action is flown, so that one walk can fly them all in time."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.planners.branch_and_bound import BranchAndBound
from sooner.planners.depth_first import DepthFirst, relaxation
from sooner.planners.planner import Ticks
from sooner.planners.region_greedy import RegionGreedy
from sooner.planners.region_walk import walk_of
from sooner.planners.rounds import FIRST_ROUND, Rounds
from sooner.problem import Incumbent, Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround, single_region_searcher

__all__ = ["RegionAnneal"]

POLISH = 1e-9
FEW, BRANCHED = 50, 2000  # among so few actions annealing may never leave a plan; branching looks further


@dataclass(frozen=True)
class RegionAnneal:
    """The default over regions: a walk as numbers of actions, changed a little at a time.

    What a plan collects does not depend on the order of its actions, only on how often each is flown; numbers that are
    connected and have even degrees, but for the two ends, can be flown as one walk (Euler 1736). A move makes one to
    three changes: a search more or less, an edge there and back more or less, another end, a cycle more, or one part
    of a cycle more and the other less. Worse numbers are taken with the probability exp(difference / temperature)
    (Kirkpatrick et al. 1983); numbers that take too long never.

    Parameters
    ----------
    hot : tuple of float       temperatures at the beginning, in mean gains of an action of the relaxed plan: each of
                               its own family of walks. The coolest is best where there are many regions; where there
                               are few, it may never leave the plan that it began with
    cold : float               temperature at the end
    walks : int                started together from the best of depth-first coverage, a greedy walk and, among few
                               actions, branch and bound
    halvings : (share, n)      after this share of a round the n best go on, as many of each family
    moves : int                of each thread between two yields; as many more for each further thousand actions
    longest : int              ticks after which a round begins anew, where there is time for more than one
    threads : int              a plan depends on their number, never on their speed
    """

    hot: tuple[float, ...] = (0.1, 0.1, 0.1, 0.3)
    cold: float = 0.003
    walks: int = 8
    halvings: tuple[tuple[float, int], ...] = ((0.4, 4), (0.7, 2))
    moves: int = 40_000
    longest: int = 400
    threads: int = 2

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over regions."""
        return single_region_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Ticks:
        """Yield the better of depth-first coverage and a greedy walk at once, then anneal for as long as asked."""
        ground = RegionGround.of(problem)
        firsts = [next(planner.plans(problem, rng)) for planner in (DepthFirst(), RegionGreedy())]
        best = max(firsts, key=lambda incumbent: incumbent.value)
        share = yield best
        if ground.n_actions <= FEW:
            *_, branched = BranchAndBound(iterations=BRANCHED, early=True).plans(problem, rng)
            best = max(best, branched, key=lambda incumbent: incumbent.value)
        numbers = _Numbers(ground)
        start = best.plan.actions[0]
        rounds, moves = Rounds(self.longest, FIRST_ROUND), self.moves * (1 + ground.n_actions // 1000)
        with ThreadPoolExecutor(self.threads) as pool:
            while True:
                rounds = rounds.begun(share)
                streams = rng.spawn(max(self.walks, self.threads, len(self.hot)))
                states = [_State(numbers, start, each, n % len(self.hot)) for n, each in enumerate(streams)]
                while (now := rounds.now(share)) < 1.0:
                    states = self._halved(states, now)
                    self._anneal(states, now, moves, pool)
                    best = _better(problem, numbers, states, best)
                    share = yield best
                    rounds.tick += 1
                start = best.plan.actions[0]

    def _halved(self, states: list[_State], now: float) -> list[_State]:
        """Let the better ones of each family go on."""
        keep = min((n for share, n in self.halvings if now >= share), default=len(states))
        if max(keep, self.threads, len(self.hot)) >= len(states):
            return states
        families = [[state for state in states if state.family == n] for n in range(len(self.hot))]
        each = max(keep, self.threads) // len(families)
        best = [sorted(family, key=lambda state: -state.value)[: max(each, 1)] for family in families]
        return [state for level in zip_longest(*best) for state in level if state is not None]

    def _anneal(self, states: list[_State], now: float, moves: int, pool: ThreadPoolExecutor) -> None:
        """One tick: every thread makes the same number of moves, shared among its states."""
        temperatures = [hot * (self.cold / hot) ** now if now < 0.97 else POLISH for hot in self.hot]

        def run(own: list[_State]) -> None:
            for state in own:
                state.anneal(temperatures[state.family], moves // len(own))

        list(pool.map(run, [states[k :: self.threads] for k in range(min(self.threads, len(states)))]))


def _better(problem: SearchProblem, numbers: _Numbers, states: Iterable[_State], best: Incumbent) -> Incumbent:
    """The best numbers of all as a walk, where they are better than the best plan."""
    state = max(states, key=lambda each: each.best)
    if state.best + numbers.ground.leg_value <= best.value * (1.0 + 1e-12):
        return best
    plan = Plan.of(walk_of(numbers.ground, *state.kept_numbers))
    value = evaluate(problem, plan).value
    return Incumbent(plan, value) if value > best.value else best


class _Numbers:
    """What all states share."""

    def __init__(self, ground: RegionGround) -> None:
        self.ground = ground
        value, counts = relaxation(ground)
        self.unit = (value - ground.leg_value) / max(counts.sum(), 1)
        self.cycle_starts, self.cycles = _cycles(ground)


class _State:
    """Numbers of actions under change; see `_region_anneal_kernels`."""

    def __init__(self, numbers: _Numbers, actions: NDArray[np.int64], rng: Generator, family: int) -> None:
        from sooner.planners._region_anneal_kernels import LONGEST

        ground = self.ground = numbers.ground
        self.numbers, self.family = numbers, family
        self.counts = np.bincount(actions, minlength=ground.n_actions).astype(np.int32)
        edges = self.counts[ground.n_regions :]
        self.degree = np.zeros(ground.n_regions, np.int32)
        for end in (0, 1):
            np.add.at(self.degree, ground.ends[ground.n_regions :, end], edges)
        self.looks = np.zeros(len(ground.gains), np.int32)
        np.add.at(self.looks, ground.atoms, np.repeat(self.counts, np.diff(ground.starts)))
        end = ground.walked(actions.tolist())
        self.whole = np.array([*rng.integers(1, 2**32, 2), end, 2, edges.sum(), 0, end, 0], np.int64)
        held = np.minimum(self.looks, ground.gains.shape[1])
        value = np.concatenate([np.zeros((len(held), 1)), np.cumsum(ground.gains, axis=1)], axis=1)
        total = float(value[np.arange(len(held)), held].sum())
        self.real = np.array([float(self.counts @ ground.seconds), total, total])
        self.kept = self.counts.copy()
        self.scratch = (
            np.zeros(ground.n_regions, np.int64), np.zeros((2, ground.n_regions), np.int32), np.zeros(96, np.int64),
            np.zeros(6 * LONGEST, np.int64),
        )  # fmt: skip

    @property
    def value(self) -> float:
        """Of the present numbers."""
        return float(self.real[1])

    @property
    def best(self) -> float:
        """Of the best numbers so far."""
        return float(self.real[2])

    @property
    def kept_numbers(self) -> tuple[NDArray[np.int32], int]:
        """The best numbers, and where they end."""
        return self.kept, int(self.whole[6])

    def anneal(self, temperature: float, moves: int) -> None:
        """Make so many moves."""
        from sooner.planners._region_anneal_kernels import anneal

        ground = self.ground
        anneal(
            ground.starts, ground.atoms, ground.way_starts, ground.ways, ground.ends, self.numbers.cycle_starts,
            self.numbers.cycles, ground.gains, ground.seconds, ground.limit_s, ground.first, ground.last < 0,
            self.counts, self.degree, self.looks, self.whole, self.real, self.kept, *self.scratch,
            temperature * self.numbers.unit, moves,
        )  # fmt: skip


def _cycles(ground: RegionGround) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """A shortest cycle through each edge, each cycle once, as rows of actions."""
    found = {
        cycle
        for edge in range(ground.n_regions, ground.n_actions)
        if (cycle := _cycle_through(ground, edge)) is not None
    }
    rows = sorted(sorted(cycle) for cycle in found)
    flat = np.array([action for row in rows for action in row], np.int64)
    return np.cumsum([0, *map(len, rows)]), flat


def _cycle_through(ground: RegionGround, edge: int) -> frozenset[int]:
    """The fewest edges that close a cycle with this one; none where there is none, or only a long one."""
    from sooner.planners._region_anneal_kernels import LONGEST

    one, other = ground.ends[edge].tolist()
    came = {one: (-1, -1, 1)}  # region: edge that leads to it, region before, edges so far and this one
    waiting = deque([one])
    while waiting and other not in came:
        here = waiting.popleft()
        if came[here][2] == LONGEST:
            return frozenset()
        for action, there in ground.ways_from(here)[1:]:
            if action != edge and there not in came:
                came[there] = action, here, came[here][2] + 1
                waiting.append(there)
    if other not in came:
        return frozenset()
    cycle = {edge}
    while other != one:
        action, other, _ = came[other]
        cycle.add(action)
    return frozenset(cycle)
