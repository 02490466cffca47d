"""Where each flight goes and when, in metres of the grid's frame, whatever it moves over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sooner.missions.leg_flights import label
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score
from sooner.problem.leg_moves import LegMoves, places_of
from sooner.problem.regions import RegionMoves

__all__ = ["Line", "flown_lines", "name_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Line:
    """What one searcher flies.

    Parameters
    ----------
    points : (n, 2) float      metres east and north of the south-west cell's centre; cells where nobody knows metres
    times : (n,) float         since the search began, in the judge's unit
    """

    points: Floats
    times: Floats


def flown_lines(score: Score) -> tuple[Line, ...]:
    """One line for each searcher of the plan."""
    found, problem = [], score.mission.problem
    for searcher, actions in zip(problem.searchers, score.plan.actions, strict=True):
        moves = searcher.moves
        if isinstance(moves, LegMoves):
            found.append(Line(places_of(actions), moves.departs_s + moves.flight(actions).times))
        elif isinstance(moves, RegionMoves):
            found.append(Line(*moves.timed(actions)))
        else:
            found.append(Line(problem.grid.centres_m[actions], np.arange(len(actions), dtype=np.float64)))
    return tuple(found)


def name_of(mission: Mission, number: int) -> str:
    """How a flight is called beside the others: by its drone, and its battery where that has several."""
    return label(mission, number) if mission.over_legs else f"drone {number}"
