"""Published beside measured: a verdict for every number, and a reason wherever the two differ."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from sooner.experiments.published import Published, Reproduced

__all__ = ["Comparison", "Rule", "compare", "comparison_markdown", "tables_markdown"]

UNEXPLAINED = "not explained yet"


@dataclass(frozen=True)
class Rule:
    """How a group of numbers is judged, or why it differs. Table, row and column may hold * and ?.

    Parameters
    ----------
    exact, near : float        largest differences that still count as the same, and as near
    sense : str                "same" (both ways count), "limit" (no more than that), "time" (less is faster)
    reason : str               why it differs, or cannot be measured
    """

    table: str = "*"
    row: str = "*"
    column: str = "*"
    exact: float = 0.02
    near: float = 2.5
    sense: str = "same"
    reason: str = ""

    def holds_for(self, key: tuple[str, str, str]) -> bool:
        """Whether a number falls under this rule."""
        return all(fnmatchcase(k, pattern) for k, pattern in zip(key, (self.table, self.row, self.column), strict=True))


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
    return [_judged(number, ours.get(number.key), rules) for number in published]


def _judged(number: Published, ours: Reproduced | None, rules: Sequence[Mapping[str, Any]]) -> Comparison:
    settings: dict[str, Any] = {}
    for given in rules:
        if Rule(**{key: given[key] for key in ("table", "row", "column") if key in given}).holds_for(number.key):
            settings |= given
    rule = Rule(**settings)
    verdict = "not measured" if ours is None else _verdict(number, ours.value, rule)
    reason = "" if verdict in ("same", "holds", "faster") else rule.reason or UNEXPLAINED
    return Comparison(number, ours, verdict, reason)


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
    parts = [f"# {title}", _preface(found), _summary(found)]
    parts += [_table(table, [c for c in found if c.published.table == table]) for table in tables]
    parts += [_beyond(table, [row for row in beyond if row.table == table]) for table in _others(found, beyond)]
    return "\n\n".join(parts) + "\n"


def tables_markdown(title: str, rows: Sequence[Reproduced]) -> str:
    """The page `tables.md`: the tables of a study that nothing printed stands beside."""
    told = "The mean, median or rate that the study asks for, in brackets its 95 % interval."
    parts = [
        f"# {title}",
        told,
        *(_beyond(table, [row for row in rows if row.table == table]) for table in _others([], rows)),
    ]
    return "\n\n".join(parts) + "\n"


def _preface(found: Sequence[Comparison]) -> str:
    ours = next((c.ours for c in found if c.ours is not None), None)
    made = f" Made by commit `{ours.commit}` on {ours.processor}." if ours is not None else ""
    return (
        "Written by `sooner reproduce`; do not edit. *Ours* is the mean (or median, where the study says so) of n "
        f"trials with the 95 % interval of its bootstrap.{made}"
    )


def _summary(found: Sequence[Comparison]) -> str:
    verdicts = list(dict.fromkeys(comparison.verdict for comparison in found))
    lines = ["| table | " + " | ".join(verdicts) + " |", "|---|" + "---:|" * len(verdicts)]
    for table in dict.fromkeys(comparison.published.table for comparison in found):
        here = [comparison.verdict for comparison in found if comparison.published.table == table]
        lines.append(f"| {table} | " + " | ".join(str(here.count(v) or "") for v in verdicts) + " |")
    return "\n".join(lines)


def _table(name: str, found: Sequence[Comparison]) -> str:
    reasons = list(dict.fromkeys(comparison.reason for comparison in found if comparison.reason))
    lines = [
        f"## {name}\n\n| row | column | published | ours | interval | n | difference | verdict | why |",
        "|---|---|---:|---:|---:|---:|---:|---|---|",
    ]
    for comparison in found:
        number = comparison.published
        why = f"({reasons.index(comparison.reason) + 1})" if comparison.reason else ""
        cells = [number.row, number.column, number.value, *_ours(comparison), comparison.verdict, why]
        lines.append("| " + " | ".join(cells) + " |")
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
    """Ours alone, as a grid: a line for each row, a column for each column."""
    value = {(row.row, row.column): row for row in rows}
    columns = list(dict.fromkeys(row.column for row in rows))
    lines = [f"## {name}", "", "| | " + " | ".join(columns) + " |", "|---|" + "---:|" * len(columns)]
    for row in dict.fromkeys(row.row for row in rows):
        cells = [_with_interval(value.get((row, column))) for column in columns]
        lines.append(f"| {row} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, "", f"n = {max(row.n for row in rows)}"])


def _with_interval(row: Reproduced | None) -> str:
    if row is None:
        return ""
    if row.low == row.high:
        return _figure(row.value)
    return f"{_figure(row.value)} ({_figure(row.low)} to {_figure(row.high)})"
