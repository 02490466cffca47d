"""One line for each trial, for the reader's own analysis: CSV, and Parquet where pyarrow is installed."""

from __future__ import annotations

import csv
import os
import pickle
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import IO, Any, Literal

from sooner.errors import DataFormatError, Fault, InvalidProblemError

__all__ = ["Kind", "Tidy", "flat", "write_tidy"]

ROWS_AT_ONCE = 50_000  # in memory, and in a row group of Parquet
NO_PYARROW = "no Parquet was written: pyarrow is not installed; pip install 'sooner[parquet]'"
_WIDEST = 2**63

Kind = Literal["yes_no", "whole", "number", "text"]


@dataclass(frozen=True)
class Tidy:
    """What was written.

    Parameters
    ----------
    rows : int
    columns : tuple of str     as they stand in the files
    note : str                 what was not written, and why; "" if all was
    """

    rows: int
    columns: tuple[str, ...]
    note: str = ""


def flat(answer: Mapping[str, Any]) -> dict[str, Any]:
    """A nested answer with one key for each value: objects by dots, lists left out.

    Examples
    --------
    >>> flat({"pos": 0.5, "timing": {"seconds": 1.5}, "path": [3, 4], "found": None})
    {'pos': 0.5, 'timing.seconds': 1.5, 'found': None}
    """
    found: dict[str, Any] = {}
    for name, value in answer.items():
        if isinstance(value, Mapping):
            found.update({f"{name}.{below}": deep for below, deep in flat(value).items()})
        elif not isinstance(value, (list, tuple)):
            found[name] = value
    return found


def write_tidy(
    rows: Iterable[Mapping[str, Any]],
    columns: Sequence[str] | Mapping[str, Kind],
    csv_file: Path,
    parquet: Path | None = None,
) -> Tidy:
    """Write trials as CSV and, if asked and pyarrow is there, as Parquet; all files whole, or none.

    Rows are read once. They are put aside on the disk, beside the CSV, until all columns and their types are known, so
    that a million of them need no more memory than 50,000. A column is yes/no, whole numbers, numbers or text,
    whichever is the narrowest that holds all of its values; nulls fit in each. One without a value is of numbers.
    Columns that are given with their kind have that type in Parquet whatever they hold, so that files of several
    campaigns fit together; the CSV has their values as they came.

    Parameters
    ----------
    rows : of flat mappings    value by column; see `flat`
    columns : of str           come first, in this order, whether or not a row has them; others follow as first met. A
                               mapping gives their kinds as well

    Raises
    ------
    DataFormatError            if the disk refuses; the files that were there before still are

    Examples
    --------
    >>> file = Path(tempfile.mkdtemp()) / "trials.csv"
    >>> write_tidy([{"seed": 1, "pos": 0.5}, {"seed": 2, "found": True}], ["seed"], file)
    Tidy(rows=2, columns=('seed', 'pos', 'found'), note='')
    >>> print(file.read_text(), end="")
    seed,pos,found
    1,0.5,
    2,,true
    """
    if len(set(columns)) < len(columns):
        raise InvalidProblemError(f"columns {', '.join(columns)} came; expected each once")
    note = NO_PYARROW if parquet is not None and not _has_pyarrow() else ""
    wanted = None if note else parquet
    try:
        fixed = dict(columns) if isinstance(columns, Mapping) else {}
        with _spooled(rows, columns, csv_file, fixed) as aside, _beside(csv_file, wanted) as beside:
            _write_csv(aside, beside[0])
            if wanted is not None:
                _write_parquet(aside, beside[1])
    except OSError as error:
        came = f"writing failed ({error.strerror or error})"
        raise DataFormatError(Fault(str(csv_file), "", came, "expected a folder with room to write to")) from error
    return Tidy(aside.rows, tuple(aside.kinds), note)


def _has_pyarrow() -> bool:
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        return False
    return True


