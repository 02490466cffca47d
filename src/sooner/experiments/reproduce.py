"""`reproduce`: fly a paper's study, and set what comes out beside what was printed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from glob import escape
from importlib import import_module
from pathlib import Path
from typing import Any

from sooner.campaigns.campaign import Progress, Watch
from sooner.campaigns.report import REPORT, write_report
from sooner.campaigns.run import Earlier, Ran, find_data, recall_study, refuse_none, run_study
from sooner.campaigns.study import Study, read_study
from sooner.campaigns.trial import Case
from sooner.experiments.compare import Comparison, compare, comparison_markdown
from sooner.experiments.published import (
    Reproduced,
    read_published,
    read_reproduced,
    reproduced_csv,
    study_folder,
)
from sooner.experiments.tables import tables
from sooner.io.writing import Folder

__all__ = ["Reproduction", "reproduce"]


@dataclass(frozen=True)
class Reproduction:
    """What came of a study.

    Parameters
    ----------
    rows : tuple of Reproduced
    comparisons : tuple of Comparison    one for each published number
    files : tuple of Path                what was written
    progress : Progress                  trials that are done
    aside : tuple                        trials that failed for good: which, how and why
    notes : tuple of str                 what the reader should know about it
    """

    rows: tuple[Reproduced, ...]
    comparisons: tuple[Comparison, ...]
    files: tuple[Path, ...]
    progress: Progress
    aside: tuple[tuple[str, str, str], ...]
    notes: tuple[str, ...] = ()


def reproduce(
    paper: str,
    data_dir: Path | None = None,
    trials: int | None = None,
    workers: int | None = None,
    out_dir: Path | None = None,
    only: Sequence[str] = ("*",),
    figures: bool = True,
    scheduler: str | None = None,
    earlier: Earlier = "ask",
    retry: bool = False,
    force: bool = False,
    watch: Watch = lambda progress: None,
    recall: bool = False,
) -> Reproduction:
    """Fly the study of `paper`, then write `reproduced.csv`, `comparison.md`, the figures and every trial.

    What an earlier run has flown is not flown again.

    Parameters
    ----------
    paper : str                 key of the study, "lin2014"
    data_dir : Path or None     folder of the real maps, for studies that have some; None takes SOONER_DATA
    trials : int or None        seeds 0, 1, ... of each case; None takes the study's number
    workers : int or None       processes; None takes one for each core
    out_dir : Path or None      where to write; None takes the study's own folder in a checkout, else ./<paper>
    only : sequence of str      names of the tables to fly, * and ? allowed; other rows of an earlier run are kept
    figures : bool              draw the paper's figures as well, where the tables they are made from were flown
    scheduler, earlier, retry, watch    as in `run_study`
    force : bool                replace files in `out_dir` even where sooner did not write them
    recall : bool               fly nothing; write what the ledger has

    Raises
    ------
    DataFormatError             no such study, its maps are not there, or its ledger or files cannot be written
    InvalidProblemError         no trial, or no worker
    """
    refuse_none(trials, workers)
    home = study_folder(paper)
    whole = read_study(home)
    study = whole.only(only)
    data = find_data(data_dir, study.file.data, study.file.data_files) if study.file.data else study.folder
    in_checkout = home.parent.parent.name == "benchmarks"  # there a repository keeps what was before
    out = Folder(out_dir or (home if in_checkout else Path(paper)), force or (in_checkout and out_dir is None))
    out.check("reproduced.csv", "comparison.md", *REPORT)
    standing = _standing(whole, study, out.path)
    with (
        recall_study(study, out.path, trials)
        if recall
        else run_study(
            study, out.path, data_dir, trials, workers, scheduler, earlier, retry, watch, _flown_for(whole, standing)
        )
    ) as ran:
        filled = tables(study, ran)
        rows = _merged(out.path, [*filled, *_claimed(study, ran, filled, data)])
        comparisons = compare(read_published(home), rows, study.rules)
        pages = {
            "reproduced.csv": reproduced_csv(rows).encode(),
            "comparison.md": comparison_markdown(study.file.title, comparisons, rows).encode(),
        }
        drawn = dict(_hook(study, "figures")(ran, study, data)) if figures and _can_draw(study, ran) else {}
        report = write_report(ran, study.file.title, out, pages, study.file.measure)
        aside = tuple((str(trial), ending, reason) for trial, ending, reason in ran.set_aside())
    pictures = Folder(out.path / "figures", out.force)
    pictures.write(drawn)
    files = (*report.files, *(pictures.path / name for name in drawn))
    notes = (*report.notes, *_elsewhere(standing, rows, {row.commit for row in filled}))
    return Reproduction(tuple(rows), tuple(comparisons), files, ran.progress, aside, notes)


def _hook(study: Study, name: str) -> Callable[..., Iterable[Any]]:
    """A function of the paper's own, as its study names it; one that has nothing to say where there is none."""
    if name not in study.file.paper:
        return lambda *_: ()
    module, function = study.file.paper[name].split(":")
    found: Callable[..., Iterable[Any]] = getattr(import_module(module), function)
    return found


def _can_draw(study: Study, ran: Ran) -> bool:
    """Every table that the figures are made from was flown, and nothing of it is missing."""
    flown = {table.name for table in study.tables}
    return set(study.file.paper.get("figures_from", ())) <= flown and not ran.set_aside()


def _claimed(study: Study, ran: Ran, filled: Sequence[Reproduced], data: Path) -> list[Reproduced]:
    """What the paper says of its tables rather than in them, counted in ours."""
    value = {row.key: row.value for row in filled}
    commit, processor = (filled[0].commit, filled[0].processor) if filled else ("", "")
    return [
        Reproduced(table, row, column, claimed, claimed, claimed, n, commit, processor)
        for table, row, column, claimed, n in _hook(study, "claims")(ran, study, value, data)
    ]


def _standing(whole: Study, study: Study, folder: Path) -> list[str]:
    """Tables whose rows an earlier run left in `folder`, and which are not flown now."""
    if not (folder / "reproduced.csv").is_file():
        return []
    there = {row.table for row in read_reproduced(folder)}
    flown = {name for table in study.tables for name in (table.name, table.times)}
    return [table.name for table in whole.tables if {table.name, table.times} & (there - flown)]


def _flown_for(whole: Study, tables: Sequence[str]) -> tuple[tuple[Case, range], ...]:
    """The cases of these tables, whose results must not be of other code unless the user says so."""
    return whole.only([escape(name) for name in tables]).asked().cases if tables else ()


def _elsewhere(standing: Sequence[str], rows: Sequence[Reproduced], commits: set[str]) -> Iterator[str]:
    """One line where rows that were not flown now are of another commit: they say of which."""
    others = sorted({row.commit or "unknown" for row in rows if row.table in standing and row.commit not in commits})
    if others:
        yield f"rows of {', '.join(standing)} are those of an earlier run (commit {', '.join(others)})"


def _merged(folder: Path, ran: Sequence[Reproduced]) -> list[Reproduced]:
    """What an earlier run left in `folder`, with the rows that were run now in place of their predecessors."""
    rows = {row.key: row for row in read_reproduced(folder)} if (folder / "reproduced.csv").is_file() else {}
    return list((rows | {row.key: row for row in ran}).values())
