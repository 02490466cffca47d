"""Remainder: the problem that is left when the first steps of a flight are flown and have found nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sooner.problem.evaluate import filtered
from sooner.problem.gains import Gains
from sooner.problem.moves import CellMoves
from sooner.problem.plan import Plan
from sooner.problem.search_problem import Searcher, SearchProblem

__all__ = ["joined", "remainder"]


def remainder(problem: SearchProblem, flown: NDArray[np.int64]) -> SearchProblem:
    """What is left of a one-searcher problem over cells when it has just arrived at the last of `flown`.

    Every cell before the last has been looked at and was empty; the look at the last, where the remaining flight
    starts, is still to come. So for every plan `rest` of the remainder

        total(problem, joined(flown, rest)) = total of the looks at flown[:-1] + total(remainder, rest)

    Parameters
    ----------
    problem : SearchProblem     one searcher that moves over cells
    flown : (n,) int            cells flown so far, the start among them; 1 <= n <= budget

    Examples
    --------
    >>> from sooner.belief import Belief
    >>> from sooner.grid import Grid
    >>> from sooner.problem import detection_gains
    >>> gains = detection_gains(Belief.from_weights([[1.0, 2.0, 1.0]]), 0.5)
    >>> problem = SearchProblem(Grid((1, 3)), gains, (Searcher((0, 0), budget=2),))
    >>> rest = remainder(problem, np.array([0, 1]))
    >>> rest.searcher.start, rest.searcher.budget, rest.gains.first
    ((0, 1), 1, array([0.0625, 0.25  , 0.125 ]))
    """
    looked = flown[:-1]
    ahead = (_ahead(problem, flown),)
    if problem.drift is None:
        counts = np.bincount(looked, minlength=problem.grid.n_cells)
        return replace(problem, gains=problem.gains.after(counts), searchers=ahead)
    mass, _ = filtered(problem.drift, looked, np.arange(len(looked)), until=len(looked))
    drift = replace(problem.drift, poc=mass)
    return replace(problem, gains=Gains.independent(mass, drift.glimpse), searchers=ahead, drift=drift)


def joined(flown: NDArray[np.int64], rest: NDArray[np.int64]) -> Plan:
    """One plan of the cells flown and a plan of the remainder, which starts where they end."""
    return Plan.of(np.concatenate([flown, rest[1:]]))


def _ahead(problem: SearchProblem, flown: NDArray[np.int64]) -> Searcher:
    searcher = problem.searcher
    came_from = searcher.came_from
    if len(flown) > 1:
        fixed_wing = isinstance(searcher.moves, CellMoves) and searcher.moves.kind == "fixed_wing"
        came_from = problem.grid.cell(int(flown[-2])) if fixed_wing else None
    return replace(
        searcher,
        start=problem.grid.cell(int(flown[-1])),
        budget=searcher.steps - (len(flown) - 1),
        came_from=came_from,
    )
