"""Branch and bound over regions: best-first and impatient, or depth-first."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InfeasibleProblemError, InvalidProblemError
from sooner.problem import Incumbent, Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround, single_region_searcher

__all__ = ["BranchAndBound", "DepthFirstBranchAndBound", "Searched"]

TICK = 200  # iterations from one look at the clock to the next
ROOM = 1024  # nodes for which there is room to begin with


@dataclass(frozen=True)
class Searched:
    """What a search over unfinished walks has done and found so far.

    A solution is a complete walk, one that no action fits into any more, that is better than all before. `walk` is
    the best of all walks popped, complete or not: each is a plan once it has gone to where it must end.

    Parameters
    ----------
    iterations : int          nodes popped
    expanded : int            of them branched, being neither complete nor pruned
    generated : int           children, those seen before included
    evaluated : int           of them new, so that g was worked out
    stored : int              of them kept, g being large enough: what memory goes with
    solutions : int
    seconds : float           since the search began
    first_s : float           when the first solution was found; nan where there is none
    first_value : float       its value; nan where there is none
    value : float             of the best solution, B; -inf where there is none
    walk : tuple of int       actions
    finished : bool           whether nothing is left to try
    """

    iterations: int
    expanded: int
    generated: int
    evaluated: int
    stored: int
    solutions: int
    seconds: float
    first_s: float
    first_value: float
    value: float
    walk: tuple[int, ...]
    finished: bool

    @property
    def success(self) -> bool:
        """Whether a complete walk was found."""
        return self.solutions > 0


@dataclass(frozen=True)
class BranchAndBound:
    """eps-admissible branch and bound [Kuhlman2017, Algorithms 1 to 3]: best-first, and nothing for a small gain.

    A node N is a walk; it has paid R(N), and could pay g(N) if after it actions were picked by rate from anywhere
    [eq. (4)]. With B the value of the best complete walk, none to begin with,

        prune N where g(N) <= (1 + eta) B,    expand first the largest R + alpha (g - eta B - R)    [eq. (5), sec. 6]

    Walks of the same actions in another order are one node: they pay and take the same, and they end in the same
    region, which follows from the edges flown an odd number of times.

    g is no bound where footprints overlap: taking what pays best a second first can then collect less than another
    choice. Where they do not, the last B is at least the optimum over 1 + eta, once nothing is open.

    Memory: some 100 bytes for each node stored, and no more than one for each way out of each node expanded.

    Parameters
    ----------
    alpha : float             trust in what is still to come, in [0, 1]; 0.8 there
    eta : float               improvements that are not worth the search, as a share of B; 0.005 there
    iterations : float        nodes popped at most; 6000 there; inf: until none is open
    apart : bool              a looser g that lets no action take from what others pay: a bound even where footprints
                              overlap, not in the paper
    early : bool              a walk is a solution as soon as one of the actions that could begin does not fit, and
                              goes on all the same. The paper does not say what complete is; so the values of its
                              first solutions and their number come out, and more runs have one
    """

    alpha: float = 0.8
    eta: float = 0.005
    iterations: float = 6000
    apart: bool = False
    early: bool = False

    def __post_init__(self) -> None:
        _check(self.iterations, self.alpha, self.eta)

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over regions."""
        return single_region_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield at every record of `searched`."""
        return best_walks(problem, self.searched(problem, rng))

    def searched(self, problem: SearchProblem, rng: Generator) -> Iterator[Searched]:
        """Yield every few hundred iterations, and at every solution."""
        tree = _Tree(RegionGround.of(problem))
        return tree.searched(self.iterations, (self.alpha, self.eta, False, self.apart, self.early))


@dataclass(frozen=True)
class DepthFirstBranchAndBound:
    """Branch and bound, last in first out, children in random order [Kuhlman2017, sec. 4.1 and 5].

    As `BranchAndBound`, but with the plain g: prune N where g(N) <= B.

    Parameters
    ----------
    iterations : float        nodes popped at most; inf: until none is open
    apart, early : bool       as in `BranchAndBound`
    """

    iterations: float = 6000
    apart: bool = False
    early: bool = False

    def __post_init__(self) -> None:
        _check(self.iterations, 0.0, 0.0)

    def handles(self, problem: SearchProblem) -> str | None:
        """One searcher over regions."""
        return single_region_searcher(problem)

    def plans(self, problem: SearchProblem, rng: Generator) -> Iterator[Incumbent]:
        """Yield at every record of `searched`."""
        return best_walks(problem, self.searched(problem, rng))

    def searched(self, problem: SearchProblem, rng: Generator) -> Iterator[Searched]:
        """Yield every few hundred iterations, and at every solution."""
        tree = _Tree(RegionGround.of(problem), int(rng.integers(1, 2**31 - 1)))
        return tree.searched(self.iterations, (0.0, 0.0, True, self.apart, self.early))


def _check(iterations: float, alpha: float, eta: float) -> None:
    if not iterations >= 2:
        raise InvalidProblemError(f"{iterations} iterations came; expected at least 2, a start and a first action")
    check_shares(alpha, eta)


def check_shares(alpha: float, eta: float) -> None:
    """Raise InvalidProblemError unless alpha is in [0, 1] and eta at least 0."""
    if not (0.0 <= alpha <= 1.0 and 0.0 <= eta < inf):
        raise InvalidProblemError(f"alpha {alpha} and eta {eta} came; expected alpha in [0, 1] and eta of at least 0")


def best_walks(problem: SearchProblem, records: Iterable[Searched]) -> Iterator[Incumbent]:
    """The best walk so far at every record, gone to where it must end, with what the judge says it is worth."""
    ground = RegionGround.of(problem)
    best: Incumbent | None = None
    judged: tuple[int, ...] = ()
    for record in records:
        if best is None or record.walk != judged:
            judged = record.walk
            plan = Plan.of([*judged, *ground.homeward(ground.walked(judged))])
            value = evaluate(problem, plan).value
            if best is None or value > best.value:
                best = Incumbent(plan, value)
        yield best


def arrays(ground: RegionGround) -> tuple[NDArray[Any], ...]:
    """The ground as the kernels of branch and bound take it."""
    inverse = 1.0 / ground.seconds
    gains = np.pad(ground.gains, ((0, 0), (0, int(ground.before.max(initial=0)))))
    less = -np.diff(gains, axis=1, append=0.0)
    sums = np.cumsum(gains, axis=1) - gains
    rows = np.arange(len(gains)) * gains.shape[1]
    looks = np.repeat(np.arange(ground.n_actions), np.diff(ground.starts)) * len(gains) + ground.atoms
    _, which, repeats = np.unique(looks, return_inverse=True, return_counts=True)
    return (
        ground.seconds, inverse, ground.ends, ground.way_starts, ground.ways, ground.to_last,
        ground.starts, ground.atoms, ground.cover_starts, ground.covers, inverse[ground.covers],
        np.ravel(gains), np.ravel(less), np.ravel(sums), rows,
        ground.before, repeats[which], ground.cover_before,
    )  # fmt: skip


def numbers_of(ground: RegionGround) -> NDArray[np.int64]:
    """(A,) int: a number of each action, so that sums of them tell sets of actions apart.

    Of 62 bits: among a million nodes two sets collide with a probability of 1e-7.
    """
    return np.random.default_rng(0).integers(1, 1 << 62, ground.n_actions)


def quickest(ground: RegionGround) -> int:
    """First action of the shortest walk there is.

    Raises
    ------
    InfeasibleProblemError    where no action leaves time to get to the end
    """
    fits = [
        (float(ground.seconds[action] + ground.to_last[there]), action)
        for action, there in ground.ways_from(ground.first)
        if ground.seconds[action] + ground.to_last[there] <= ground.limit_s + 1e-9
    ]
    if not fits:
        raise InfeasibleProblemError(
            f"no action leaves time to get to the end; what the legs leave of the budget is {ground.limit_s:g} s"
        )
    return min(fits)[1]


class _Tree:
    """Walks as nodes, in plain arrays that grow; see `_branch_kernels` for what they hold."""

    def __init__(self, ground: RegionGround, shuffle: int = 1) -> None:
        from sooner.planners._branch_kernels import NODES, OPEN, SHUFFLED

        self.ground, self.arrays, self.numbers = ground, arrays(ground), numbers_of(ground)
        self.ways = int(np.diff(ground.way_starts).max())
        self.links, self.worth = np.zeros((ROOM, 3), np.int32), np.zeros((ROOM, 3))
        self.keys, self.heap = np.zeros(ROOM, np.int64), np.zeros(ROOM, np.int32)
        self.heap_keys, self.table = np.zeros(ROOM), np.zeros(4 * ROOM, np.int64)
        self.state = np.zeros(8, np.int64)
        self.state[[NODES, OPEN, SHUFFLED]] = 1, 1, shuffle
        self.links[0] = -1, -1, ground.first
        self.worth[0] = ground.leg_value, ground.limit_s, inf
        self.best = np.array([-inf, -inf])
        self.walk: tuple[int, ...] = (quickest(ground),)

    def searched(self, iterations: float, settings: tuple[float, float, bool, bool, bool]) -> Iterator[Searched]:
        """Records of the search; settings are alpha, eta, depth_first, apart and early."""
        from sooner.planners._branch_kernels import OPEN, POPPED, branch

        began = time.perf_counter()
        first_s, first_value = nan, nan
        while self.state[OPEN] and self.state[POPPED] < iterations:
            self._make_room(TICK * self.ways)
            until = int(min(self.state[POPPED] + TICK, iterations))
            solution, furthest = branch(
                self.arrays, self.numbers, self.links, self.worth, self.keys, self.heap_keys, self.heap, self.table,
                self.state, self.best, *settings, until,
            )  # fmt: skip
            now = time.perf_counter() - began
            if solution >= 0 and not isfinite(first_s):
                first_s, first_value = now, float(self.best[0])
            if furthest >= 0:
                self.walk = self._walk(furthest)
            yield self._record(now, first_s, first_value)

    def _make_room(self, more: int) -> None:
        """For so many nodes more, and a table that stays half empty."""
        from sooner.planners._branch_kernels import NODES, SEEN, moved

        need = int(self.state[NODES]) + more
        if need > len(self.keys):
            rows = max(need, 2 * len(self.keys))
            for name in ("links", "worth", "keys", "heap", "heap_keys"):
                old = getattr(self, name)
                new = np.zeros((rows, *old.shape[1:]), old.dtype)
                new[: len(old)] = old
                setattr(self, name, new)
        if 2 * (int(self.state[SEEN]) + more) > len(self.table):
            larger = np.zeros(1 << (4 * (int(self.state[SEEN]) + more)).bit_length(), np.int64)
            moved(self.table, larger)
            self.table = larger

    def _walk(self, node: int) -> tuple[int, ...]:
        actions: list[int] = []
        while node > 0:
            before, action, _ = self.links[node].tolist()
            actions.append(action)
            node = before
        return tuple(reversed(actions))

    def _record(self, seconds: float, first_s: float, first_value: float) -> Searched:
        from sooner.planners._branch_kernels import EXPANDED, GENERATED, NODES, OPEN, POPPED, SEEN, SOLVED

        popped, expanded, generated, seen, nodes, solved = self.state[
            [POPPED, EXPANDED, GENERATED, SEEN, NODES, SOLVED]
        ].tolist()
        return Searched(
            popped, expanded, generated, seen, nodes, solved, seconds, first_s, first_value,
            float(self.best[0]), self.walk, not self.state[OPEN],
        )  # fmt: skip
