"""Results summed up: tables for a program, and a page for people.

A row stands for one measure of one case, a paired row for one measure of two planners under the same seeds. The page
is made of these rows and says nothing that they do not.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from itertools import combinations
from typing import Any

import numpy as np

from sooner.campaigns.results import Results
from sooner.campaigns.statistics import Estimate, differences, estimate, paired, rate

__all__ = [
    "MACHINE_BOUND",
    "PairedRow",
    "SummaryRow",
    "paired_csv",
    "paired_rows",
    "place_name",
    "summary_csv",
    "summary_markdown",
    "summary_page",
    "summary_rows",
]

MACHINE_BOUND = "timing."  # how such a measure's name begins
PLACES_APART = 8  # instances and budgets that get a section each; of more, each measure gets one
Budget = int | float | None
Place = tuple[str, Budget]


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
    p_value : float                  exact two-sided sign test, not corrected for how many rows there are
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
        for cases in _by(results, lambda case: (case.instance, case.budget)).values()
        for theirs, ours in combinations(cases, 2)
        for measure in ours.measures
        if measure in theirs.measures and len(differences(ours, theirs, measure))
    ]


def _pair(ours: Results, theirs: Results, measure: str) -> PairedRow:
    found, yes_no = paired(ours, theirs, measure), measure in ours.yes_no & theirs.yes_no
    head = (ours.instance, ours.budget, measure, yes_no, ours.planner, theirs.planner, found.n)
    split = (found.wins, found.ties, found.losses)
    return PairedRow(*head, *_three(found.mean), *_three(None if yes_no else found.median), *split, found.p_value)


def summary_csv(rows: Iterable[SummaryRow]) -> str:
    """The rows as CSV, with a header; empty where there is nothing to say."""
    return _csv(SummaryRow, rows)


def paired_csv(rows: Iterable[PairedRow]) -> str:
    """The rows as CSV, with a header; empty where there is nothing to say."""
    return _csv(PairedRow, rows)


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


def summary_markdown(title: str, results: Sequence[Results]) -> str:
    """The page of these results; see `summary_page`."""
    return summary_page(title, summary_rows(results), paired_rows(results))


def summary_page(title: str, rows: Sequence[SummaryRow], pairs: Sequence[PairedRow]) -> str:
    """A page that people read: rates beside the means of those that have the number, then planner against planner.

    Up to eight places (an instance with a budget) have a section each, with planners side by side; of more, each
    measure has a section, with places below each other. Times and memory come last: they belong to a machine.

    Examples
    --------
    >>> from sooner.campaigns.results import collect
    >>> flown = collect("hills", "greedy", 90, [(seed, {"found": seed > 0}) for seed in range(4)])
    >>> print(summary_page("Hills", summary_rows([flown]), []).partition("## ")[2], end="")
    hills, budget 90
    <BLANKLINE>
    | | greedy |
    |---|---:|
    | trials | 4 |
    | found | 75.0 % (30.1 to 95.4) |
    """
    parts = [f"# {_cell(title)}", _preface(rows)]
    parts += _sections(_of_machine(rows, False), _of_machine(pairs, False), "##")
    timed = _of_machine(rows, True)
    if timed:
        parts += ["## Bound to the machine", "Times and memory of the machines that flew these trials."]
        parts += _sections(timed, _of_machine(pairs, True), "###")
    return "\n\n".join(parts) + "\n"


def _of_machine(rows: Iterable[Any], wanted: bool) -> list[Any]:
    return [row for row in rows if row.measure.startswith(MACHINE_BOUND) is wanted]


def _preface(rows: Sequence[SummaryRow]) -> str:
    cases = {(row.instance, row.budget, row.planner): row for row in rows}.values()
    finished, aside = sum(row.trials for row in cases), sum(row.failed for row in cases)
    return (
        f"{finished} trials finished, {aside} were set aside. In brackets stand 95 % intervals: Wilson's of a rate, a "
        "percentile bootstrap of a mean or median of up to 1000 trials (too narrow below about 10), else closed forms. "
        "Where only some trials have a number, mean and median are of those, and how many that is stands beside them."
    )


def _sections(rows: Sequence[SummaryRow], pairs: Sequence[PairedRow], marks: str) -> Iterator[str]:
    """Place by place, or measure by measure where there are many places."""
    places = _by(rows, _place)
    if len(places) <= PLACES_APART:
        for place, some in places.items():
            yield f"{marks} {_cell(place_name(*place))}\n\n{_planners_aside(some)}"
            yield from _against([pair for pair in pairs if _place(pair) == place], by_measure=True)
        return
    yield f"{marks} trials\n\n{_places_below(rows, _trials)}"
    for measure, some in _by((row for row in rows if row.measure), lambda row: row.measure).items():
        yield f"{marks} {_cell(measure)}\n\n{_places_below(some, _mean)}"
        yield from _against([pair for pair in pairs if pair.measure == measure], by_measure=False)


def _place(row: SummaryRow | PairedRow) -> Place:
    return row.instance, row.budget


def _planners_aside(rows: Sequence[SummaryRow]) -> str:
    """One place: a column for each planner, up to three lines for each measure."""
    planners = list(_by(rows, lambda row: row.planner))
    cases = {row.planner: row for row in reversed(rows)}
    lines = [["trials", *(_trials(cases[planner]) for planner in planners)]]
    measures = _by((row for row in rows if row.measure), lambda row: row.measure)
    for measure, some in sorted(measures.items(), key=lambda item: not item[1][0].yes_no):  # rates come first
        of = {row.planner: row for row in some}
        lines += [[label, *cells] for label, cells in _measure_lines(measure, [of.get(name) for name in planners])]
    return _table(["", *planners], lines, "|---|" + "---:|" * len(planners))


def _measure_lines(measure: str, rows: Sequence[SummaryRow | None]) -> Iterator[tuple[str, list[str]]]:
    there = [row for row in rows if row is not None]
    some = any(row.n < row.trials for row in there)
    if all(row.yes_no for row in there):
        yield measure, [_mean(row) if row else "" for row in rows]
        return
    yield f"{measure}, mean" + (" of those that have it" if some else ""), [_mean(row, "") for row in rows]
    yield f"{measure}, median", [_median(row) for row in rows]
    if some:
        yield f"{measure}, trials that have it", [f"{row.n} of {row.trials}" if row else "" for row in rows]


def _places_below(rows: Sequence[SummaryRow], cell: Callable[[SummaryRow], str]) -> str:
    """Many places: a line for each, a column for each planner."""
    planners = list(_by(rows, lambda row: row.planner))
    lines = []
    for (instance, budget), some in _by(rows, _place).items():
        of = {row.planner: row for row in reversed(some)}
        cells = [cell(of[planner]) if planner in of else "" for planner in planners]
        lines.append([instance, _figure(budget), *cells])
    return _table(["instance", "budget", *planners], lines, "|---|---:|" + "---:|" * len(planners))


def _against(pairs: Sequence[PairedRow], by_measure: bool) -> Iterator[str]:
    """Every planner against the first, as one table."""
    lead = ["measure"] if by_measure else ["instance", "budget"]
    lines = [
        [*([pair.measure] if by_measure else [pair.instance, _figure(pair.budget)]), *_against_cells(pair)]
        for some in _by(pairs, lambda pair: (_place(pair), pair.measure)).values()
        for pair in some
        if pair.against == some[0].against
    ]
    if lines:
        head = [*lead, "planner", "less", "seeds", "mean difference", "median difference", "higher / same / lower", "p"]
        yield _table(head, lines, "|" + "---|" * (len(lead) + 2) + "---:|" * 5)


def _against_cells(pair: PairedRow) -> list[str]:
    scale = 100.0 if pair.yes_no else 1.0
    unit = " points" if pair.yes_no else ""
    return [
        pair.planner,
        pair.against,
        str(pair.n),
        _interval(pair.mean, pair.mean_low, pair.mean_high, scale, unit, "+"),
        _interval(pair.median, pair.median_low, pair.median_high, sign="+"),
        f"{pair.wins} / {pair.ties} / {pair.losses}",
        "< 0.0001" if pair.p_value < 1e-4 else f"{pair.p_value:.2g}",
    ]


def _trials(row: SummaryRow) -> str:
    return f"{row.trials}" + (f", {row.failed} set aside" if row.failed else "")


def _mean(row: SummaryRow | None, beside: str | None = None) -> str:
    """Rate or mean with its interval, and of how many where not of all."""
    if row is None or row.mean is None:
        return "" if row is None or beside is not None else f"none of {row.trials}"
    if beside is None:
        beside = f"; {row.n} of {row.trials}" if row.n < row.trials else ""
    if row.yes_no and row.mean_low is not None and row.mean_high is not None:
        return f"{100 * row.mean:.1f} % ({100 * row.mean_low:.1f} to {100 * row.mean_high:.1f}){beside}"
    return _interval(row.mean, row.mean_low, row.mean_high) + beside


def _median(row: SummaryRow | None) -> str:
    return "" if row is None else _interval(row.median, row.median_low, row.median_high)


def _interval(
    value: float | None, low: float | None, high: float | None, scale: float = 1.0, unit: str = "", sign: str = ""
) -> str:
    if value is None or low is None or high is None:
        return ""
    told, least, most = (_figure(scale * number, sign) for number in (value, low, high))
    return told + unit if least == told == most else f"{told}{unit} ({least} to {most})"


def _figure(value: float | None, sign: str = "") -> str:
    """Four significant digits; whole numbers in full.

    >>> _figure(0.123456), _figure(123456.7), _figure(90), _figure(1e-9), _figure(2.0, "+"), _figure(None)
    ('0.1235', '123457', '90', '1e-09', '+2', '')
    """
    if value is None:
        return ""
    if isinstance(value, int):
        return str(value)
    sign = sign if value else ""
    return f"{value:{sign}.0f}" if 1e4 <= abs(value) < 1e15 else f"{value:{sign}.4g}"


def place_name(instance: str, budget: Budget) -> str:
    """As people read it.

    >>> place_name("hills", 300), place_name("hills", None)
    ('hills, budget 300', 'hills')
    """
    return instance + ("" if budget is None else f", budget {_figure(budget)}")


def _table(head: Sequence[str], lines: Iterable[Sequence[str]], rule: str) -> str:
    drawn = ["| " + " | ".join(_cell(cell) for cell in line) + " |" for line in (head, *lines)]
    drawn[0] = drawn[0].replace("|  |", "| |", 1)
    return "\n".join([drawn[0], rule, *drawn[1:]])


def _cell(text: str) -> str:
    """Names may hold what Markdown would take for the edge of a cell, or a line's end."""
    return " ".join(text.replace("\\", "\\\\").replace("|", "\\|").split())


def _by(rows: Iterable[Any], key: Callable[[Any], Any]) -> dict[Any, list[Any]]:
    groups: dict[Any, list[Any]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups
