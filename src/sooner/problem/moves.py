"""Moves: which actions are open to a searcher, how long they take and what they look at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InfeasibleProblemError, InvalidProblemError

if TYPE_CHECKING:
    from sooner.grid import Grid
    from sooner.problem.search_problem import Searcher

__all__ = ["CellMoves", "Looks", "Moves"]


@dataclass(frozen=True, eq=False)
class Looks:
    """What one searcher looks at, in order of time.

    Parameters
    ----------
    items : (n,) int          rows of the gain table: cells here, atoms where regions move
    times : (n,) float        when, in the problem's unit of time (steps for cell moves)
    worth : (n,) float        how many looks each is worth; None: one each
    """

    items: NDArray[np.int64]
    times: NDArray[np.float64]
    worth: NDArray[np.float64] | None = None


class Moves(Protocol):
    """What a model of moves must answer; cells here, regions and legs beside it."""

    @property
    def departs_s(self) -> float:
        """When its budget begins, in the problem's unit of time; not 0 for a battery after the first."""

    def check(self, grid: Grid, searcher: Searcher) -> None:
        """Raise InvalidProblemError where no plan can be posed, InfeasibleProblemError where none is legal."""

    def n_items(self, grid: Grid) -> int:
        """How many rows the gain table has: cells here, atoms where regions move."""

    def fault(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> str | None:
        """Why these actions are not legal, or None if they are."""

    def looks(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> Looks:
        """What legal actions look at, and when."""


@dataclass(frozen=True)
class CellMoves:
    """One cell a step: to a neighbour, or, for a copter, to the same cell again (hover).

    A fixed wing neither hovers nor turns straight back to the cell it came from; its first move is free unless the
    searcher `came_from` somewhere. The start cell is looked at when t = 0, every later cell when it is reached.

    Parameters
    ----------
    kind : str                "copter" or "fixed_wing"
    step_s : float            seconds that one step takes
    """

    kind: Literal["copter", "fixed_wing"] = "copter"
    step_s: float = 1.0
    departs_s: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        if self.kind not in ("copter", "fixed_wing"):
            raise InvalidProblemError(f"kind {self.kind!r} came; expected 'copter' or 'fixed_wing'")
        if not (np.isfinite(self.step_s) and self.step_s > 0):
            raise InvalidProblemError(f"a step of {self.step_s} s came; expected a positive number")

    def check(self, grid: Grid, searcher: Searcher) -> None:
        """A whole number of steps; an end in reach."""
        if not isinstance(searcher.budget, int | np.integer):
            raise InvalidProblemError(f"a budget of {searcher.budget} steps came; expected a whole number")
        if searcher.budget < 1:
            raise InvalidProblemError(f"a budget of {searcher.budget} steps came; expected at least 1")
        start = grid.index(searcher.start)
        if searcher.came_from is not None and start not in grid.neighbours[grid.index(searcher.came_from)]:
            raise InvalidProblemError(
                f"came_from {list(searcher.came_from)} came; expected a neighbour of the start {list(searcher.start)}"
            )
        if searcher.end is not None:
            self._check_end(grid, searcher, int(grid.distances_from(start)[grid.index(searcher.end)]))

    def _check_end(self, grid: Grid, searcher: Searcher, steps: int) -> None:
        """Distance, and parity: on a chessboard, who cannot wait ends after T steps on a cell of T's colour."""
        start, end = list(searcher.start), list(searcher.end or ())
        if steps < 0:
            raise InfeasibleProblemError(f"end {end} cannot be reached from {start}")
        if steps > searcher.steps:
            raise InfeasibleProblemError(
                f"end {end} lies {steps} steps from the start {start}; the budget is {searcher.steps} steps"
            )
        if self.kind == "fixed_wing" and grid.connectivity == "square4" and (searcher.steps - steps) % 2:
            raise InfeasibleProblemError(
                f"end {end} lies {steps} steps from the start {start}: a fixed wing, which cannot hover, is never "
                f"there after {searcher.steps} steps; give {searcher.steps - 1} or {searcher.steps + 1} steps"
            )

    def n_items(self, grid: Grid) -> int:
        """One row for each cell."""
        return grid.n_cells

    def fault(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> str | None:
        """Why this sequence of cells cannot be flown, or None if it can."""
        if actions.ndim != 1 or len(actions) == 0:
            return "it has no cells; expected at least the start cell"
        if len(actions) - 1 > searcher.steps:
            return f"it takes {len(actions) - 1} steps; the budget is {searcher.steps}"
        outside = (actions < 0) | (actions >= grid.n_cells)
        if outside.any():
            return f"step {int(np.argmax(outside))} lies outside the map"
        start = grid.index(searcher.start)
        if actions[0] != start:
            return f"it starts at {_at(grid, actions[0])}; the start is {_at(grid, start)}"
        if searcher.end is not None and actions[-1] != grid.index(searcher.end):
            return f"it ends at {_at(grid, actions[-1])}; the end is {list(searcher.end)}"
        return self._broken_step(grid, searcher, actions)

    def _broken_step(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> str | None:
        hover = actions[1:] == actions[:-1]
        adjacent = (grid.neighbours[actions[:-1]] == actions[1:, None]).any(axis=1)
        illegal = ~(adjacent | hover)
        if illegal.any():
            step = int(np.argmax(illegal))
            here, there = _at(grid, actions[step]), _at(grid, actions[step + 1])
            why = _why_not_adjacent(grid, int(actions[step]), int(actions[step + 1]))
            return f"step {step + 1} goes from {here} to {there}: {why}"
        if self.kind == "copter":
            return None
        if hover.any():
            step = int(np.argmax(hover))
            return f"step {step + 1} hovers at {_at(grid, actions[step])}: a fixed wing cannot"
        previous = np.concatenate(
            [[-1 if searcher.came_from is None else grid.index(searcher.came_from)], actions[:-2]]
        )[: len(actions) - 1]
        back = actions[1:] == previous
        if back.any():
            step = int(np.argmax(back))
            return f"step {step + 1} turns straight back to {_at(grid, actions[step + 1])}: a fixed wing cannot"
        return None

    def looks(self, grid: Grid, searcher: Searcher, actions: NDArray[np.int64]) -> Looks:
        """One look at every cell of the sequence, one step apart."""
        return Looks(actions, np.arange(len(actions), dtype=np.float64))


def _why_not_adjacent(grid: Grid, here: int, there: int) -> str:
    if not grid.passable[there]:
        return "an obstacle stands there"
    (row, col), (other_row, other_col) = grid.cell(here), grid.cell(there)
    if grid.connectivity == "square8" and abs(row - other_row) == 1 and abs(col - other_col) == 1:
        return "that cuts the corner of an obstacle"
    return "they are not neighbours"


def _at(grid: Grid, index: int | np.integer) -> str:
    row, col = grid.cell(int(index))
    return f"[{row}, {col}]"
