"""`sooner reproduce`."""

from __future__ import annotations

import os
from pathlib import Path

from sooner.cli.exits import DONE
from sooner.errors import DataFormatError, Fault

__all__ = ["reproduce"]

PAPERS = ("lin2014",)
LATER = ("kuhlman2017", "wolek2020")


def reproduce(paper: str, data: Path | None, trials: int | None, workers: int | None, out: Path | None) -> int:
    """Run a paper's study."""
    if paper in LATER:
        fault = Fault("reproduce", "", f"{paper!r} came, which this version does not do yet", "expected lin2014")
        raise DataFormatError(fault)
    if paper not in PAPERS:
        raise DataFormatError(Fault("reproduce", "", f"{paper!r} came", f"expected one of {', '.join(PAPERS)}"))
    folder = data or (Path(os.environ["SOONER_DATA"]) if os.environ.get("SOONER_DATA") else None)
    if folder is None:
        raise DataFormatError(
            Fault("--data", "", "nothing came", "expected the folder of the papers' maps, or SOONER_DATA")
        )
    if not folder.is_dir():
        raise DataFormatError(Fault("--data", "", f"{str(folder)!r} came", "expected a folder that exists"))
    from sooner.experiments import reproduce as run

    for file in run(paper, folder, trials, workers, out).files:
        print(f"written  {file}")
    return DONE
