"""What a study leaves for its readers: a page, its numbers, and every trial for their own analysis."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from sooner.campaigns.run import Ran
from sooner.campaigns.summary import paired_csv, paired_rows, summary_csv, summary_page, summary_rows
from sooner.campaigns.tidy import flat, write_tidy
from sooner.io.writing import Folder

__all__ = ["REPORT", "Report", "write_report"]

REPORT = ("summary.md", "summary.csv", "paired.csv", "trials.csv", "trials.parquet")
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


def write_report(ran: Ran, title: str, folder: Folder, more: Mapping[str, bytes] | None = None) -> Report:
    """Write the page, the tables and every trial, whole or not at all.

    Parameters
    ----------
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
    files: dict[str, bytes | Path] = {
        "summary.md": summary_page(title, rows, pairs).encode(),
        "summary.csv": summary_csv(rows).encode(),
        "paired.csv": paired_csv(pairs).encode(),
        "trials.csv": trials,
        **({"trials.parquet": table} if table.is_file() else {}),
        **(more or {}),
    }
    folder.write(files)
    return Report(tuple(folder.path / name for name in files), (tidy.note,) if tidy.note else ())


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
