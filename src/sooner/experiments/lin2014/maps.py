"""The authors' maps as search problems."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from sooner.belief import Belief
from sooner.errors import DataFormatError, Fault
from sooner.grid import Grid
from sooner.problem import Searcher, SearchProblem, detection_gains
from sooner.sensors import glimpse_from_difficulty

__all__ = ["posed"]


def posed(
    data: Path, name: str, start: tuple[int, int], steps: int, end: tuple[int, int] | None = None
) -> SearchProblem:
    """One of the authors' maps as a search problem.

    Raises
    ------
    DataFormatError            naming the file that cannot be used
    """
    weights, difficulty = _read(data / f"{name}_dist.csv"), _read(data / f"{name}_diff.csv")
    if weights.shape != difficulty.shape:
        raise DataFormatError(Fault(f"{name}_diff.csv", "", f"came {difficulty.shape}", f"expected {weights.shape}"))
    gains = detection_gains(Belief.from_weights(weights), glimpse_from_difficulty(difficulty))
    return SearchProblem(Grid(weights.shape), gains, (Searcher(start, steps, end),))


def _read(path: Path) -> np.ndarray[Any, np.dtype[np.float64]]:
    try:
        return np.loadtxt(path, delimiter=",", ndmin=2)
    except (OSError, ValueError) as error:
        raise DataFormatError(Fault(str(path), "", str(error), "expected rows of numbers")) from error
