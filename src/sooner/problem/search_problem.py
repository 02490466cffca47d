"""SearchProblem: the question that every planner is asked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.problem.gains import Gains
from sooner.problem.moves import CellMoves, Moves

if TYPE_CHECKING:
    from sooner.problem.teleport import Teleport

__all__ = ["Drift", "Objective", "SearchProblem", "Searcher"]


@dataclass(frozen=True)
class Objective:
    """What is good: the most by the end, or a given CDP as soon as possible.

    Parameters
    ----------
    kind : str                 what gains count: "detection" or "information"
    target : float or None     reach this total soonest; the value of a plan is then minus the time it takes,
                               minus infinity where it never does

    Raises
    ------
    InvalidProblemError        if the target is not positive, or a detection target passes 1
    """

    kind: Literal["detection", "information"] = "detection"
    target: float | None = None

    def __post_init__(self) -> None:
        if self.target is None:
            return
        if not (np.isfinite(self.target) and self.target > 0 and (self.kind != "detection" or self.target <= 1)):
            raise InvalidProblemError(
                f"a {self.kind} target of {self.target} came; expected a probability above 0 and at most 1"
            )


@dataclass(frozen=True)
class Searcher:
    """A drone: where it starts and ends, how it moves, how long it flies.

    Parameters
    ----------
    start : (row, col)
    budget : number            the time it flies, in the unit of its moves: steps T over cells (a plan has at most T + 1
                               cells, the start among them), seconds over regions
    end : (row, col) or None   where it must be at the end of its plan
    moves : Moves
    came_from : (row, col)     the cell before the start, where a fixed wing is already in flight; None: heading free
    """

    start: tuple[int, int]
    budget: int | float
    end: tuple[int, int] | None = None
    moves: Moves = CellMoves()
    came_from: tuple[int, int] | None = None

    @property
    def steps(self) -> int:
        """The budget of a searcher that moves over cells."""
        return int(self.budget)

    @property
    def until(self) -> float:
        """When its budget ends; one that departs later than the first ends later."""
        return float(self.budget) + self.moves.departs_s


@dataclass(frozen=True, eq=False)
class Drift:
    """A person who moves while we search: a Markov chain over cells, and what a look sees of it.

    Parameters
    ----------
    poc : (N,) float           where the person may be at time 0
    glimpse : (N,) float       P(detect in one look | there)
    transition : (N, N) sparse P(to j | from i) in one step; what is missing from one in a row leaves the map
    """

    poc: NDArray[np.float64]
    glimpse: NDArray[np.float64]
    transition: Any


@dataclass(frozen=True, eq=False)
class SearchProblem:
    """A map of gains, the drones that collect them, and what is good.

    Parameters
    ----------
    grid : Grid                where things are
    gains : Gains              what the k-th look at each cell pays, (N, L)
    searchers : tuple          one or more `Searcher`
    objective : Objective
    drift : Drift or None      where the person moves: gains then hold at time 0 only

    Raises
    ------
    InvalidProblemError        if a part does not fit the others: start on an obstacle, gains of another map
    InfeasibleProblemError     if no legal plan exists: the end cell is too far, or has the wrong parity

    Examples
    --------
    >>> from sooner.belief import Belief
    >>> from sooner.problem import detection_gains
    >>> belief = Belief.from_weights([[1.0, 2.0, 1.0]])
    >>> problem = SearchProblem(Grid((1, 3)), detection_gains(belief, 0.5), (Searcher((0, 0), budget=2),))
    >>> problem.searcher.budget
    2
    """

    grid: Grid
    gains: Gains
    searchers: tuple[Searcher, ...]
    objective: Objective = Objective()
    drift: Drift | None = None

    def __post_init__(self) -> None:
        if not self.searchers:
            raise InvalidProblemError("no searcher came; expected at least one")
        for number, searcher in enumerate(self.searchers):
            items = searcher.moves.n_items(self.grid)
            if self.gains.n_cells != items:
                raise InvalidProblemError(f"gains of {self.gains.n_cells} cells came; the grid has {items}")
            try:
                _check_searcher(self.grid, searcher)
            except InvalidProblemError as error:
                raise type(error)(f"searcher {number}: {error}") from None

    @property
    def searcher(self) -> Searcher:
        """The only searcher, for planners that handle one."""
        if len(self.searchers) != 1:
            raise InvalidProblemError(f"{len(self.searchers)} searchers came; expected one")
        return self.searchers[0]

    @cached_property
    def teleport(self) -> Teleport:
        """The reference that no flight can pass (see `sooner.problem.teleport`), worked out once."""
        from sooner.problem.teleport import teleport

        return teleport(self)


def _check_searcher(grid: Grid, searcher: Searcher) -> None:
    whole = (*searcher.start, *(searcher.end or ()), *(searcher.came_from or ()))
    if not all(isinstance(number, int | np.integer) for number in whole):
        raise InvalidProblemError(f"cells of {searcher} came; expected whole numbers")
    start = grid.index(searcher.start)
    if not grid.passable[start]:
        raise InvalidProblemError(f"start {list(searcher.start)} came; an obstacle stands there")
    if searcher.end is not None and not grid.passable[grid.index(searcher.end)]:
        raise InvalidProblemError(f"end {list(searcher.end)} came; an obstacle stands there")
    searcher.moves.check(grid, searcher)