@dataclass
class _Aside:
    """Rows put aside by columns, a batch at a time, and what their columns hold."""

    file: IO[bytes]
    types: dict[str, set[type]]
    fixed: Mapping[str, Kind]
    rows: int = 0
    ends: list[int] = field(default_factory=list)
    wide: set[str] = field(default_factory=set)

    def put(self, batch: Sequence[Mapping[str, Any]]) -> None:
        for row in batch:
            if not row.keys() <= self.types.keys():
                self.types.update({name: set() for name in row if name not in self.types})
        columns = {name: [row.get(name) for row in batch] for name in self.types}
        for name, values in columns.items():
            self.types[name].update(map(type, values))
            if int in self.types[name] and any(isinstance(v, int) and not -_WIDEST <= v < _WIDEST for v in values):
                self.wide.add(name)
        pickle.dump((len(batch), columns), self.file, pickle.HIGHEST_PROTOCOL)
        self.rows += len(batch)
        self.ends.append(self.rows)

    @property
    def kinds(self) -> dict[str, Kind]:
        return {name: self.fixed.get(name) or _kind(types, name in self.wide) for name, types in self.types.items()}

    def batches(self, as_came: bool = False) -> Iterator[dict[str, list[Any]]]:
        """By columns, each batch with all of them, values as their column's kind; where it is fixed, as they came."""
        kinds = self.kinds | (dict.fromkeys(self.fixed) if as_came else {})
        self.file.seek(0)
        for _ in self.ends:
            n, columns = pickle.load(self.file)
            yield {name: _as(kind, columns.get(name) or [None] * n) for name, kind in kinds.items()}


def _kind(types: set[type], wide: bool) -> Kind:
    there = types - {type(None)}
    if not all(issubclass(kind, (int, float)) for kind in there):
        return "text"
    if any(issubclass(kind, float) for kind in there) or not there:
        return "number"
    if there == {bool}:
        return "yes_no"
    return "text" if wide else "whole"


def _as(kind: Kind | None, values: list[Any]) -> list[Any]:
    if kind is None or kind == "yes_no":
        return values
    of: Callable[[Any], Any] = {"whole": int, "number": float, "text": str}[kind]
    return [None if value is None else of(value) for value in values]


@contextmanager
def _spooled(
    rows: Iterable[Mapping[str, Any]], columns: Iterable[str], near: Path, fixed: Mapping[str, Kind]
) -> Iterator[_Aside]:
    near.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=near.parent) as file:
        aside = _Aside(file, {name: set() for name in columns}, fixed)
        left = iter(rows)
        while batch := list(islice(left, ROWS_AT_ONCE)):
            aside.put(batch)
        yield aside


@contextmanager
def _beside(*places: Path | None) -> Iterator[list[Path]]:
    """A file beside each place; renamed into it if all goes well, else removed."""
    wanted = [place for place in places if place is not None]
    beside = [place.with_name(f".sooner-{os.getpid()}-{place.name}.tmp") for place in wanted]
    try:
        for path in beside:
            path.parent.mkdir(parents=True, exist_ok=True)
        yield beside
        for path, place in zip(beside, wanted, strict=True):
            path.replace(place)
    finally:
        for path in beside:
            path.unlink(missing_ok=True)


def _write_csv(aside: _Aside, path: Path) -> None:
    kinds = aside.kinds
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(kinds)
        for batch in aside.batches(as_came=True):
            columns = [_words(values) if kinds[name] == "yes_no" else values for name, values in batch.items()]
            writer.writerows(zip(*columns, strict=True))
        _flush(file)


def _words(values: list[Any]) -> list[str | None]:
    return [None if value is None else "true" if value else "false" for value in values]


def _write_parquet(aside: _Aside, path: Path) -> None:
    import pyarrow as pa
    from pyarrow.parquet import ParquetWriter

    of = {"yes_no": pa.bool_(), "whole": pa.int64(), "number": pa.float64(), "text": pa.string()}
    schema = pa.schema([(name, of[kind]) for name, kind in aside.kinds.items()])
    with path.open("wb") as file:
        with ParquetWriter(file, schema) as writer:
            for batch in aside.batches():
                writer.write_table(pa.table(batch, schema), row_group_size=ROWS_AT_ONCE)
        _flush(file)


def _flush(file: IO[Any]) -> None:
    file.flush()
    os.fsync(file.fileno())
