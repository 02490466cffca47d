"""A plan over regions that gives up a little of its total to collect earlier."""

from __future__ import annotations

import time

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.planners.planner import refuse_unhandled
from sooner.planners.region_anneal import RegionAnneal
from sooner.planners.team import left_for
from sooner.problem import Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround

__all__ = ["KEEP", "brought_forward", "brought_forward_within"]

KEEP = 0.995  # of the total, for the sake of the area
WALKS, MOVES = 6, 100_000
SOME = 2_000  # moves from which it is seen how many a second makes
PRICE = 5.0  # what a unit below the least total costs, in missions' lengths
HOT, COLD = 0.3, 0.003  # in the mean area of an action
ROOM = 64  # actions that a walk may grow by at least
DRAWS = 17  # a move's random numbers


def brought_forward(
    problem: SearchProblem,
    plan: Plan,
    keep: float = KEEP,
    walks: int = WALKS,
    moves: int = MOVES,
    seed: int = 0,
) -> Plan:
    """A plan with a larger `Evaluation.early_share` that keeps this share of the total.

    Whole walks are annealed (Kirkpatrick et al. 1983), of which the area under the curve of gains counts: closed
    walks change places or turn round, searches and detours come and go, stretches give way to the quickest way. The
    best of some begun from the plan goes on, colder. Of a team each in turn, for what the others leave.

    Parameters
    ----------
    plan : Plan                as a planner found it
    keep : float               least total, as a share of the plan's
    walks, moves : int         so many walks make so many moves each, and the best as many again

    Returns
    -------
    Plan                       the plan itself where no better one was found

    Raises
    ------
    UnsupportedProblemError    unless searchers move over regions, for the most by the end, as for `RegionAnneal`
    InvalidProblemError        if `keep` is no share
    """
    if not 0.0 < keep <= 1.0:
        raise InvalidProblemError(f"keep = {keep} came; expected a share of the total, above 0 and at most 1")
    least = keep * (evaluate(problem, plan).total - 1e-12)
    rng = np.random.default_rng(seed)
    for number in range(len(problem.searchers)):
        plan = _one_forward(problem, plan, number, least, walks, moves, rng)
    return plan


def brought_forward_within(problem: SearchProblem, plan: Plan, seconds: float, keep: float = KEEP) -> Plan:
    """As `brought_forward`, with about as many moves as this time allows, at most those of its defaults."""
    share_s = seconds / len(problem.searchers)
    brought_forward(problem, plan, keep, walks=1, moves=2)  # what is compiled is loaded before it is timed
    began = time.perf_counter()
    early = brought_forward(problem, plan, keep, walks=1, moves=SOME)
    rate = 2 * SOME * len(problem.searchers) / max(time.perf_counter() - began, 1e-9)
    moves = min(int(rate * share_s / (WALKS + 1)), MOVES)
    return brought_forward(problem, plan, keep, moves=moves) if moves > SOME else early


def _one_forward(
    problem: SearchProblem, plan: Plan, number: int, least: float, walks: int, moves: int, rng: Generator
) -> Plan:
    """The plan with the flight of one searcher brought forward, while all together still collect `least`."""
    flights = dict(enumerate(plan.actions))
    own = flights.pop(number)
    alone = left_for(problem, number, flights)
    refuse_unhandled(alone, RegionAnneal())
    before, ground = evaluate(problem, plan), RegionGround.of(alone)
    needed = least - (before.total - evaluate(alone, Plan.of(own)).total) - ground.leg_value
    nexts = quickest_edges(ground)
    begun = [_annealed(ground, nexts, own, needed, rng.random((moves, DRAWS)), HOT) for _ in range(walks)]
    best = max(begun, key=lambda walk: _area(ground, walk), default=own)
    best = _annealed(ground, nexts, best, needed, rng.random((moves, DRAWS)), HOT / 4)
    found = Plan.of(*plan.actions[:number], best.tolist(), *plan.actions[number + 1 :])
    after = evaluate(problem, found)
    return found if after.early_share > before.early_share and after.total >= least else plan


def quickest_edges(ground: RegionGround) -> NDArray[np.int64]:
    """(R, R) int: the edge to fly first from one region to another, the quickest way; -1 to itself."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    count, (one, other) = ground.n_regions, ground.ends[ground.n_regions :].T
    seconds, edge = ground.seconds[ground.n_regions :], np.full((count, count), -1, np.int64)
    edge[one, other] = edge[other, one] = np.arange(ground.n_regions, ground.n_actions)
    links = coo_array((seconds, (one, other)), shape=(count, count)).tocsr()
    before = dijkstra(links, directed=False, return_predecessors=True)[1]  # as seen from the goal, the next
    goal, here = np.nonzero(before >= 0)
    nexts = np.full((count, count), -1, np.int64)
    nexts[here, goal] = edge[here, before[goal, here]]
    return nexts


def _annealed(
    ground: RegionGround,
    nexts: NDArray[np.int64],
    actions: NDArray[np.int64],
    least: float,
    draws: NDArray[np.float64],
    hot: float,
) -> NDArray[np.int64]:
    from sooner.planners._early_kernels import anneal_early

    starts, atoms, _, _, way_starts, ways, ends = ground.arrays
    count = len(actions)
    area = _area(ground, actions)
    if area <= 0.0:  # the others have left it nothing to find
        return actions
    walk = np.zeros(2 * count + ROOM, np.int64)
    walk[:count] = actions
    unit = area / count
    count = anneal_early(
        starts, atoms, way_starts, ways, ends, nexts, ground.seconds, ground.gains, ground.limit_s, ground.first,
        ground.last < 0, least, PRICE * ground.limit_s, hot * unit, COLD * unit, draws, walk, count,
    )  # fmt: skip
    return walk[:count]


def _area(ground: RegionGround, walk: NDArray[np.int64]) -> float:
    from sooner.planners._early_kernels import worth

    looks = np.zeros(len(ground.gains), np.int64)
    found: tuple[float, float] = worth(
        ground.starts, ground.atoms, ground.seconds, ground.gains, ground.limit_s, looks, walk, len(walk)
    )
    return found[1]
