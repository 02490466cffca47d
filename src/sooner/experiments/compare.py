"""Published beside measured: a verdict for every number, and a reason wherever the two differ."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from sooner.campaigns.study import Rule
from sooner.campaigns.summary_page import in_cell
from sooner.experiments.published import Key, Published, Reproduced

__all__ = ["Comparison", "compare", "comparison_markdown", "tables_markdown"]

UNEXPLAINED = "not explained yet"


@dataclass(frozen=True)
class Comparison:
    """One number, twice.

    Parameters
    ----------
    published : Published
    ours : Reproduced or None  None where it cannot be measured
    verdict : str              "same", "near", "above", "below", "holds", "does not hold", "faster", "slower",
                               "not measured"
    reason : str               "" where the two are the same
    """

    published: Published
    ours: Reproduced | None
    verdict: str
    reason: str

    @property
    def difference(self) -> float | None:
        """Ours less theirs."""
        return None if self.ours is None else self.ours.value - float(self.published.value)


def compare(
    published: Iterable[Published], reproduced: Iterable[Reproduced], rules: Sequence[Mapping[str, Any]]
) -> list[Comparison]:
    """Every published number with its verdict; later rules overrule earlier ones, setting by setting."""
    ours = {row.key: row for row in reproduced}
    checked = [(Rule(**given), given) for given in rules]
    return [_judged(number, ours.get(number.key), checked) for number in published]


def _judged(number: Published, ours: Reproduced | None, rules: Sequence[tuple[Rule, Mapping[str, Any]]]) -> Comparison:
    settings: dict[str, Any] = {}
    for held, given in rules:
        if _holds(held, number.key):
            settings |= given
    rule = Rule(**settings)
    verdict = "not measured" if ours is None else _verdict(number, ours.value, rule)
    reason = "" if verdict in ("same", "holds", "faster") else rule.reason or UNEXPLAINED
    return Comparison(number, ours, verdict, reason)


def _holds(rule: Rule, key: Key) -> bool:
    """Whether a number falls under it."""
    return all(fnmatchcase(k, pattern) for k, pattern in zip(key, (rule.table, rule.row, rule.column), strict=True))


def _verdict(number: Published, ours: float, rule: Rule) -> str:
    theirs = float(number.value)
    if rule.sense == "limit":
        return "holds" if ours <= theirs else "does not hold"
    if rule.sense == "time":
        return "faster" if ours <= theirs else "slower"
    difference = ours - theirs
    if abs(difference) <= rule.exact:
        return "same"
    if abs(difference) <= rule.near:
        return "near"
    return "above" if difference > 0 else "below"


def comparison_markdown(title: str, found: Sequence[Comparison], beyond: Sequence[Reproduced]) -> str:
    """The page `comparison.md`: a summary, a table for each of the paper's, then what goes beyond the paper."""
    tables = list(dict.fromkeys(comparison.published.table for comparison in found))
    parts = [f"# {in_cell(title)}", _preface(found, beyond), _summary(found)]
    parts += [_table(table, [c for c in found if c.published.table == table]) for table in tables]
    parts += [_beyond(table, [row for row in beyond if row.table == table]) for table in _others(found, beyond)]
    return "\n\n".join(parts) + "\n"


def tables_markdown(
    title: str, rows: Sequence[Reproduced], empty: Mapping[str, str] | None = None, note: str = ""
) -> str:
    """The page `tables.md`: the tables of a study that nothing printed stands beside.

    Parameters
    ----------
    empty : mapping      tables without a row, and why; they come last
    note : str           what the reader should know first
    """
    told = (
        "What the study asks for (mean, median, deviation or rate), in brackets its 95 % interval, and n where cells "
        "differ in it. Where a cell pools several places, the interval is by a bootstrap over seeds, which keeps the "
        "trials of a seed together. A cell of a single seed has no interval."
    )
    parts = [f"# {in_cell(title)}", *filter(None, [in_cell(note)]), told]
    parts += [_beyond(table, [row for row in rows if row.table == table]) for table in _others([], rows)]
    parts += [f"## {in_cell(table)}\n\n{in_cell(why)}" for table, why in (empty or {}).items()]
    return "\n\n".join(parts) + "\n"


def _preface(found: Sequence[Comparison], beyond: Sequence[Reproduced]) -> str:
    return (
        "Written by `sooner reproduce`; do not edit. *Ours* is the mean (or median, deviation or rate, where the study "
        "says so) of n trials with its 95 % interval: an expanded percentile bootstrap, of a rate Wilson's."
        + _made_by({c.ours.key: c.ours for c in found if c.ours is not None} | {row.key: row for row in beyond})
    )


