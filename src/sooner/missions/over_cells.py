"""A mission whose drones move from cell to cell."""

from __future__ import annotations

import numpy as np

from sooner.belief import Belief
from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.missions.faults import Faults
from sooner.missions.layers import Layers
from sooner.missions.places import Place
from sooner.missions.settings import MAX_STEPS, Settings
from sooner.missions.sight import Sight
from sooner.problem import CellMoves, Searcher, SearchProblem, detection_gains

__all__ = ["OverCells"]

NOTE = "seconds count level flight at constant speed; turns cost no time in this version"


class OverCells:
    """What the file says of such a search, checked as far as it can be without knowing what looks pay."""

    def __init__(
        self, faults: Faults, settings: Settings, layers: Layers, places: list[tuple[Place | None, Place | None]]
    ) -> None:
        self.faults, self.settings, self.cell_m = faults, settings, layers.cell_m
        self.notes = (NOTE,) if settings.budget.seconds is not None else ()
        if settings.regions is not None:
            faults.add("regions", "it came", 'expected it left out, or searcher.moves = "regions"')
        self.grid = None
        if layers.shape is not None:
            cell_m = 1.0 if self.cell_m is None else self.cell_m
            self.grid = Grid(layers.shape, settings.area.grid, cell_m, layers.obstacles)
        steps_s = self._steps_s(layers)
        self.step_s = steps_s[0] if steps_s else None
        self.searchers = [
            self._searcher(number, *place, steps_s[number] if steps_s else None) for number, place in enumerate(places)
        ]

    def _steps_s(self, layers: Layers) -> list[float] | None:
        """Seconds that a step of each searcher takes; None where the file does not say how fast they are."""
        speeds = [searcher.speed_mps for searcher in self.settings.searcher]
        if self.settings.budget.seconds is not None:
            if self.cell_m is None and layers.shape is not None:
                expected = "expected metres: a budget in seconds needs the size of a cell"
                self.faults.add("area.cell_m", "nothing came", expected)
            for number, speed in enumerate(speeds):
                if speed is None:
                    expected = "expected metres a second: a budget in seconds needs the speed"
                    self.faults.add(f"searcher[{number}].speed_mps", "nothing came", expected)
        if self.cell_m is None or not speeds or any(speed is None for speed in speeds):
            return None
        # the longest step of the grid, so that no flight takes longer than it says
        longest = self.cell_m * (2.0**0.5 if self.settings.area.grid == "square8" else 1.0)
        return [longest / speed for speed in speeds if speed is not None]

    def _searcher(self, number: int, start: Place | None, end: Place | None, step_s: float | None) -> Searcher | None:
        said, steps = self.settings.searcher[number], self.settings.budget.steps
        if self.settings.budget.seconds is not None and step_s is not None:
            steps = self._steps(self.settings.budget.seconds, step_s)
        ends_wrong = said.end is not None and end is None
        if self.grid is None or start is None or steps is None or ends_wrong:
            return None
        searcher = Searcher(start, steps, end, CellMoves(said.kind, step_s or 1.0))
        try:  # whether its end can be reached in its budget
            SearchProblem(self.grid, detection_gains(Belief.from_weights(np.ones(self.grid.shape)), 1.0), (searcher,))
        except InvalidProblemError as error:
            came = str(error).removeprefix("searcher 0: ")
            self.faults.add(f"searcher[{number}].end", came, "expected an end that can be reached in the budget")
            return None
        return searcher

    def _steps(self, seconds: float, step_s: float) -> int | None:
        """The steps that fit."""
        steps, came = int(seconds / step_s + 1e-9), f"{seconds:g} s came, and one step takes {step_s:g} s"
        if steps < 1:
            self.faults.add("budget.seconds", came, "expected time for at least one step")
            return None
        if steps > MAX_STEPS:
            self.faults.add("budget.seconds", came, f"expected time for at most {MAX_STEPS:,} steps")
            return None
        return steps

    def problem(self, sight: Sight) -> SearchProblem:
        """The search as planners are asked it."""
        assert self.grid is not None
        searchers = tuple(searcher for searcher in self.searchers if searcher is not None)
        return SearchProblem(self.grid, sight.gains, searchers, sight.objective)
