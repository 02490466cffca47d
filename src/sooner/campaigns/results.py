"""What came of many trials, as arrays: one value for each seed and measure."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError

__all__ = ["Results", "collect"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Results:
    """What came of one case: an instance, a planner, a budget, flown under many seeds.

    Parameters
    ----------
    instance, planner : str
    budget : int, float or None
    seeds : (n,) int               of the finished trials, ascending
    measures : (n,) float each     NaN where a trial has no such number; yes or no as 1 or 0
    yes_no : frozenset of str      the measures that are yes or no
    failed : int                   trials set aside

    Raises
    ------
    InvalidProblemError            if seeds repeat or fall, a measure is not as long as they are, or a yes is no 0 or 1
    """

    instance: str
    planner: str
    budget: int | float | None
    seeds: NDArray[np.int64]
    measures: Mapping[str, Floats]
    yes_no: frozenset[str]
    failed: int = 0

    def __post_init__(self) -> None:
        seeds = _kept(self.seeds, np.int64)
        measures = {name: _kept(values, np.float64) for name, values in self.measures.items()}
        object.__setattr__(self, "seeds", seeds)
        object.__setattr__(self, "measures", MappingProxyType(measures))
        if (np.diff(seeds) <= 0).any():
            raise InvalidProblemError(f"{self._named()}: seeds repeat or fall; give each trial once, ascending")
        for name, values in measures.items():
            if values.shape != seeds.shape:
                raise InvalidProblemError(
                    f"{self._named()}: {name} has shape {values.shape}; expected {seeds.shape}, one value per seed"
                )
        for name in self.yes_no & measures.keys():
            if not np.isin(measures[name], (0.0, 1.0)).all(where=~np.isnan(measures[name])):
                raise InvalidProblemError(f"{self._named()}: {name} is yes or no; expected 1, 0 or NaN")

    def __len__(self) -> int:
        return len(self.seeds)

    def measure(self, name: str) -> Floats:
        """One measure, (n,); says which there are if there is none of that name."""
        if name not in self.measures:
            known = ", ".join(self.measures) or "none"
            raise InvalidProblemError(f"{self._named()} has no measure {name!r}; expected one of: {known}")
        return self.measures[name]

    def _named(self) -> str:
        budget = "" if self.budget is None else f", {self.budget}"
        return f"{self.planner} on {self.instance}{budget}"


def _kept(values: Any, kind: Any) -> NDArray[Any]:
    copy = np.array(values, kind)
    copy.setflags(write=False)
    return copy


def collect(
    instance: str,
    planner: str,
    budget: int | float | None,
    rows: Iterable[tuple[int, Mapping[str, Any]]],
    failed: int = 0,
) -> Results:
    """Results of one case from the seeds and answers of its trials, in any order.

    Numbers and yes/no become measures, in the order in which they are first met. Null, a missing key, NaN and infinity
    mean that the trial has no such number; text, lists and objects are passed over. A measure is yes or no where no
    trial answers it by a number.

    Parameters
    ----------
    rows : of (seed, answer)       answers as JSON objects, flat; read once, and not kept
    failed : int                   trials set aside

    Examples
    --------
    >>> found = collect("hills", "greedy", 90, [(2, {"found": True, "steps": 7}), (1, {"found": False, "steps": None})])
    >>> found.seeds, dict(found.measures)
    (array([1, 2]), {'found': array([0., 1.]), 'steps': array([nan,  7.])})
    >>> found.yes_no
    frozenset({'found'})
    """
    seeds, columns, numeric = _columns(rows)
    order = np.argsort(seeds, kind="stable")
    measures = {name: _aligned(column, order) for name, column in columns.items()}
    return Results(instance, planner, budget, seeds[order], measures, frozenset(columns.keys() - numeric), failed)


def _columns(
    rows: Iterable[tuple[int, Mapping[str, Any]]],
) -> tuple[NDArray[np.int64], dict[str, array[float]], set[str]]:
    """Seeds, columns (short where their last trials have no number), and the names that met a number."""
    seeds = array("q")
    columns: dict[str, array[float]] = {}
    numeric: set[str] = set()
    absent = array("d", [np.nan])
    for row, (seed, answer) in enumerate(rows):
        seeds.append(seed)
        for name, value in answer.items():
            if not isinstance(value, (int, float)):
                continue
            column = columns.get(name)
            if column is None:
                column = columns[name] = array("d")
            if (behind := row - len(column)) > 0:
                column.extend(absent * behind)
            column.append(value)
            if value is not True and value is not False:
                numeric.add(name)
    return np.array(seeds, np.int64), columns, numeric


def _aligned(column: array[float], order: NDArray[np.intp]) -> Floats:
    values = np.full(len(order), np.nan)
    values[: len(column)] = column
    values[~np.isfinite(values)] = np.nan
    return values[order]
