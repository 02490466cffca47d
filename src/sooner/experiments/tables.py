"""The tables of a study, filled from its ledger."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sooner.campaigns.pairs import differences_by_seed
from sooner.campaigns.pooling import pooled
from sooner.campaigns.report import absent, mixed
from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.statistics import BySeed, Estimate
from sooner.campaigns.study import Cell, Study, Table
from sooner.campaigns.trial import Case
from sooner.errors import DataFormatError, Fault
from sooner.experiments.compare import tables_markdown
from sooner.experiments.published import Reproduced, reproduced_csv

__all__ = ["tables", "tables_files"]


def tables(study: Study, ran: Ran) -> list[Reproduced]:
    """A row for each cell of each table in which a trial came to its end, then for those of its table of times."""
    results, mark = ran.results(), _marks(ran)
    return [row for part in _parts(study) for row in _filled(part, results, mark)]


@dataclass(frozen=True)
class _Part:
    """A table, or what it shows of one measure."""

    name: str
    table: Table
    measure: str
    cells: tuple[Cell, ...]


def _parts(study: Study) -> Iterator[_Part]:
    for table in study.tables:
        for shown, measure in (table.measures or {"": table.measure or study.file.measure}).items():
            yield _Part(table.name, table, measure, tuple(dict.fromkeys(study.cells(table, shown))))
        if table.times:
            alone = tuple(dict.fromkeys(study.alone(cell) for cell in study.cells(table)))
            yield _Part(table.times, table, "timing.seconds", alone)


def tables_files(study: Study, ran: Ran) -> dict[str, bytes]:
    """`tables.md` and `tables.csv`, where the study asks for tables of its own."""
    if not study.file.tables:
        return {}
    results, mark = ran.results(), _marks(ran)
    rows: list[Reproduced] = []
    lacking: dict[str, list[str]] = {}
    for part in _parts(study):
        rows += (filled := list(_filled(part, results, mark)))
        if why := _lacking(part, results, bool(filled)):
            lacking.setdefault(part.name, []).append(why)
    there = {row.table for row in rows}
    empty = {name: "; ".join(why) for name, why in lacking.items() if name not in there}
    noted = [f"{name}: {each}" for name, why in lacking.items() if name in there for each in why]
    page = tables_markdown(study.file.title, rows, empty, "; ".join(filter(None, [*noted, mixed(ran)])))
    return {"tables.md": page.encode(), "tables.csv": reproduced_csv(rows).encode()}


def _marks(ran: Ran) -> Reproduced:
    """An empty row with the commits and processors that flew the trials."""
    told = [it for it, _ in ran.ledger.provenances(case for case, _ in ran.asked.cases)]
    commits, processors = (sorted({str(it[key]) for it in told}) for key in ("commit", "processor"))
    return Reproduced("", "", "", 0.0, 0.0, 0.0, 0, " and ".join(commits), " and ".join(processors))


def _filled(part: _Part, results: Mapping[Case, Results], mark: Reproduced) -> Iterator[Reproduced]:
    samples: dict[tuple[str, str], list[BySeed]] = {}
    for cell in part.cells:
        samples.setdefault((cell.row, cell.column), []).append(_sample(cell, part.measure, results))
    for (row, column), parts in samples.items():
        if sum(len(values) for _, values in parts) > (part.table.statistic == "deviation"):
            found = _statistic(part.table, part.measure, parts)
            yield Reproduced(
                part.name, row, column, found.value, found.low, found.high, found.n, mark.commit, mark.processor
            )


def _lacking(part: _Part, results: Mapping[Case, Results], filled: bool) -> str:
    """Why there is no row: a measure that no trial has, a misspelt one among them; or "" where all is well."""
    cases = dict.fromkeys(case for cell in part.cells for case in (cell.case, cell.versus) if case is not None)
    if why := absent(part.measure, [results[case] for case in cases]):
        return why
    return "" if filled else f"no trial has {part.measure!r} to show"


def _sample(cell: Cell, measure: str, results: Mapping[Case, Results]) -> BySeed:
    """The numbers of a cell's trials, those that have one; or how far they differ from another planner's."""
    mine = results[cell.case]
    theirs = mine if cell.versus is None else results[cell.versus]
    if measure not in mine.measures or measure not in theirs.measures:
        return np.zeros(0, np.int64), np.zeros(0)
    if cell.versus is not None:
        return differences_by_seed(mine, theirs, measure)
    values = mine.measures[measure]
    kept = ~np.isnan(values)
    return mine.seeds[kept], values[kept]


def _statistic(table: Table, measure: str, parts: Sequence[BySeed]) -> Estimate:
    if table.statistic == "rate" and not all(np.isin(values, (0.0, 1.0)).all() for _, values in parts):
        came = f"{measure!r} came for a rate, and it is no yes or no"
        expected = "expected mean, median or deviation of it"
        raise DataFormatError(Fault("tables", f"{table.name}.statistic", came, expected))
    return pooled(parts, table.statistic)