def _made_by(rows: Mapping[Key, Reproduced]) -> str:
    """Every commit and every processor that stands in the rows: some may be left from an earlier run."""
    commits: dict[str, int] = {}
    for row in rows.values():
        commits[row.commit] = commits.get(row.commit, 0) + 1
    if not commits:
        return ""
    processors = " and ".join(sorted({row.processor for row in rows.values()}))
    names = {commit: " and ".join(f"`{part}`" for part in commit.split(" and ") if part) for commit in commits}
    names = {commit: name or "an unknown commit" for commit, name in names.items()}
    if len(commits) == 1:
        return f" Made by {_commit(next(iter(names.values())))} on {processors}."
    told = ", ".join(f"{count} by {names[commit]}" for commit, count in commits.items())
    return (
        f" The rows were not all made by the same commit: {told}, on {processors}. `reproduced.csv` says which row is "
        "whose."
    )


def _commit(names: str) -> str:
    return names if names.startswith("an ") else f"commit{'s' if ' and ' in names else ''} {names}"


def _summary(found: Sequence[Comparison]) -> str:
    verdicts = list(dict.fromkeys(comparison.verdict for comparison in found))
    lines = ["| table | " + " | ".join(verdicts) + " |", "|---|" + "---:|" * len(verdicts)]
    for table in dict.fromkeys(comparison.published.table for comparison in found):
        here = [comparison.verdict for comparison in found if comparison.published.table == table]
        lines.append(f"| {in_cell(table)} | " + " | ".join(str(here.count(v) or "") for v in verdicts) + " |")
    return "\n".join(lines)


def _table(name: str, found: Sequence[Comparison]) -> str:
    reasons = list(dict.fromkeys(comparison.reason for comparison in found if comparison.reason))
    lines = [
        f"## {in_cell(name)}\n\n| row | column | published | ours | interval | n | difference | verdict | why |",
        "|---|---|---:|---:|---:|---:|---:|---|---|",
    ]
    for comparison in found:
        number = comparison.published
        why = f"({reasons.index(comparison.reason) + 1})" if comparison.reason else ""
        cells = [number.row, number.column, number.value, *_ours(comparison), comparison.verdict, why]
        lines.append("| " + " | ".join(map(in_cell, cells)) + " |")
    notes = [f"{number}. {reason}" for number, reason in enumerate(reasons, 1)]
    return "\n".join(lines + (["", *notes] if notes else []))


def _ours(comparison: Comparison) -> list[str]:
    ours = comparison.ours
    if ours is None:
        return ["", "", "", ""]
    interval = f"{_figure(ours.low)} to {_figure(ours.high)}"
    return [_figure(ours.value), interval, str(ours.n), f"{comparison.difference:+.2f}"]


def _figure(value: float) -> str:
    if abs(value) >= 1 or value == 0:
        return f"{value:.2f}"
    return f"{value:.3g}"


def _others(found: Sequence[Comparison], rows: Sequence[Reproduced]) -> list[str]:
    compared = {comparison.published.table for comparison in found}
    return [table for table in dict.fromkeys(row.table for row in rows) if table not in compared]


def _beyond(name: str, rows: Sequence[Reproduced]) -> str:
    """Ours alone, as a grid: a line for each row, a column for each column; n of each cell where they differ."""
    value = {(row.row, row.column): row for row in rows}
    columns = list(dict.fromkeys(row.column for row in rows))
    counts = {row.n for row in rows}
    head = "| | " + " | ".join(map(in_cell, columns)) + " |"
    lines = [f"## {in_cell(name)}", "", head, "|---|" + "---:|" * len(columns)]
    for row in dict.fromkeys(row.row for row in rows):
        cells = [_with_interval(value.get((row, column)), len(counts) > 1) for column in columns]
        lines.append(f"| {in_cell(row)} | " + " | ".join(cells) + " |")
    return "\n".join(lines + ([] if len(counts) > 1 else ["", f"n = {counts.pop()}"]))


def _with_interval(row: Reproduced | None, with_n: bool) -> str:
    if row is None:
        return ""
    told = [f"{_figure(row.low)} to {_figure(row.high)}"] if row.low != row.high else []
    told += [f"n = {row.n}"] if with_n else []
    return _figure(row.value) + (f" ({'; '.join(told)})" if told else "")
