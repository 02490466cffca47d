"""What planning buys: the classic search patterns, flown by the same drones, and judged by the same judge."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from sooner.errors import InfeasibleProblemError, UnsupportedProblemError
from sooner.missions.mission_file import Mission
from sooner.planners import Status, max_seconds, solve
from sooner.planners.registry import PLANNERS, make_planner
from sooner.problem import evaluate

__all__ = ["Pattern", "patterns"]


@dataclass(frozen=True)
class Pattern:
    """A pattern on this mission.

    Parameters
    ----------
    name : str
    value : float
    cut_short : bool        whether its time was up before every way of drawing it had been tried
    """

    name: str
    value: float
    cut_short: bool

    def result(self) -> dict[str, Any]:
        """For JSON."""
        return {"planner": self.name, "value": self.value, "cut_short": self.cut_short}


def patterns(mission: Mission, seconds: float) -> tuple[Pattern, ...]:
    """Every pattern that can be flown on a mission over legs, the best first; none over cells and regions.

    Parameters
    ----------
    seconds : float         for all of them together; each is drawn in one way at least

    Raises
    ------
    KeyboardInterrupt       also where a planner by itself would answer it with its best plan so far
    """
    if not mission.over_legs:
        return ()
    names = [name for name, entry in PLANNERS.items() if entry.moves == ("legs",)]
    found = [each for name in names for each in _flown(mission, name, seconds / len(names))]
    return tuple(sorted(found, key=lambda each: -each.value))


def _flown(mission: Mission, name: str, seconds: float) -> Iterator[Pattern]:
    """The pattern, unless it cannot be flown here, as a contour where nobody knows heights."""
    try:
        solution = solve(mission.problem, make_planner(name), stop=max_seconds(seconds))
    except (UnsupportedProblemError, InfeasibleProblemError):
        return
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt  # whoever presses Ctrl-C wants no report, and not the next pattern either
    value = evaluate(mission.problem, solution.best.plan).total
    yield Pattern(name, value, solution.status is Status.STOPPED)
