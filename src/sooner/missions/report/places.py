"""The richest places that a plan leaves: squares that hold the most of what is still to be found."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.missions.score import Score

__all__ = ["MOST", "RichPlace", "richest"]

MOST = 5  # places that are told
ACROSS = 12  # squares side by side on a square map
LEAST = 0.005  # share of all that is left which is worth telling


@dataclass(frozen=True)
class RichPlace:
    """A square of cells.

    Parameters
    ----------
    letter : str
    row, col : int              of its north-west cell
    side : int                  cells, cut off at the border of the map
    left, before : float        what it holds after the plan, and held before it
    middle : (float, float)     metres east and north of the south-west cell's centre
    at : (float, float) or None latitude and longitude of the middle, where the map has a place on the globe
    """

    letter: str
    row: int
    col: int
    side: int
    left: float
    before: float
    middle: tuple[float, float]
    at: tuple[float, float] | None

    @property
    def searched(self) -> float:
        """Share of what it held that the plan would have found."""
        return 1.0 - self.left / self.before if self.before > 0 else 0.0

    def result(self) -> dict[str, Any]:
        """For JSON."""
        lat, lon = self.at or (None, None)
        told = {"place": self.letter, "row": self.row, "col": self.col, "cells": self.side, "lat": lat, "lon": lon}
        return told | {"left": self.left, "before": self.before}


def richest(score: Score) -> tuple[RichPlace, ...]:
    """Up to five squares, the richest first, none over another; those that hold hardly anything are left out."""
    mission, grid = score.mission, score.mission.problem.grid
    free = grid.passable
    left = np.where(free, score.left, 0.0).reshape(grid.shape)
    before = np.where(free, np.ravel(mission.sight.there), 0.0).reshape(grid.shape)
    side = max(ceil(sqrt(grid.n_cells) / ACROSS), 1)
    remaining, total, found = left.copy(), float(left.sum()), list[RichPlace]()
    for letter in "ABCDE"[:MOST]:
        held = _held(remaining, side)
        row, col = (int(each) for each in np.unravel_index(int(np.argmax(held)), held.shape))
        if held[row, col] <= LEAST * total:
            break
        here = np.s_[row : row + side, col : col + side]
        numbers = np.arange(grid.n_cells).reshape(grid.shape)[here]
        east, north = grid.centres_m[numbers.ravel()].mean(axis=0).tolist()
        at = None
        if mission.ground is not None and grid.connectivity != "hex":
            lat, lon = mission.ground.places([_middle(numbers, grid.shape[1])])[0].tolist()
            at = (lat, lon)
        values = float(left[here].sum()), float(before[here].sum())
        found.append(RichPlace(letter, row, col, side, *values, (east, north), at))
        remaining[here] = 0.0
    return tuple(found)


def _held(values: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """What every square holds, by its north-west cell; a map that is narrower than a square is all in it.

    >>> _held(np.arange(6.0).reshape(2, 3), 2)
    array([[ 8., 12.]])
    """
    height, width = (min(side, size) for size in values.shape)
    sums = np.pad(values.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    held = sums[height:, width:] - sums[height:, :-width] - sums[:-height, width:] + sums[:-height, :-width]
    return np.asarray(held, np.float64)


def _middle(numbers: NDArray[np.int64], width: int) -> NDArray[np.float64]:
    rows, cols = np.divmod(numbers.ravel(), width)
    return np.array([rows.mean(), cols.mean()])
