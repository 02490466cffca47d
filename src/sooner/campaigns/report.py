"""What a study leaves for its readers: a page, its numbers, and every trial for their own analysis."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.summary import (
    MACHINE_BOUND,
    SummaryRow,
    paired_csv,
    paired_rows,
    place_name,
    summary_csv,
    summary_page,
    summary_rows,
)
from sooner.campaigns.tidy import flat, write_tidy
from sooner.io.writing import Folder

__all__ = ["REPORT", "Report", "write_report"]

REPORT = ("summary.md", "summary.png", "summary.csv", "paired.csv", "trials.csv", "trials.parquet")
COLUMNS = (
    "instance", "planner", "budget", "seed", "alone", "state", "attempts", "wall_s", "cpu_s", "memory_mb", "ended_at",
    "commit", "source", "python", "processor", "packages", "reason",
)  # fmt: skip


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
    ran: Ran, title: str, folder: Folder, more: Mapping[str, bytes] | None = None, measure: str = "value"
) -> Report:
    """Write the page, its picture, the tables and every trial, whole or not at all.

    Parameters
    ----------
    measure : str             what the picture shows; where no trial has it, the first number that trials have
    folder : Folder           where to; files that are not ours are left alone unless it says otherwise
    more : mapping            other files to write with them

    Raises
    ------
    DataFormatError           a file must not be replaced, or cannot be written
    """
    results = list(ran.results(alone=False).values())
    rows, pairs = summary_rows(results), paired_rows(results)
    folder.path.mkdir(parents=True, exist_ok=True)
    trials, table = (folder.beside(name) for name in ("trials.csv", "trials.parquet"))
    tidy = write_tidy(_rows(ran), COLUMNS, trials, table)
    picture = _picture(title, results, rows, measure)
    files: dict[str, bytes | Path] = {
        "summary.md": summary_page(title, rows, pairs).encode(),
        **({"summary.png": picture} if picture else {}),
        "summary.csv": summary_csv(rows).encode(),
        "paired.csv": paired_csv(pairs).encode(),
        "trials.csv": trials,
        **({"trials.parquet": table} if table.is_file() else {}),
        **(more or {}),
    }
    try:
        folder.write(files)
    finally:
        for beside in (trials, table):
            beside.unlink(missing_ok=True)
    return Report(tuple(folder.path / name for name in files), (tidy.note,) if tidy.note else ())


def _picture(title: str, results: Sequence[Results], rows: Sequence[SummaryRow], measure: str) -> bytes | None:
    """The measure of every case, place by place; None where there is no number."""
    told = [row for row in rows if row.n and not row.measure.startswith(MACHINE_BOUND)]
    if not told:
        return None
    measure = measure if any(row.measure == measure for row in rows if row.n) else told[0].measure
    of = {(case.instance, case.planner, case.budget): case for case in results}
    from sooner.plotting import Sample, plot_summary

    places: dict[str, list[Sample]] = {}
    shown = [row for row in rows if row.measure == measure and row.n]
    for row in shown:
        values = of[row.instance, row.planner, row.budget].measures[measure]
        mean, low, high = (float(number or 0.0) for number in (row.mean, row.mean_low, row.mean_high))
        sample = Sample(row.planner, values[~np.isnan(values)], mean, low, high)
        places.setdefault(place_name(row.instance, row.budget), []).append(sample)
    return plot_summary(title, measure, places, all(row.yes_no for row in shown))


def _rows(ran: Ran) -> Iterator[dict[str, Any]]:
    """A line for each trial: what it was, what it took, what flew it, and its answer."""
    for row in ran.rows():
        answer, made = row.pop("answer"), _made_by(row.pop("provenance") or "{}")
        packages = " ".join(f"{name}-{version}" for name, version in made.get("packages", {}).items())
        ended = row.pop("ended_at")
        told = {
            "ended_at": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(ended)) if ended else None,
            "packages": packages or None,
            **{key: made.get(key) for key in ("commit", "source", "python", "processor")},
        }
        yield row | told | flat(answer)


@cache
def _made_by(provenance: str) -> dict[str, Any]:
    made: dict[str, Any] = json.loads(provenance)
    return made
