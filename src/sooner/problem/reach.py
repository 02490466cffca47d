"""Reach: which steps leave a way to finish, so that a planner never flies into a corner it cannot leave."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InfeasibleProblemError
from sooner.grid import Grid
from sooner.problem.moves import CellMoves
from sooner.problem.search_problem import Searcher

__all__ = ["Reach"]


@dataclass(frozen=True, eq=False)
class Reach:
    """What one searcher over cells can still do from wherever it is.

    A copter can finish if its end is no further than the steps that are left, for it can hover. A fixed wing cannot
    turn back, so what it can do depends on where it came from: for every (cell, cell before) the fewest steps to the
    end and which larger numbers also do (exact for 48 more, then the last 24 repeat), or, without an end, how far
    it can fly before it is stuck.

    Parameters
    ----------
    grid : Grid
    searcher : Searcher       with `CellMoves`

    Examples
    --------
    >>> reach = Reach(Grid((1, 5)), Searcher((0, 0), budget=4, moves=CellMoves("fixed_wing")))
    >>> reach.can_go_on(1, 0, 3), reach.can_go_on(1, 0, 4)
    (True, False)
    """

    grid: Grid
    searcher: Searcher

    def can_go_on(self, cell: int, came_from: int, steps: int) -> bool:
        """Whether exactly `steps` more steps can be flown from `cell`; `came_from` -1 means heading free."""
        from sooner.problem import _kernels

        kernel: Any = _kernels.can_go_on
        return bool(kernel(*self.arrays, cell, came_from, steps))

    def check(self) -> None:
        """Raise InfeasibleProblemError unless the searcher can fly its whole budget from the start."""
        start, came_from = self.start, self.came_from
        if not self.can_go_on(start, came_from, self.searcher.steps):
            raise InfeasibleProblemError(
                f"no flight of {self.searcher.steps} steps from {list(self.searcher.start)}"
                + (f" to {list(self.searcher.end)}" if self.searcher.end is not None else "")
                + " keeps every rule: a fixed wing is stuck before; give other steps, or a copter"
            )

    @property
    def start(self) -> int:
        """Number of the start cell."""
        return self.grid.index(self.searcher.start)

    @property
    def end(self) -> int:
        """Number of the end cell, -1 where there is none."""
        return -1 if self.searcher.end is None else self.grid.index(self.searcher.end)

    @property
    def came_from(self) -> int:
        """Number of the cell before the start, -1 where the heading is free."""
        return -1 if self.searcher.came_from is None else self.grid.index(self.searcher.came_from)

    @property
    def fixed_wing(self) -> bool:
        """Whether it can neither hover nor turn straight back."""
        moves = self.searcher.moves
        return isinstance(moves, CellMoves) and moves.kind == "fixed_wing"

    @cached_property
    def arrays(self) -> tuple[Any, ...]:
        """The leading arguments of the kernel `can_go_on`."""
        from sooner.problem._kernels import steps_to_end, steps_until_stuck

        neighbours, has_end = self.grid.neighbours, self.end >= 0
        to_end: NDArray[np.int32] = self.grid.distances_from(self.end) if has_end else np.zeros(0, np.int32)
        least, also, most = np.zeros(0, np.int32), np.zeros(0, np.int64), np.zeros(0, np.int32)
        if self.fixed_wing and has_end:
            least, also = steps_to_end(neighbours, self.end)
        elif self.fixed_wing:
            most = steps_until_stuck(neighbours)
        return neighbours, self.fixed_wing, has_end, to_end, least, also, most
