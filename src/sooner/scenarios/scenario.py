"""A scenario: a search that is ready to be planned, as a problem or as a mission's files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief
from sooner.grid import Grid
from sooner.io import raster_csv
from sooner.problem import CellMoves, Searcher, SearchProblem, detection_gains
from sooner.sensors import glimpse_from_difficulty

__all__ = ["Scenario"]


@dataclass(frozen=True, eq=False)
class Scenario:
    """A map, a sensor and a drone.

    Parameters
    ----------
    title : str
    weights : (H, W) float            where the person may be, not normalised
    start : (row, col)
    seconds : float                   flying time
    end : (row, col) or None
    difficulty : (H, W) int or None   levels; None where `glimpse` holds everywhere
    glimpse : float
    obstacles : (H, W) bool or None
    outside : float                   probability that the person is not on the map
    kind : str                        "copter" or "fixed_wing"
    cell_m, speed_mps : float
    """

    title: str
    weights: NDArray[np.float64]
    start: tuple[int, int]
    seconds: float
    end: tuple[int, int] | None = None
    difficulty: NDArray[np.int64] | None = None
    glimpse: float = 1.0
    obstacles: NDArray[np.bool_] | None = None
    outside: float = 0.0
    kind: Literal["copter", "fixed_wing"] = "copter"
    cell_m: float = 24.0
    speed_mps: float = 12.0

    @property
    def steps(self) -> int:
        """Steps T that fit into the flying time."""
        return int(self.seconds * self.speed_mps / self.cell_m + 1e-9)

    def problem(self, steps: int | None = None) -> SearchProblem:
        """The search as planners are asked it, for the whole flying time or for `steps`."""
        belief = Belief.from_weights(self.weights, self.outside)
        glimpse = self.glimpse if self.difficulty is None else glimpse_from_difficulty(self.difficulty)
        moves = CellMoves(self.kind, self.cell_m / self.speed_mps)
        searcher = Searcher(self.start, steps or self.steps, self.end, moves)
        height, width = self.weights.shape
        grid = Grid((height, width), cell_m=self.cell_m, obstacles=self.obstacles)
        return SearchProblem(grid, detection_gains(belief, glimpse), (searcher,))

    def files(self) -> dict[str, bytes]:
        """A mission file and its rasters, by name; what `sooner scenario` writes."""
        files = {"poc.csv": raster_csv(self.weights)}
        if self.difficulty is not None:
            files["difficulty.csv"] = raster_csv(self.difficulty)
        if self.obstacles is not None:
            files["obstacles.csv"] = raster_csv(self.obstacles)
        return {"mission.toml": self._mission().encode()} | files

    def as_written(self) -> Scenario:
        """The same with weights as the files hold them, rounded."""
        return replace(self, weights=np.round(self.weights, 6))

    def _mission(self) -> str:
        lines = [f'name = "{self.title}"', "", "[area]", 'poc = "poc.csv"']
        if self.obstacles is not None:
            lines.append('obstacles = "obstacles.csv"')
        lines += [f"outside = {self.outside}", f"cell_m = {self.cell_m}", "", "[sensor]"]
        lines.append('difficulty = "difficulty.csv"' if self.difficulty is not None else f"glimpse = {self.glimpse}")
        lines += ["", "[[searcher]]", f"start = {list(self.start)}"]
        if self.end is not None:
            lines.append(f"end = {list(self.end)}")
        lines += [f'kind = "{self.kind}"', f"speed_mps = {self.speed_mps}"]
        lines += ["", "[budget]", f"seconds = {self.seconds}", "", "[objective]", 'kind = "detection"']
        return "\n".join(lines) + "\n"
