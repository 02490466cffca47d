"""What a study leaves for its readers: a page, its numbers, and every trial for their own analysis."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.summary import (
    SummaryRow,
    overall_csv,
    overall_rows,
    paired_csv,
    paired_rows,
    summary_csv,
    summary_rows,
)
from sooner.campaigns.summary_page import MACHINE_BOUND, spot_name, summary_page
from sooner.campaigns.tidy import Kind, flat, write_tidy
from sooner.io.writing import Folder

if TYPE_CHECKING:
    from sooner.plotting import Sample

__all__ = ["COLUMNS", "REPORT", "Report", "absent", "mixed", "write_report"]

REPORT = ("summary.md", "summary.png", "summary.csv", "paired.csv", "overall.csv", "trials.csv", "trials.parquet")
DEFAULT = "value"  # the measure of a study that names none
COLUMNS: dict[str, Kind] = {
    "instance": "text",
    "planner": "text",
    "budget": "number",
    "seed": "whole",
    "alone": "yes_no",
    "state": "text",
    "attempts": "whole",
    "wall_s": "number",
    "cpu_s": "number",
    "memory_mb": "number",
    "ended_at": "text",
    "commit": "text",
    "source": "text",
    "data": "text",
    "python": "text",
    "processor": "text",
    "packages": "text",
    "reason": "text",
}
"""The standard columns of trials.csv and trials.parquet; what trials answer follows them."""


@dataclass(frozen=True)
class Report:
    """What was written.

    Parameters
    ----------
    files : tuple of Path
    notes : tuple of str      what the reader should know about it
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def write_report(
    ran: Ran, title: str, folder: Folder, more: Mapping[str, bytes] | None = None, measure: str = DEFAULT
) -> Report:
    """Write the page, its picture, the tables and every trial, whole or not at all.

    Parameters
    ----------
    measure : str             what the picture shows; where no trial has it, the first number that trials have, and the
                              page says so
    folder : Folder           where to; files that are not ours are left alone unless it says otherwise
    more : mapping            other files to write with them

    Raises
    ------
    DataFormatError           a file must not be replaced, or cannot be written
    """
    results = list(ran.results(alone=False).values())
    rows, pairs, overall = summary_rows(results), paired_rows(results), overall_rows(results)
    lacking = absent(measure, results) if measure != DEFAULT else ""
    notes = list(filter(None, (lacking, mixed(ran))))
    folder.path.mkdir(parents=True, exist_ok=True)
    trials, table = (folder.beside(name) for name in ("trials.csv", "trials.parquet"))
    tidy = write_tidy(_rows(ran), COLUMNS, trials, table)
    picture = _picture(title, results, rows, measure, lacking)
    files: dict[str, bytes | Path] = {
        "summary.md": summary_page(title, rows, pairs, overall, notes).encode(),
        **({"summary.png": picture} if picture else {}),
        "summary.csv": summary_csv(rows).encode(),
        "paired.csv": paired_csv(pairs).encode(),
        "overall.csv": overall_csv(overall).encode(),
        "trials.csv": trials,
        **({"trials.parquet": table} if table.is_file() else {}),
        **(more or {}),
    }
    try:
        folder.write(files)
    finally:
        for beside in (trials, table):
            beside.unlink(missing_ok=True)
    return Report(tuple(folder.path / name for name in files), (*notes, *filter(None, [tidy.note])))


def absent(measure: str, results: Iterable[Results]) -> str:
    """That no trial has such a number, and which they have; "" where one has it, or where none has any.

    Examples
    --------
    >>> from sooner.campaigns.results import collect
    >>> absent("valu", [collect("hills", "greedy", 90, [(1, {"value": 0.5, "found": True})])])
    "no trial has a number called 'valu'; they have 'value', 'found'"
    """
    there = dict.fromkeys(
        name for case in results for name, values in case.measures.items() if not np.isnan(values).all()
    )
    if measure in there or not there:
        return ""
    return f"no trial has a number called {measure!r}; they have {', '.join(map(repr, there))}"


def mixed(ran: Ran) -> str:
    """That results of several sources stand together, and whose they are; "" where they are of one."""
    found: dict[tuple[str, str], tuple[set[str], int]] = {}
    for commit, source, data, trials in ran.sources():
        commits, before = found.get((source, data), (set(), 0))
        found[source, data] = commits | {commit or "unknown"}, before + trials
    if len(found) < 2:
        return ""
    told = ", ".join(
        f"{trials} trials of commit {' and '.join(sorted(commits))} (source {source}, data {data})"
        for (source, data), (commits, trials) in found.items()
    )
    return f"results of {len(found)} sources are mixed here: {told}; trials.csv says which trial is whose"


def _picture(
    title: str, results: Sequence[Results], rows: Sequence[SummaryRow], measure: str, note: str
) -> bytes | None:
    """The measure of every case, spot by spot; None where there is no number at all."""
    told = [row for row in rows if row.n and not row.measure.startswith(MACHINE_BOUND)]
    if not told:
        return None
    if not any(row.measure == measure for row in rows if row.n):
        measure = told[0].measure
    of = {(row.instance, row.planner, row.budget): row for row in rows if row.measure == measure and row.n}
    from sooner.plotting import Sample, plot_summary

    spots: dict[str, list[Sample]] = {}
    for case in results:
        row = of.get((case.instance, case.planner, case.budget))
        sample = Sample(case.planner, note=_why_none(case)) if row is None else _sample(row, case.measures[measure])
        spots.setdefault(spot_name(case.instance, case.budget), []).append(sample)
    return plot_summary(title, measure, spots, all(row.yes_no for row in of.values()), note)


def _sample(row: SummaryRow, values: NDArray[np.float64]) -> Sample:
    from sooner.plotting import Sample

    mean, low, high = (float(number or 0.0) for number in (row.mean, row.mean_low, row.mean_high))
    return Sample(row.planner, values[~np.isnan(values)], mean, low, high)


def _why_none(case: Results) -> str:
    """Why a case has no number to show."""
    if not len(case):
        return f"all {case.failed} trials failed" if case.failed else "no trial has ended"
    return f"none of {len(case)} trials has the number"


def _rows(ran: Ran) -> Iterator[dict[str, Any]]:
    """A line for each trial: what it was, what it took, what flew it, and its answer."""
    for row in ran.rows():
        answer, made = row.pop("answer"), _made_by(row.pop("provenance") or "{}")
        packages = " ".join(f"{name}-{version}" for name, version in made.get("packages", {}).items())
        ended = row.pop("ended_at")
        told = {
            "ended_at": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(ended)) if ended else None,
            "packages": packages or None,
            **{key: made.get(key) for key in ("commit", "source", "data", "python", "processor")},
        }
        yield row | told | _apart(flat(answer))


def _apart(answer: Mapping[str, Any]) -> dict[str, Any]:
    """An answer whose names do not stand for what the trial is: seed becomes answer.seed.

    >>> _apart({"seed": 99, "value": 0.5})
    {'answer.seed': 99, 'value': 0.5}
    """
    found: dict[str, Any] = {}
    for name, value in answer.items():
        kept = name
        while kept in COLUMNS or (kept != name and kept in answer):
            kept = f"answer.{kept}"
        found[kept] = value
    return found


@cache
def _made_by(provenance: str) -> dict[str, Any]:
    made: dict[str, Any] = json.loads(provenance)
    return made
