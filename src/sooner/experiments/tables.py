"""The tables of a study, filled from its ledger."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from sooner.campaigns.results import Results
from sooner.campaigns.run import Ran
from sooner.campaigns.statistics import Estimate, differences, estimate, rate
from sooner.campaigns.study import Cell, Study, Table
from sooner.campaigns.trial import Case
from sooner.errors import DataFormatError, Fault
from sooner.experiments.compare import tables_markdown
from sooner.experiments.published import Reproduced, reproduced_csv

__all__ = ["tables", "tables_files"]


def tables(study: Study, ran: Ran) -> list[Reproduced]:
    """A row for each cell of each table in which a trial came to its end, then for those of its table of times."""
    results = ran.results()
    mark = _marks(ran)
    rows = []
    for table in study.tables:
        for shown, measure in (table.measures or {"": table.measure or study.file.measure}).items():
            rows += list(_filled(table.name, table, measure, list(study.cells(table, shown)), results, mark))
        if table.times:
            alone = [study.alone(cell) for cell in study.cells(table)]
            rows += list(_filled(table.times, table, "timing.seconds", alone, results, mark))
    return rows


def tables_files(study: Study, ran: Ran) -> dict[str, bytes]:
    """`tables.md` and `tables.csv`, where the study asks for tables of its own."""
    if not study.file.tables:
        return {}
    rows = tables(study, ran)
    page = tables_markdown(study.file.title, rows)
    return {"tables.md": page.encode(), "tables.csv": reproduced_csv(rows).encode()}


def _marks(ran: Ran) -> Reproduced:
    """An empty row with the commits and processors that flew the trials."""
    told = [it for it, _ in ran.ledger.provenances(case for case, _ in ran.asked.cases)]
    commits, processors = (sorted({str(it[key]) for it in told}) for key in ("commit", "processor"))
    return Reproduced("", "", "", 0.0, 0.0, 0.0, 0, " and ".join(commits), " and ".join(processors))


def _filled(
    name: str, table: Table, measure: str, cells: Sequence[Cell], results: Mapping[Case, Results], mark: Reproduced
) -> Iterator[Reproduced]:
    samples: dict[tuple[str, str], list[np.ndarray]] = {}
    for cell in dict.fromkeys(cells):
        samples.setdefault((cell.row, cell.column), []).append(_sample(cell, measure, results))
    for (row, column), parts in samples.items():
        sample = np.concatenate(parts)
        if sample.size > (table.statistic == "deviation"):
            found = _statistic(table, measure, sample)
            yield Reproduced(
                name, row, column, found.value, found.low, found.high, found.n, mark.commit, mark.processor
            )


def _sample(cell: Cell, measure: str, results: Mapping[Case, Results]) -> np.ndarray:
    """The numbers of a cell's trials, those that have one; or how far they differ from another planner's."""
    mine = results[cell.case]
    if measure not in mine.measures:
        return np.zeros(0)
    if cell.versus is None:
        values = mine.measures[measure]
        return values[~np.isnan(values)]
    theirs = results[cell.versus]
    return differences(mine, theirs, measure) if measure in theirs.measures else np.zeros(0)


def _statistic(table: Table, measure: str, sample: np.ndarray) -> Estimate:
    if table.statistic != "rate":
        return estimate(sample, table.statistic)
    if not np.isin(sample, (0.0, 1.0)).all():
        came = f"{measure!r} came for a rate, and it is no yes or no"
        expected = "expected mean, median or deviation of it"
        raise DataFormatError(Fault("tables", f"{table.name}.statistic", came, expected))
    return rate(int(sample.sum()), sample.size)
