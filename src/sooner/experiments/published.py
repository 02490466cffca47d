"""What a paper printed and what we measured, on disk.

A study is the folder `benchmarks/papers/<key>/`, with `published.csv`, `study.toml`, `reproduced.csv` and
`comparison.md`. It is found in the checkout that this package runs from, or, in an installed package that carries
the studies, beside this file.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from sooner.errors import DataFormatError, Fault

__all__ = ["Key", "Published", "Reproduced", "read_published", "read_reproduced", "reproduced_csv", "study_folder"]

Key = tuple[str, str, str]


@dataclass(frozen=True)
class Published:
    """One number as a paper prints it.

    Parameters
    ----------
    table, row, column : str      where it stands
    value : str                   as printed, digit for digit
    page : str                    page, or section and caption where the text has no page numbers
    """

    table: str
    row: str
    column: str
    value: str
    page: str

    @property
    def key(self) -> Key:
        """What `published.csv` and `reproduced.csv` share."""
        return self.table, self.row, self.column


@dataclass(frozen=True)
class Reproduced:
    """The same number, measured here.

    Parameters
    ----------
    table, row, column : str      as in `Published`
    value : float                 mean or median, as the study says for the table
    low, high : float             95 % interval of that statistic; both the value where nothing varies
    n : int                       trials behind it
    commit, processor : str       what ran, and where
    """

    table: str
    row: str
    column: str
    value: float
    low: float
    high: float
    n: int
    commit: str
    processor: str

    @property
    def key(self) -> Key:
        """What `published.csv` and `reproduced.csv` share."""
        return self.table, self.row, self.column


def study_folder(paper: str) -> Path:
    """Where the study of a paper stands.

    Raises
    ------
    DataFormatError               if there is none: a misspelt key, or a package without its studies
    """
    for folder in _studies():
        if (folder / paper / "study.toml").is_file():
            return folder / paper
    known = sorted(path.parent.name for folder in _studies() for path in folder.glob("*/study.toml"))
    expected = f"expected one of {', '.join(known)}"
    if not known:
        expected = "expected benchmarks/papers/ beside src/; run it from a checkout of the repository"
    raise DataFormatError(Fault("benchmarks/papers", paper, "no such study came", expected))


def _studies() -> tuple[Path, ...]:
    here = Path(__file__).resolve().parent
    return here / "papers", here.parents[2] / "benchmarks" / "papers"


def read_published(folder: Path) -> tuple[Published, ...]:
    """`published.csv`, in its order."""
    return tuple(Published(*row) for row in _rows(folder / "published.csv", Published))


def read_reproduced(folder: Path) -> tuple[Reproduced, ...]:
    """`reproduced.csv`, in its order."""
    found = []
    for row in _rows(folder / "reproduced.csv", Reproduced):
        table, name, column, value, low, high, n, at, on = row
        found.append(Reproduced(table, name, column, float(value), float(low), float(high), int(n), at, on))
    return tuple(found)


def _rows(path: Path, kind: type) -> list[list[str]]:
    expected = [field.name for field in fields(kind)]
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    faults = [] if header == expected else [Fault(path.name, "line 1", f"came {header}", f"expected {expected}")]
    faults += [
        Fault(path.name, f"line {number}", f"{len(row)} fields came", f"expected {len(expected)}")
        for number, row in enumerate(rows, 2)
        if len(row) != len(expected)
    ]
    if faults:
        raise DataFormatError(*faults)
    return rows


def reproduced_csv(rows: Iterable[Reproduced]) -> str:
    """`reproduced.csv`."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([field.name for field in fields(Reproduced)])
    for row in rows:
        writer.writerow([_short(cell) for cell in astuple(row)])
    return text.getvalue()


def _short(cell: object) -> object:
    return f"{cell:.6g}" if isinstance(cell, float) else cell
