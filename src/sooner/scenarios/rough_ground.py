"""Rough ground: obstacles of many shapes, half of the ground known better than the rest, and a drone with inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sooner.belief import EvidenceGrid
from sooner.decomposition import boustrophedon, regions_for, spacing_for
from sooner.grid import Grid
from sooner.io import raster_csv
from sooner.motion.kinematics import Dynamics
from sooner.problem import Objective, SearchProblem, information_gains
from sooner.problem.region_problem import Sweep, region_problem
from sooner.scenarios.natural import natural_environment
from sooner.sensors import BinarySensor

__all__ = ["RoughGround", "rough_ground"]

DECIMALS = 4  # of the evidence raster


@dataclass(frozen=True, eq=False)
class RoughGround:
    """A search over regions for what is to be learnt.

    Parameters
    ----------
    title : str
    evidence : (H, W) float      P(a target is in this cell), each cell by itself
    obstacles : (H, W) bool
    start : (row, col)           and end
    seconds : float              flying time
    cell_m, radius_m, speed_mps, accel_mps2 : float
    detect, false_alarm : float
    """

    title: str
    evidence: NDArray[np.float64]
    obstacles: NDArray[np.bool_]
    start: tuple[int, int]
    seconds: float = 1500.0
    cell_m: float = 2.2
    radius_m: float = 8.8
    speed_mps: float = 5.0
    accel_mps2: float = 2.0
    detect: float = 0.85
    false_alarm: float = 0.15

    def problem(self, steps: int | None = None) -> SearchProblem:
        """The search as planners are asked it, for the whole flying time or for so many seconds."""
        grid = Grid(self.obstacles.shape, "square8", self.cell_m, self.obstacles)
        gains = information_gains(EvidenceGrid(self.evidence), BinarySensor(self.detect, self.false_alarm))
        seconds, wish = steps or self.seconds, Objective("information")
        flown_m, ground_m2 = self.speed_mps * seconds, float(grid.passable.sum()) * self.cell_m**2
        spacing_m = spacing_for(self.radius_m, flown_m * self.radius_m, ground_m2)
        plain = boustrophedon(grid, at_width=grid.shape[1])
        regions = regions_for(grid, gains.first, plain, swept_m2=flown_m * spacing_m)
        sweep = Sweep(Dynamics(self.speed_mps, self.accel_mps2), self.radius_m, spacing_m)
        return region_problem(grid, regions, sweep, gains, [self.start], seconds, [self.start], wish)

    def files(self) -> dict[str, bytes]:
        """A mission file and its rasters, by name; what `sooner scenario` writes."""
        return {
            "mission.toml": self._mission().encode(),
            "evidence.csv": raster_csv(self.evidence),
            "obstacles.csv": raster_csv(self.obstacles.astype(np.int64)),
        }

    def as_written(self) -> RoughGround:
        """Itself: its evidence is rounded from the beginning."""
        return self

    def _mission(self) -> str:
        return f"""\
name = "{self.title}"

[area]
evidence = "evidence.csv"    # P(a target is in this cell), each cell by itself; 0.5 where nothing is known
obstacles = "obstacles.csv"
cell_m = {self.cell_m}

[sensor]
detect = {self.detect}                # P(a look says yes, if a target is there)
false_alarm = {self.false_alarm}           # P(a look says yes, if none is there)
radius_m = {self.radius_m}               # what is in view from the path

[[searcher]]
start = {list(self.start)}
end = {list(self.start)}
moves = "regions"
speed_mps = {self.speed_mps}
accel_mps2 = {self.accel_mps2}

# [regions]
# turns = "rounded"          # arcs from line to line instead of stops

[budget]
seconds = {self.seconds}

[objective]
kind = "information"         # or "detection"
"""


def rough_ground(seed: int = 0) -> RoughGround:
    """100 x 200 cells of 2.2 m; half of the ground has had two hits in each cell, of the other half nothing is known.

    The drone starts from, and returns to, the free cell nearest the south-west corner.
    """
    environment = natural_environment("med", seed + 1, nonuniform=True)
    rows, cols = np.nonzero(environment.free)
    nearest = int(np.argmin((environment.grid.shape[0] - 1 - rows) ** 2 + cols**2))
    return RoughGround(
        "Rough ground, 440 m x 220 m",
        np.round(environment.theta, DECIMALS),
        ~environment.free,
        (int(rows[nearest]), int(cols[nearest])),
    )
