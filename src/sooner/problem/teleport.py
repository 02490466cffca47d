"""Teleport: the most that looks could collect if a drone could jump, the papers' yardstick for efficiency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sooner.errors import UnsupportedProblemError
from sooner.problem.moves import CellMoves

if TYPE_CHECKING:
    from sooner.grid import Grid
    from sooner.problem.search_problem import Searcher, SearchProblem

__all__ = ["Teleport", "teleport"]


@dataclass(frozen=True, eq=False)
class Teleport:
    """What teleporting collects.

    Parameters
    ----------
    value : float             the best glimpses in all the time there is; no flight collects more
    curve : (n,) float        total after 1, 2, ..., n glimpses, best first
    delay : int               steps in which even the quickest searcher sees nothing
    abreast : int             searchers, so glimpses at each step
    """

    value: float
    curve: NDArray[np.float64]
    delay: int
    abreast: int = 1

    def time_to(self, target: float) -> float:
        """Steps after which teleporting reaches `target`; inf where it never does."""
        reached = self.curve >= target
        return float(self.delay + int(np.argmax(reached)) // self.abreast) if reached.any() else np.inf


def teleport(problem: SearchProblem) -> Teleport:
    """The best T + 1 - delta glimpses of the whole map, in any order from anywhere.

    delta = steps from the start to the nearest cell that pays, and the same for the end   [Lin2014, sec. II-B]

    Several searchers pool their glimpses. Distances are those of the problem's own graph, and cells that no
    searcher can visit in time (and still reach its end) do not count; on the paper's maps all cells do.

    Raises
    ------
    UnsupportedProblemError    where the person moves, or moves are not over cells

    Examples
    --------
    >>> from sooner.problem import Gains, Searcher, SearchProblem
    >>> from sooner.grid import Grid
    >>> gains = Gains.independent(np.array([0.0, 0.0, 0.75, 0.25]), np.array([1.0, 1.0, 0.5, 1.0]))
    >>> teleport(SearchProblem(Grid((1, 4)), gains, (Searcher((0, 0), budget=4),))).value
    0.8125
    """
    if problem.drift is not None:
        raise UnsupportedProblemError("the person moves: teleporting over a still map is no reference")
    pays = problem.gains.first > 0
    reachable = np.zeros(problem.grid.n_cells, bool)
    glimpses, delays = 0, []
    for searcher in problem.searchers:
        within, delay, spare = _reach(problem.grid, searcher, pays)
        reachable |= within
        glimpses += max(searcher.steps + 1 - spare, 0)
        delays.append(delay)
    curve = np.cumsum(_best_glimpses(problem, reachable & pays, glimpses))
    return Teleport(float(curve[-1]) if len(curve) else 0.0, curve, min(delays), len(problem.searchers))


def _reach(grid: Grid, searcher: Searcher, pays: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], int, int]:
    """Cells that can be visited in time; steps before the first that pays; steps lost at both ends."""
    if not isinstance(searcher.moves, CellMoves):
        raise UnsupportedProblemError("teleport needs moves over cells")
    there = grid.distances_from(grid.index(searcher.start))
    back = np.zeros_like(there) if searcher.end is None else grid.distances_from(grid.index(searcher.end))
    within = (there >= 0) & (back >= 0) & (there + back <= searcher.steps)
    if not (within & pays).any():
        return within, searcher.steps + 1, searcher.steps + 1
    delay = int(there[within & pays].min())
    return within, delay, delay + int(back[within & pays].min())


def _best_glimpses(problem: SearchProblem, cells: NDArray[np.bool_], count: int) -> NDArray[np.float64]:
    """The `count` largest gains over cells and looks, largest first (fewer where no more pay)."""
    gains = problem.gains
    candidates = np.flatnonzero(cells)
    if count == 0 or candidates.size == 0:
        return np.zeros(0)
    if candidates.size > count:  # a cell outside the best `count` first looks can add nothing
        candidates = candidates[np.argpartition(-gains.first[candidates], count - 1)[:count]]
    best = np.sort(gains.first[candidates])[::-1]
    look = 1
    while candidates.size and look < count:
        more = gains.of(candidates, np.full(candidates.size, look))
        floor = best[count - 1] if best.size >= count else 0.0
        candidates, more = candidates[more > floor], more[more > floor]
        best = np.sort(np.concatenate([best, more]))[::-1][:count]
        look += 1
    return best
