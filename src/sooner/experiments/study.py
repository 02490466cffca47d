"""A study on disk: what a paper printed, what we run against it, what came out.

A study is the folder `benchmarks/papers/<key>/`, with `published.csv`, `study.toml`, `reproduced.csv` and
`comparison.md`. It is found in the checkout that this package runs from, or, in an installed package that carries
the studies, beside this file.
"""

from __future__ import annotations

import csv
import io
import os
import platform
import subprocess
import tempfile
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from sooner.errors import DataFormatError, Fault

__all__ = [
    "Published",
    "Reproduced",
    "commit",
    "find_data",
    "processor",
    "read_published",
    "read_reproduced",
    "read_study",
    "study_folder",
    "writable_folder",
    "write_atomically",
    "write_reproduced",
]

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


def read_study(folder: Path) -> dict[str, Any]:
    """The settings of a study, from its `study.toml`."""
    path = folder / "study.toml"
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise DataFormatError(Fault(path.name, "", str(error), "expected TOML")) from error


def find_data(data_dir: Path | None, name: str, example: str) -> Path:
    """The folder of real maps called `name`: in `data_dir`, or where SOONER_DATA says, or that folder itself.

    Raises
    ------
    DataFormatError               if `example` is in neither
    """
    given = data_dir or (Path(os.environ["SOONER_DATA"]) if os.environ.get("SOONER_DATA") else None)
    if given is None:
        raise DataFormatError(
            Fault(f"{name}/{example}", "", "no data directory came", "give --data DIR or set SOONER_DATA")
        )
    for folder in (given / name, given):
        if (folder / example).is_file():
            return folder
    expected = "give --data DIR or set SOONER_DATA to the folder above it"
    raise DataFormatError(Fault(str(given), "", f"{name}/{example} is not there", expected))


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


def write_reproduced(path: Path, rows: Iterable[Reproduced]) -> None:
    """Write `reproduced.csv`, whole or not at all."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([field.name for field in fields(Reproduced)])
    for row in rows:
        writer.writerow([_short(cell) for cell in astuple(row)])
    write_atomically(path, text.getvalue())


def _short(cell: object) -> object:
    return f"{cell:.6g}" if isinstance(cell, float) else cell


def writable_folder(path: Path) -> Path:
    """The folder, made where it was not; asked for before a long run, not after it.

    Raises
    ------
    DataFormatError               if it cannot be made or written to
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=path).close()
    except OSError as error:
        came = f"writing failed ({error.strerror or error})"
        raise DataFormatError(Fault(str(path), "", came, "expected a folder that can be written to")) from error
    return path


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write beside, then rename: nobody ever sees half a file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, beside = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
        Path(beside).chmod(0o644)
        Path(beside).replace(path)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise


def commit() -> str:
    """What ran: the commit of this checkout, with + where its source has changed since; "" outside a checkout."""
    root = Path(__file__).resolve().parents[3]
    head = _git(root, ["rev-parse", "--short=12", "HEAD"])
    changed = head and _git(root, ["status", "--porcelain", "--untracked-files=no", "--", "src"])
    return head + "+" if changed else head


def _git(root: Path, arguments: Sequence[str]) -> str:
    try:
        done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def processor() -> str:
    """Name of the processor, and how many of its cores this process may use."""
    name = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        lines = cpuinfo.read_text(encoding="utf-8", errors="replace").splitlines()
        name = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), name)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{name}, {cores} cores"
