"""Plan: what every searcher does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sooner.errors import InvalidProblemError

__all__ = ["Plan"]


@dataclass(frozen=True, eq=False)
class Plan:
    """A sequence of actions for each searcher; cells, looks and times derive from it.

    What an action is, the searcher's moves say. For cell moves it is the number of the cell that is looked at:
    the start cell at time 0, then one cell a step, so that T steps make T + 1 actions.

    Parameters
    ----------
    actions : one (n,) int array per searcher

    Examples
    --------
    >>> Plan.of([0, 1, 1]) == Plan.of([0, 1, 1])
    True
    """

    actions: tuple[NDArray[np.int64], ...]

    def __post_init__(self) -> None:
        frozen = []
        for actions in self.actions:
            given = np.asarray(actions)
            if given.size and given.dtype.kind not in "iu":
                raise InvalidProblemError(f"actions of type {given.dtype} came; expected whole numbers")
            copy = np.array(given, np.int64)
            copy.setflags(write=False)
            frozen.append(copy)
        object.__setattr__(self, "actions", tuple(frozen))

    @classmethod
    def of(cls, *actions: ArrayLike | Sequence[int]) -> Plan:
        """A plan from one sequence of actions per searcher."""
        return cls(tuple(np.asarray(a) for a in actions))

    def __eq__(self, other: Any) -> bool:
        if not isinstance(other, Plan):
            return NotImplemented
        return len(self.actions) == len(other.actions) and all(
            np.array_equal(a, b) for a, b in zip(self.actions, other.actions, strict=True)
        )

    def __hash__(self) -> int:
        return hash(tuple(a.tobytes() for a in self.actions))
