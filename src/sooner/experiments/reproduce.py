"""`reproduce`: run a paper's study again, and set what comes out beside what was printed."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from sooner.errors import InvalidProblemError
from sooner.experiments.compare import Comparison, compare, comparison_markdown
from sooner.experiments.study import (
    Reproduced,
    find_data,
    read_published,
    read_reproduced,
    read_study,
    study_folder,
    writable_folder,
    write_atomically,
    write_reproduced,
)

__all__ = ["Reproduction", "reproduce"]


@dataclass(frozen=True)
class Reproduction:
    """What came of a study.

    Parameters
    ----------
    rows : tuple of Reproduced
    comparisons : tuple of Comparison    one for each published number
    files : tuple of Path                what was written
    """

    rows: tuple[Reproduced, ...]
    comparisons: tuple[Comparison, ...]
    files: tuple[Path, ...]


def reproduce(
    paper: str,
    data_dir: Path | None = None,
    trials: int | None = None,
    workers: int | None = None,
    out_dir: Path | None = None,
    only: Sequence[str] = ("*",),
    figures: bool = True,
    say: Callable[[str], None] = lambda line: print(line, file=sys.stderr),
) -> Reproduction:
    """Run the study of `paper`, then write `reproduced.csv`, `comparison.md` and the figures.

    Parameters
    ----------
    paper : str                 key of the study, "lin2014"
    data_dir : Path or None     folder of the real maps; None takes SOONER_DATA
    trials : int or None        seeds 0, 1, ... of each case; None takes the study's number
    workers : int or None       processes for the cases that are not timed; None takes one for each core
    out_dir : Path or None      where to write; None takes the study's own folder in a checkout, else ./<paper>
    only : sequence of str      names of the tables to run, * and ? allowed; other rows of an earlier run are kept
    figures : bool              draw the paper's figures as well, where the tables they are made from were run

    Raises
    ------
    DataFormatError             no such study, or its maps are not there
    InvalidProblemError         no trial, or no worker
    """
    folder = study_folder(paper)
    study, published = read_study(folder), read_published(folder)
    count = int(study["trials"]) if trials is None else trials
    if count < 1 or (workers is not None and workers < 1):
        raise InvalidProblemError(f"{count} trials and {workers} workers came; expected at least one of each")
    from sooner.experiments import lin2014  # the only study so far; each will have a module of its own

    data = find_data(data_dir, study["data"], study["data_example"])
    own = folder if folder.parent.parent.name == "benchmarks" else Path(paper)
    out = writable_folder(own if out_dir is None else out_dir)
    chosen = [table for table in study["tables"] if any(fnmatchcase(table["name"], name) for name in only)]
    ran, outcomes = lin2014.run_study({**study, "tables": chosen}, data, count, workers or os.cpu_count() or 1, say)
    rows = _merged(out, ran) if len(chosen) < len(study["tables"]) else ran
    comparisons = compare(published, rows, study["rules"])
    write_reproduced(out / "reproduced.csv", rows)
    write_atomically(out / "comparison.md", comparison_markdown(study["title"], comparisons, rows))
    files = [out / "reproduced.csv", out / "comparison.md"]
    if figures and set(study.get("figures_from", ())) <= {table["name"] for table in chosen}:
        from sooner.experiments.lin2014_figures import draw_figures

        files += draw_figures(study, data, outcomes, out / "figures", say)
    return Reproduction(tuple(rows), tuple(comparisons), tuple(files))


def _merged(folder: Path, ran: Sequence[Reproduced]) -> list[Reproduced]:
    """What an earlier run left in `folder`, with the rows that were run now in place of their predecessors."""
    rows = {row.key: row for row in read_reproduced(folder)} if (folder / "reproduced.csv").is_file() else {}
    return list((rows | {row.key: row for row in ran}).values())
