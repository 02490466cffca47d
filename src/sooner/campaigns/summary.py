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
from sooner.campaigns.statistics import (
    BySeed,
    Estimate,
    across,
    differences,
    differences_by_seed,
    estimate,
    paired,
    rate,
)

__all__ = [
    "MACHINE_BOUND",
    "OverallRow",
    "PairedRow",
    "SummaryRow",
    "in_cell",
    "overall_csv",
    "overall_rows",
    "paired_csv",
    "paired_rows",
    "spot_name",
    "summary_csv",
    "summary_page",
    "summary_rows",
]

MACHINE_BOUND = "timing."  # how such a measure's name begins
SPOTS_APART = 8  # instances and budgets that get a section each; of more, each measure gets one
Budget = int | float | None
Spot = tuple[str, Budget]  # an instance with a budget


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
                                     drawn together; of a rate Wilson's, see `sooner.campaigns.statistics.across`
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
        for budget, cases in _by(results, lambda case: case.budget).items()
        for measure in dict.fromkeys(name for case in cases for name in case.measures)
        for row in _overall(budget, measure, cases)
    ]


def _overall(budget: Budget, measure: str, cases: Sequence[Results]) -> Iterator[OverallRow]:
    there = [case for case in cases if measure in case.measures and not np.isnan(case.measures[measure]).all()]
    wanted = list(_by(there, lambda case: case.instance))
    if len(wanted) < 2:
        return
    of = {planner: {case.instance: case for case in some} for planner, some in _by(there, lambda c: c.planner).items()}
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


