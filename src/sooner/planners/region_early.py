"""A plan over regions that gives up a little of its total to collect earlier."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.planners.planner import refuse_unhandled
from sooner.planners.region_anneal import RegionAnneal
from sooner.problem import Plan, SearchProblem, evaluate
from sooner.problem.region_ground import RegionGround

__all__ = ["brought_forward"]

WALKS, MOVES = 6, 100_000
PRICE = 5.0  # what a unit below the least total costs, in missions' lengths
HOT, COLD = 0.3, 0.003  # in the mean area of an action
ROOM = 64  # actions that a walk may grow by at least
DRAWS = 17  # a move's random numbers


def brought_forward(
    problem: SearchProblem,
    plan: Plan,
    keep: float = 0.995,
    walks: int = WALKS,
    moves: int = MOVES,
    seed: int = 0,
) -> Plan:
    """A plan with a larger `Evaluation.early_share` that keeps this share of the total.

    Whole walks are annealed (Kirkpatrick et al. 1983), of which the area under the curve of gains counts: closed
    walks change places or turn round, searches and detours come and go, stretches give way to the quickest way. The
    best of some begun from the plan goes on, colder.

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
    UnsupportedProblemError    unless one searcher moves over regions, as for `RegionAnneal`
    InvalidProblemError        if `keep` is no share
    """
    refuse_unhandled(problem, RegionAnneal())
    if not 0.0 < keep <= 1.0:
        raise InvalidProblemError(f"keep = {keep} came; expected a share of the total, above 0 and at most 1")
    ground = RegionGround.of(problem)
    least = keep * (evaluate(problem, plan).total - 1e-12) - ground.leg_value
    rng = np.random.default_rng(seed)
    nexts = quickest_edges(ground)
    begun = [_annealed(ground, nexts, plan.actions[0], least, rng.random((moves, DRAWS)), HOT) for _ in range(walks)]
    best = max(begun, key=lambda walk: _area(ground, walk), default=plan.actions[0])
    best = _annealed(ground, nexts, best, least, rng.random((moves, DRAWS)), HOT / 4)
    found = Plan.of(best.tolist())
    earlier = evaluate(problem, found).early_share > evaluate(problem, plan).early_share
    return found if earlier else plan


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
    walk = np.zeros(2 * count + ROOM, np.int64)
    walk[:count] = actions
    unit = _area(ground, actions) / count
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
