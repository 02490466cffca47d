"""Results summed up in rows, and the rows as CSV.

A row stands for one measure of one case, a paired row for one measure of two planners under the same seeds, an overall
row for one measure of a planner on all instances.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from itertools import combinations
from typing import Any

import numpy as np

from sooner.campaigns.pairs import differences, differences_by_seed, paired
from sooner.campaigns.pooling import across
from sooner.campaigns.results import Results
from sooner.campaigns.statistics import BySeed, Estimate, estimate, rate

__all__ = [
    "Budget",
    "OverallRow",
    "PairedRow",
    "SummaryRow",
    "grouped",
    "overall_csv",
    "overall_rows",
    "paired_csv",
    "paired_rows",
    "summary_csv",
    "summary_rows",
]

Budget = int | float | None


@dataclass(frozen=True)
class SummaryRow:
    """One measure of one case. None where there is nothing to say: no trial has the number, or it is yes or no.

    Parameters
    ----------
    instance, planner, budget, measure
    yes_no : bool                    then `mean` is the success rate, its interval Wilson's
    trials, failed : int             finished, and set aside
    n : int                          finished trials that have the number; all that follows is of these
    mean, median : float             each with the low and the high end of its 95 % interval
    deviation : float                standard deviation, of n - 1
    lowest, highest : float
    """

    instance: str
    planner: str
    budget: Budget
    measure: str
    yes_no: bool
    trials: int
    failed: int
    n: int
    mean: float | None = None
    mean_low: float | None = None
    mean_high: float | None = None
    median: float | None = None
    median_low: float | None = None
    median_high: float | None = None
    deviation: float | None = None
    lowest: float | None = None
    highest: float | None = None


@dataclass(frozen=True)
class PairedRow:
    """One measure of two planners on the same instance, budget and seeds: `planner` less `against`.

    Parameters
    ----------
    n : int                          shared seeds where both have the number
    mean, median : float             of the differences, each with its 95 % interval; no median of yes or no
    wins, ties, losses : int         seeds where `planner` is higher, the same, lower
    p_value : float                  exact sign test (of yes or no: McNemar's), two-sided, not corrected for how many
                                     rows there are
    """

    instance: str
    budget: Budget
    measure: str
    yes_no: bool
    planner: str
    against: str
    n: int
    mean: float
    mean_low: float
    mean_high: float
    median: float | None
    median_low: float | None
    median_high: float | None
    wins: int
    ties: int
    losses: int
    p_value: float


@dataclass(frozen=True)
class OverallRow:
    """One measure of one planner over all instances of a budget: the mean of the instances' means.

    Parameters
    ----------
    against : str                    "", or the planner whose differences these are less, seed by seed
    instances, seeds : int           over which; each instance counts the same
    mean, mean_low, mean_high        its 95 % interval by a bootstrap over seeds, in which a seed's instances are
                                     drawn together; of a rate Wilson's, see `sooner.campaigns.pooling.across`
    """

    budget: Budget
    measure: str
    yes_no: bool
    planner: str
    against: str
    instances: int
    seeds: int
    mean: float
    mean_low: float
    mean_high: float


def summary_rows(results: Iterable[Results]) -> list[SummaryRow]:
    """Every case, every measure, in the order given; a case without a measure has one row, its measure "".

    Examples
    --------
    >>> from sooner.campaigns.results import collect
    >>> flown = collect("hills", "greedy", 90, [(seed, {"found": seed > 0, "pos": 0.5}) for seed in range(4)])
    >>> for row in summary_rows([flown]):
    ...     print(row.measure, row.n, row.mean, round(row.mean_low, 3), row.median)
    found 4 0.75 0.301 None
    pos 4 0.5 0.5 0.5
    """
    return [_summed(case, measure) for case in results for measure in (case.measures or ("",))]


def _summed(case: Results, measure: str) -> SummaryRow:
    values, yes_no = case.measures.get(measure, np.empty(0)), measure in case.yes_no
    values = values[~np.isnan(values)]
    n = len(values)
    head = (case.instance, case.planner, case.budget, measure, yes_no, len(case), case.failed, n)
    if not n:
        return SummaryRow(*head)
    mean = rate(int(values.sum()), n) if yes_no else estimate(values)
    median = None if yes_no else estimate(values, "median")
    deviation = float(values.std(ddof=1)) if n > 1 else None
    return SummaryRow(*head, *_three(mean), *_three(median), deviation, float(values.min()), float(values.max()))


def _three(of: Estimate | None) -> tuple[Any, Any, Any]:
    return (None, None, None) if of is None else (of.value, of.low, of.high)


def paired_rows(results: Iterable[Results]) -> list[PairedRow]:
    """Every two planners of the same instance and budget, every measure that both have under a shared seed.

    The planner that comes later is compared with the one that comes earlier, so the first is what others are held
    against.

    Examples
    --------
    >>> from sooner.campaigns.results import collect
    >>> greedy = collect("hills", "greedy", 90, [(seed, {"pos": 0.5}) for seed in range(9)])
    >>> climb = collect("hills", "climb", 90, [(seed, {"pos": 0.75}) for seed in range(9)])
    >>> [row] = paired_rows([greedy, climb])
    >>> row.planner, row.against, row.mean, row.wins, row.p_value
    ('climb', 'greedy', 0.25, 9, 0.00390625)
    """
    return [
        _pair(ours, theirs, measure)
        for cases in grouped(results, lambda case: (case.instance, case.budget)).values()
        for theirs, ours in combinations(cases, 2)
        for measure in ours.measures
        if measure in theirs.measures and len(differences(ours, theirs, measure))
    ]


def _pair(ours: Results, theirs: Results, measure: str) -> PairedRow:
    found, yes_no = paired(ours, theirs, measure), measure in ours.yes_no & theirs.yes_no
    head = (ours.instance, ours.budget, measure, yes_no, ours.planner, theirs.planner, found.n)
    split = (found.wins, found.ties, found.losses)
    return PairedRow(*head, *_three(found.mean), *_three(None if yes_no else found.median), *split, found.p_value)


def overall_rows(results: Iterable[Results]) -> list[OverallRow]:
    """Each planner, and each two, over all instances of a budget that has two or more.

    Only planners that have the number on every instance where anybody has it: others would be judged on easier, or
    harder, ground.

    Examples
    --------
    >>> from sooner.campaigns.results import collect
    >>> flown = [collect(place, "greedy", 90, [(1, {"pos": pos})]) for place, pos in (("hills", 0.5), ("plain", 0.75))]
    >>> [(row.planner, row.mean, row.instances, row.seeds) for row in overall_rows(flown)]
    [('greedy', 0.625, 2, 1)]
    """
    return [
        row
        for budget, cases in grouped(results, lambda case: case.budget).items()
        for measure in dict.fromkeys(name for case in cases for name in case.measures)
        for row in _overall(budget, measure, cases)
    ]


def _overall(budget: Budget, measure: str, cases: Sequence[Results]) -> Iterator[OverallRow]:
    there = [case for case in cases if measure in case.measures and not np.isnan(case.measures[measure]).all()]
    wanted = list(grouped(there, lambda case: case.instance))
    if len(wanted) < 2:
        return
    planners = grouped(there, lambda case: case.planner)
    of = {planner: {case.instance: case for case in some} for planner, some in planners.items()}
    whole = {planner: [by[name] for name in wanted] for planner, by in of.items() if len(by) == len(wanted)}
    for planner, mine in whole.items():
        yes_no = all(measure in case.yes_no for case in mine)
        found = across([_numbers(case, measure) for case in mine], yes_no)
        yield OverallRow(budget, measure, yes_no, planner, "", len(wanted), found.n, *_three(found))
    for first, second in combinations(whole, 2):
        pairs = list(zip(whole[second], whole[first], strict=True))
        parts = [differences_by_seed(ours, theirs, measure) for ours, theirs in pairs]
        if all(len(values) for _, values in parts):
            found = across(parts)
            yes_no = all(measure in case.yes_no for pair in pairs for case in pair)
            yield OverallRow(budget, measure, yes_no, second, first, len(wanted), found.n, *_three(found))


def _numbers(case: Results, measure: str) -> BySeed:
    values = case.measures[measure]
    kept = ~np.isnan(values)
    return case.seeds[kept], values[kept]


def summary_csv(rows: Iterable[SummaryRow]) -> str:
    """The rows as CSV, with a header; empty where there is nothing to say."""
    return _csv(SummaryRow, rows)


def paired_csv(rows: Iterable[PairedRow]) -> str:
    """The rows as CSV, with a header; empty where there is nothing to say."""
    return _csv(PairedRow, rows)


def overall_csv(rows: Iterable[OverallRow]) -> str:
    """The rows as CSV, with a header."""
    return _csv(OverallRow, rows)


def _csv(kind: type, rows: Iterable[Any]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([column.name for column in fields(kind)])
    writer.writerows([_short(cell) for cell in astuple(row)] for row in rows)
    return text.getvalue()


def _short(cell: object) -> object:
    if isinstance(cell, bool):
        return "true" if cell else "false"
    return f"{cell:.10g}" if isinstance(cell, float) else cell


def grouped(rows: Iterable[Any], key: Callable[[Any], Any]) -> dict[Any, list[Any]]:
    """The rows that agree in a key, in the order in which they come.

    >>> grouped([3, 1, 5, 2], lambda number: number % 2)
    {1: [3, 1, 5], 0: [2]}
    """
    groups: dict[Any, list[Any]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups
