"""Results summed up on a page for people; it is made of the rows of the summary and says nothing that they do not."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from sooner.campaigns.summary import Budget, OverallRow, PairedRow, SummaryRow, grouped

__all__ = ["MACHINE_BOUND", "in_cell", "spot_name", "summary_page"]

MACHINE_BOUND = "timing."  # how such a measure's name begins
SPOTS_APART = 8  # instances and budgets that get a section each; of more, each measure gets one
Spot = tuple[str, Budget]  # an instance with a budget


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
    >>> from sooner.campaigns.summary import summary_rows
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
    spots = grouped(rows, _spot)
    if len(spots) <= SPOTS_APART:
        for spot, some in spots.items():
            yield f"{marks} {in_cell(spot_name(*spot))}\n\n{_planners_aside(some)}"
            yield from _against([pair for pair in pairs if _spot(pair) == spot], by_measure=True)
        return
    yield f"{marks} trials\n\n{_spots_below(rows, _trials)}"
    for measure, some in grouped((row for row in rows if row.measure), lambda row: row.measure).items():
        yield f"{marks} {in_cell(measure)}\n\n{_spots_below(some, _mean)}"
        yield from _against([pair for pair in pairs if pair.measure == measure], by_measure=False)


def _spot(row: SummaryRow | PairedRow) -> Spot:
    return row.instance, row.budget


def _together(rows: Sequence[SummaryRow], overall: Sequence[OverallRow], marks: str) -> Iterator[str]:
    """All instances of a budget: planners side by side, and each against the first."""
    planners = list(grouped(rows, lambda row: row.planner))
    instances = {budget: len({row.instance for row in some}) for budget, some in grouped(rows, _budget).items()}
    for budget, some in grouped(overall, _budget).items():
        heading = spot_name(f"All {instances[budget]} instances", budget)
        explained = marks == "##" and budget == overall[0].budget
        yield f"{marks} {heading}" + (f"\n\n{_ABOUT_OVERALL}" if explained else "")
        shown = [name for name in planners if any(row.planner == name for row in some)]
        lines = []
        for measure, here in grouped((row for row in some if not row.against), lambda row: row.measure).items():
            of = {row.planner: row for row in here}
            label = measure + (f" ({here[0].instances} instances)" if here[0].instances < instances[budget] else "")
            lines.append([label, *(_overall_cell(of.get(name)) for name in shown)])
        yield _grid(["", *shown], lines, "|---|" + "---:|" * len(shown))
        pairs = [row for row in some if row.against]
        held = [
            [row.measure, row.planner, row.against, str(row.seeds), _difference(row)]
            for here in grouped(pairs, lambda row: row.measure).values()
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
    planners = list(grouped(rows, lambda row: row.planner))
    cases = {row.planner: row for row in reversed(rows)}
    lines = [["trials", *(_trials(cases[planner]) for planner in planners)]]
    measures = grouped((row for row in rows if row.measure), lambda row: row.measure)
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
    planners = list(grouped(rows, lambda row: row.planner))
    lines = []
    for (instance, budget), some in grouped(rows, _spot).items():
        of = {row.planner: row for row in reversed(some)}
        cells = [cell(of[planner]) if planner in of else "" for planner in planners]
        lines.append([instance, _figure(budget), *cells])
    return _grid(["instance", "budget", *planners], lines, "|---|---:|" + "---:|" * len(planners))


def _against(pairs: Sequence[PairedRow], by_measure: bool) -> Iterator[str]:
    """Every planner against the first, as one table."""
    lead = ["measure"] if by_measure else ["instance", "budget"]
    lines = [
        [*([pair.measure] if by_measure else [pair.instance, _figure(pair.budget)]), *_against_cells(pair)]
        for some in grouped(pairs, lambda pair: (_spot(pair), pair.measure)).values()
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