def summary_page(
    title: str,
    rows: Sequence[SummaryRow],
    pairs: Sequence[PairedRow],
    overall: Sequence[OverallRow] = (),
    notes: Sequence[str] = (),
) -> str:
    """A page that people read: rates beside the means of those that have the number, then planner against planner.

    Up to eight spots (an instance with a budget) have a section each, with planners side by side; of more, each
    measure has a section, with spots below each other. Then come all instances together, and last times and memory,
    which belong to a machine. Notes stand at the top.

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
    parts = [f"# {in_cell(title)}", *map(in_cell, notes), _preface(rows), *([_ABOUT_PAIRS] if pairs else [])]
    parts += _sections(_of_machine(rows, False), _of_machine(pairs, False), "##")
    parts += _together(rows, _of_machine(overall, False), "##")
    timed = _of_machine(rows, True)
    if timed:
        parts += ["## Bound to the machine", "Times and memory of the machines that flew these trials."]
        parts += _sections(timed, _of_machine(pairs, True), "###")
        parts += _together(rows, _of_machine(overall, True), "###")
    return "\n\n".join(parts) + "\n"


def _of_machine(rows: Iterable[Any], wanted: bool) -> list[Any]:
    return [row for row in rows if row.measure.startswith(MACHINE_BOUND) is wanted]


def _preface(rows: Sequence[SummaryRow]) -> str:
    cases = {(row.instance, row.budget, row.planner): row for row in rows}.values()
    finished, aside = sum(row.trials for row in cases), sum(row.failed for row in cases)
    return (
        f"{finished} trials finished, {aside} were set aside. In brackets stand 95 % intervals: Wilson's of a rate, an "
        "expanded percentile bootstrap of a mean or median of up to 1000 trials, else closed forms. A single trial has "
        "none, n = 1 stands there; of three it holds the truth three times in four only. Where only some trials have a "
        "number, mean and median are of those, and how many that is stands beside them."
    )


_ABOUT_PAIRS = (
    "Planner *less* planner compares the two seed by seed. That is fair always, and sharper than two intervals side by "
    "side only where the seed decides something that both meet, as a map that is drawn from it; on a fixed map the "
    "seed drives the planners' own random numbers alone. p is that of the exact sign test (of yes or no: McNemar's "
    "exact test), two-sided: how often as uneven a split of higher and lower comes by chance. It is not corrected for "
    "the number of rows: of twenty without any difference, one may well have p < 0.05."
)


def _sections(rows: Sequence[SummaryRow], pairs: Sequence[PairedRow], marks: str) -> Iterator[str]:
    """Spot by spot, or measure by measure where there are many spots."""
    spots = _by(rows, _spot)
    if len(spots) <= SPOTS_APART:
        for spot, some in spots.items():
            yield f"{marks} {in_cell(spot_name(*spot))}\n\n{_planners_aside(some)}"
            yield from _against([pair for pair in pairs if _spot(pair) == spot], by_measure=True)
        return
    yield f"{marks} trials\n\n{_spots_below(rows, _trials)}"
    for measure, some in _by((row for row in rows if row.measure), lambda row: row.measure).items():
        yield f"{marks} {in_cell(measure)}\n\n{_spots_below(some, _mean)}"
        yield from _against([pair for pair in pairs if pair.measure == measure], by_measure=False)


def _spot(row: SummaryRow | PairedRow) -> Spot:
    return row.instance, row.budget


def _together(rows: Sequence[SummaryRow], overall: Sequence[OverallRow], marks: str) -> Iterator[str]:
    """All instances of a budget: planners side by side, and each against the first."""
    planners = list(_by(rows, lambda row: row.planner))
    instances = {budget: len(_by(some, lambda row: row.instance)) for budget, some in _by(rows, _budget).items()}
    for budget, some in _by(overall, _budget).items():
        heading = spot_name(f"All {instances[budget]} instances", budget)
        explained = marks == "##" and budget == overall[0].budget
        yield f"{marks} {heading}" + (f"\n\n{_ABOUT_OVERALL}" if explained else "")
        shown = [name for name in planners if any(row.planner == name for row in some)]
        lines = []
        for measure, here in _by((row for row in some if not row.against), lambda row: row.measure).items():
            of = {row.planner: row for row in here}
            label = measure + (f" ({here[0].instances} instances)" if here[0].instances < instances[budget] else "")
            lines.append([label, *(_overall_cell(of.get(name)) for name in shown)])
        yield _grid(["", *shown], lines, "|---|" + "---:|" * len(shown))
        pairs = [row for row in some if row.against]
        held = [
            [row.measure, row.planner, row.against, str(row.seeds), _difference(row)]
            for here in _by(pairs, lambda row: row.measure).values()
            for row in here
            if row.against == here[0].against
        ]
        if held:
            yield _grid(["measure", "planner", "less", "seeds", "mean difference"], held, "|---|---|---|---:|---:|")


_ABOUT_OVERALL = (
    "The mean of the instances' means, each instance counting the same. The interval is by a bootstrap over seeds that "
    "keeps a seed's instances together. The instances are the ones asked for, not a sample of others: the interval "
    "says how far other seeds may lead, not other instances. A planner without the number on one of them has no cell."
)


def _budget(row: SummaryRow | OverallRow) -> Budget:
    return row.budget


def _overall_cell(row: OverallRow | None) -> str:
    if row is None:
        return ""
    if row.yes_no:
        return f"{100 * row.mean:.1f} % ({100 * row.mean_low:.1f} to {100 * row.mean_high:.1f})"
    return _interval(row.mean, row.mean_low, row.mean_high) + (" (1 seed)" if row.seeds == 1 else "")


def _difference(row: PairedRow | OverallRow) -> str:
    scale, unit = (100.0, " points") if row.yes_no else (1.0, "")
    return _interval(row.mean, row.mean_low, row.mean_high, scale, unit, "+")


def _planners_aside(rows: Sequence[SummaryRow]) -> str:
    """One spot: a column for each planner, up to three lines for each measure."""
    planners = list(_by(rows, lambda row: row.planner))
    cases = {row.planner: row for row in reversed(rows)}
    lines = [["trials", *(_trials(cases[planner]) for planner in planners)]]
    measures = _by((row for row in rows if row.measure), lambda row: row.measure)
    for measure, some in sorted(measures.items(), key=lambda item: not item[1][0].yes_no):  # rates come first
        of = {row.planner: row for row in some}
        lines += [[label, *cells] for label, cells in _measure_lines(measure, [of.get(name) for name in planners])]
    return _grid(["", *planners], lines, "|---|" + "---:|" * len(planners))


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


def _spots_below(rows: Sequence[SummaryRow], cell: Callable[[SummaryRow], str]) -> str:
    """Many spots: a line for each, a column for each planner."""
    planners = list(_by(rows, lambda row: row.planner))
    lines = []
    for (instance, budget), some in _by(rows, _spot).items():
        of = {row.planner: row for row in reversed(some)}
        cells = [cell(of[planner]) if planner in of else "" for planner in planners]
        lines.append([instance, _figure(budget), *cells])
    return _grid(["instance", "budget", *planners], lines, "|---|---:|" + "---:|" * len(planners))


def _against(pairs: Sequence[PairedRow], by_measure: bool) -> Iterator[str]:
    """Every planner against the first, as one table."""
    lead = ["measure"] if by_measure else ["instance", "budget"]
    lines = [
        [*([pair.measure] if by_measure else [pair.instance, _figure(pair.budget)]), *_against_cells(pair)]
        for some in _by(pairs, lambda pair: (_spot(pair), pair.measure)).values()
        for pair in some
        if pair.against == some[0].against
    ]
    if lines:
        head = [*lead, "planner", "less", "seeds", "mean difference", "median difference", "higher / same / lower", "p"]
        yield _grid(head, lines, "|" + "---|" * (len(lead) + 2) + "---:|" * 5)


def _against_cells(pair: PairedRow) -> list[str]:
    return [
        pair.planner,
        pair.against,
        str(pair.n),
        _difference(pair),
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
    return _interval(row.mean, row.mean_low, row.mean_high) + (" (n = 1)" if row.n == 1 else "") + beside


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


def spot_name(instance: str, budget: Budget) -> str:
    """As people read it.

    >>> spot_name("hills", 300), spot_name("hills", None)
    ('hills, budget 300', 'hills')
    """
    return instance + ("" if budget is None else f", budget {_figure(budget)}")


def _grid(head: Sequence[str], lines: Iterable[Sequence[str]], rule: str) -> str:
    drawn = ["| " + " | ".join(in_cell(cell) for cell in line) + " |" for line in (head, *lines)]
    drawn[0] = drawn[0].replace("|  |", "| |", 1)
    return "\n".join([drawn[0], rule, *drawn[1:]])


def in_cell(text: str) -> str:
    """Names may hold what Markdown would take for the edge of a cell, or a line's end."""
    return " ".join(text.replace("\\", "\\\\").replace("|", "\\|").split())


def _by(rows: Iterable[Any], key: Callable[[Any], Any]) -> dict[Any, list[Any]]:
    groups: dict[Any, list[Any]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups
