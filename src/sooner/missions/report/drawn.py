"""The pictures of a report, from what it says."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sooner.missions.report.lines import flown_lines
from sooner.missions.report.places import RichPlace
from sooner.missions.report.report import Report
from sooner.missions.report.sheet import Sheet

if TYPE_CHECKING:
    from sooner.plotting.measure import Measure
    from sooner.plotting.report_picture import MapView, Square

__all__ = ["Pictures"]

ALIKE = 2.0  # times the mean: where no cell has more, the map is drawn pale, as flights go over all of it


class Pictures:
    """Draws them one by one; all in the frame of the mission's grid."""

    def __init__(self, report: Report) -> None:
        self.report, self.score, self.mission = report, report.score, report.score.mission

    @cached_property
    def _measure(self) -> Measure:
        from sooner.plotting.measure import BITS, PROBABILITY, TARGETS

        return {"probability": PROBABILITY, "bits": BITS, "targets": TARGETS}[self.mission.sight.unit]

    @cached_property
    def _there(self) -> NDArray[np.float64]:
        return np.where(self.mission.problem.grid.passable, np.ravel(self.mission.sight.there), 0.0)

    @cached_property
    def _before(self) -> MapView:
        """What there was to find, and the borders of where drones may be."""
        from sooner.plotting.layers import there_layer
        from sooner.plotting.report_picture import MapView

        peak, paid = float(self._there.max(initial=0.0)), self._there[self._there > 0]
        alike = len(paid) > 0 and peak <= ALIKE * float(paid.mean())
        layer = there_layer(self._there, ALIKE * peak) if alike else self._measure.layer(self._there, peak)
        return MapView(self.mission.problem.grid, layer, self._borders(), self.mission.cell_m is not None)

    def _borders(self) -> list[NDArray[np.float64]]:
        if not self.mission.over_legs:
            return []
        import shapely

        moves: Any = self.mission.problem.searchers[0].moves
        parts = shapely.get_parts(moves.airspace.free)
        return [shapely.get_coordinates(ring) for part in parts for ring in (part.exterior, *part.interiors)]

    def flights(self) -> bytes:
        """All of them over the map."""
        from sooner.plotting.report_picture import draw_flights

        minutes = 1.0 if self.mission.unit_s is None else self.mission.unit_s / 60.0
        lines = [(line.points, line.times * minutes) for line in flown_lines(self.score)]
        unit = "steps" if self.mission.unit_s is None else "minutes"
        return draw_flights(self._before, lines, f"{unit} into the search")

    def left(self) -> bytes:
        """What remains, with the richest places."""
        from sooner.plotting.report_picture import draw_left

        layer = self._measure.layer(self.score.left, float(self._there.max(initial=0.0)))
        return draw_left(replace(self._before, layer=layer), [self._square(place) for place in self.report.places])

    def _square(self, place: RichPlace) -> Square:
        from sooner.plotting.report_picture import Square

        grid = self.mission.problem.grid
        numbers = np.arange(grid.n_cells).reshape(grid.shape)
        cells = numbers[place.row : place.row + place.side, place.col : place.col + place.side].ravel()
        half = grid.cell_m / 2
        low, high = grid.centres_m[cells].min(axis=0) - half, grid.centres_m[cells].max(axis=0) + half
        return Square(place.letter, (float(low[0]), float(low[1]), float(high[0]), float(high[1])))

    def growth(self) -> bytes:
        """How the value grows over time."""
        from sooner.plotting.report_picture import draw_growth

        bound = inf if self.report.bound is None else self.report.bound.value
        return draw_growth(self.score.evaluation, bound, self.mission.unit_s, self._measure)

    def one(self, sheet: Sheet) -> bytes:
        """One flight and its waypoints."""
        from sooner.plotting.report_picture import draw_one_flight

        return draw_one_flight(self._before, sheet.path)
