"""A mission whose drones fly straight legs between any places: sorties, honest time, a swath beneath them."""

from __future__ import annotations

from functools import cached_property
from math import hypot
from typing import Any

import numpy as np

from sooner.errors import InvalidProblemError
from sooner.grid import Grid
from sooner.grid.airspace import Airspace
from sooner.io.georeference import Georeference
from sooner.missions.area_layers import LEAST_TOLD, check_seen
from sooner.missions.faults import Faults
from sooner.missions.finer import finer, parts_for
from sooner.missions.fleet import Fleet, Sortie
from sooner.missions.layers import Layers
from sooner.missions.places import Place
from sooner.missions.settings import Place as OnGlobe
from sooner.missions.settings import Settings
from sooner.missions.sight import Sight
from sooner.motion.pace import Pace, Terrain
from sooner.motion.wind import Wind
from sooner.problem import Searcher, SearchProblem
from sooner.problem.gains import effort_gains
from sooner.problem.leg_moves import LegMoves
from sooner.sensors.swath import CUBE_REACH, Swath

__all__ = ["OverLegs"]

SMOOTHED_CELLS = 2  # of elevation, over which the height that is flown is smoothed
MOST_SORTIES = 100
SAME_M = 1.0  # within which two places are one

Metres = tuple[float, float]


class OverLegs:
    """What the file says of such a search, checked as far as it can be without knowing what looks pay."""

    step_s = None  # time is told in seconds as it is

    def __init__(
        self, faults: Faults, settings: Settings, layers: Layers, places: list[tuple[Place | None, Place | None]]
    ) -> None:
        self.faults, self.settings, self.layers, self.places = faults, settings, layers, places
        self._notes: tuple[str, ...] = ()
        self._check_keys()
        self.fleet = Fleet(faults, settings)
        self.radius_m = self.fleet.reach_m()
        self.coarse = layers
        self.layers = self._finer(layers)
        self.sorties: tuple[Sortie, ...] = ()
        self.space = self._airspace()

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know about how the file was understood."""
        return self.fleet.notes + self._notes

    # ------------------------------------------------------------ what the file says

    def _check_keys(self) -> None:
        add, settings = self.faults.add, self.settings
        if settings.area.grid == "hex":
            add("area.grid", "'hex' came", "expected square cells, over which discs are swept")
        if settings.budget.steps is not None:
            add(
                "budget.steps", f"{settings.budget.steps} came", "expected budget.seconds: along legs flights are timed"
            )
        if self.layers.cell_m is None and self.layers.shape is not None:
            add("area.cell_m", "nothing came", "expected metres: along legs flights are timed")
        if settings.objective.kind == "information":
            add("objective.kind", "'information' came", 'expected "detection" along legs, or moves = "regions"')
        if settings.objective.detection_target is not None:
            expected = 'expected it left out along legs: the most by the end; or moves = "regions"'
            add("objective.detection_target", f"{settings.objective.detection_target:g} came", expected)
        if settings.sensor.model == "beta" or settings.sensor.false_alarm:
            add("sensor", "looks that err came", 'expected looks that detect or miss along legs, or moves = "regions"')
        looks = [key for key in ("difficulty", "glimpse", "land_cover") if getattr(settings.sensor, key) is not None]
        if settings.sensor.sweep_width_m is not None and looks:
            expected = "expected one of them: a sweep width says all that a sensor detects"
            add(f"sensor.{looks[0]}", "it came beside sweep_width_m", expected)
        if settings.sensor.correlation:
            add("sensor.correlation", f"{settings.sensor.correlation:g} came", "expected it left out along legs")
        if settings.sensor.range_m is not None:
            add("sensor.range_m", "it came", "expected it left out along legs, which keep clear of what is known")
        if settings.regions is not None:
            add("regions", "it came", 'expected it left out, or searcher.moves = "regions"')
        if settings.links is not None:
            add("links", "it came", "expected it left out along legs, which one computer plans for all")

    # ------------------------------------------------------------ ground

    def _finer(self, layers: Layers) -> Layers:
        """The layers over cells that are small beside what is in view."""
        if layers.shape is None or layers.cell_m is None or self.faults.found:
            return layers
        sensor = self.settings.sensor
        reach, sure = self.radius_m, sensor.sweep_width_m is None
        widest = 0.0 if layers.sweep_width is None else float(np.max(layers.sweep_width))
        if reach is None and not sure:
            reach = widest * (CUBE_REACH if sensor.law == "inverse_cube" else 0.5)
        if not reach:
            return layers
        if layers.area is not None:
            check_seen(self.faults, self.settings, layers.area.polygon, reach if sure else widest / 2.0)
        parts = parts_for(reach, layers.cell_m, layers.shape[0] * layers.shape[1], sure)
        if parts > 1:
            self._notes += (
                f"cells of {layers.cell_m:g} m are cut into {parts} x {parts}, as looks reach {reach:.3g} m",
            )
        return finer(layers, parts)

    def _airspace(self) -> Airspace | None:
        """Where drones may be."""
        area = self.layers.area
        try:
            if area is not None:
                return Airspace(area.flyable(self.settings.area.margin_m, self.layers.obstacles))
            if self.layers.shape is None or self.layers.cell_m is None:
                return None
            stones = self.layers.obstacles
            free = np.ones(self.layers.shape, bool) if stones is None else ~stones
            return Airspace.of_cells(free, self.layers.cell_m)
        except InvalidProblemError as error:
            if "area.margin_m" not in self.faults.wrong:
                self.faults.add("area", str(error), "expected ground to fly over")
            return None

    def _exactly(self, said: Any, cell: Place) -> Metres:
        """A start or end in metres: as its coordinates say, or at the centre of its cell."""
        assert self.layers.shape is not None
        assert self.layers.cell_m is not None
        area, cell_m = self.layers.area, self.layers.cell_m
        if isinstance(said, str) and area is not None:
            return area.points[said]
        if isinstance(said, OnGlobe) and self.layers.first is not None:
            row, col = Georeference.of(self.layers.first).cells([[said.lat, said.lon]])[0]
        else:
            row, col = self._finer_cell(cell)
        return float(col * cell_m), float((self.layers.shape[0] - 1 - row) * cell_m)

    def _finer_cell(self, cell: Place) -> tuple[float, float]:
        """Row and column, as fractions, of the middle of a cell of the map as it came."""
        assert self.coarse.cell_m is not None
        assert self.layers.cell_m is not None
        parts = round(self.coarse.cell_m / self.layers.cell_m)
        return cell[0] * parts + (parts - 1) / 2, cell[1] * parts + (parts - 1) / 2

    @cached_property
    def terrain(self) -> Terrain | None:
        """The surface that flights follow."""
        area = self.layers.area
        if area is None or area.elevation is None or self.layers.cell_m is None:
            return None
        return Terrain(area.elevation, self.layers.cell_m).smoothed(SMOOTHED_CELLS * self.layers.cell_m)

    @property
    def _wind(self) -> Wind:
        """Where the wind blows to on the map, whose north may lean."""
        said, first, shape = self.settings.wind, self.layers.first, self.layers.shape
        if said is None:
            return (0.0, 0.0)
        if first is None or first.corner is None or shape is None:
            return said.blows_to
        return said.over(Georeference.of(first), shape)

    def _above_ground_m(self, said: Any, cell: Place | None) -> float:
        """By how much the surface that is followed is higher than the ground at a start or end."""
        area, cell_m = self.layers.area, self.layers.cell_m
        if self.terrain is None or area is None or area.elevation is None or cell_m is None or cell is None:
            return 0.0
        place = np.array([self._exactly(said, cell)])
        return float((self.terrain.heights_at(place) - Terrain(area.elevation, cell_m).heights_at(place))[0])

    # ------------------------------------------------------------ the problem

    def _swath(self, grid: Grid, sight: Sight) -> Swath | None:
        sensor = self.settings.sensor
        radius = self.radius_m
        try:
            if sensor.sweep_width_m is None:
                assert radius is not None
                swath = Swath.of_glimpse(grid, sight.glimpse, radius)
            else:
                width = self.layers.sweep_width
                assert width is not None
                swath = Swath.of_width(grid, width, radius, "cube" if sensor.law == "inverse_cube" else "even")
        except InvalidProblemError as error:
            self.faults.add("sensor", str(error), "expected a sensor that can be so")
            return None
        if swath.radius_m < grid.cell_m / 2:
            came = f"looks reach {swath.radius_m:.3g} m, and cells are {grid.cell_m:g} m"
            self.faults.add(
                "sensor.radius_m", came, f"expected at least half a cell, {grid.cell_m / 2:g} m; or finer cells"
            )
        return swath

    def problem(self, sight: Sight) -> SearchProblem:
        """The search as planners are asked it.

        Raises
        ------
        DataFormatError        where a place is not in the airspace, or cannot be reached in time
        """
        assert self.layers.shape is not None
        assert self.layers.cell_m is not None
        assert self.space is not None
        grid = Grid(self.layers.shape, "square8", self.layers.cell_m)
        swath = self._swath(grid, sight)
        searchers, sorties = [], []
        for number, said in enumerate(self.settings.searcher):
            start, end = self.places[number]
            up_m = self._above_ground_m(said.start, start)
            down_m = up_m if end is None else self._above_ground_m(said.end, end)
            flights = self.fleet.flights(number, (up_m, down_m))
            if swath is None or not flights or start is None:
                continue
            pace, home = self.fleet.pace(number, self._wind, self.terrain), self._exactly(said.start, start)
            goal = None if end is None else self._exactly(said.end, end)
            if goal is not None and said.batteries > 1 and hypot(goal[0] - home[0], goal[1] - home[1]) > SAME_M:
                came = f"a place other than the start came beside {said.batteries} batteries"
                self.faults.add(f"searcher[{number}].end", came, "expected the start, where batteries are; or one")
            for sortie, budget_s, departs_s in flights:
                lands = goal if goal is not None or sortie.vehicle is None else home
                found = self._searcher(number, budget_s, home, lands, pace, swath, departs_s)
                if found is not None:
                    searchers.append(found)
                    sorties.append(sortie)
        if len(sorties) > MOST_SORTIES:
            self.faults.add("searcher", f"{len(sorties)} sorties came", f"expected at most {MOST_SORTIES}")
        self._check_reach(searchers, sorties)
        self.faults.refuse()
        self._notes += self._cut_off(searchers, grid, sight)
        self.sorties = tuple(sorties)
        problem = SearchProblem(grid, effort_gains(sight.theta), tuple(searchers), sight.objective)
        return problem

    def _check_reach(self, searchers: list[Searcher], sorties: list[Sortie]) -> None:
        """Starts from which no way leads to the search area, or none that a battery lasts for, as the crow flies."""
        import shapely

        area = self.layers.area
        for searcher, sortie in zip(searchers, sorties, strict=True):
            moves = searcher.moves
            if area is None or not isinstance(moves, LegMoves):
                continue
            key, sees_m, home = f"searcher[{sortie.drone}].start", moves.swath.radius_m, shapely.Point(moves.home)
            parts = shapely.get_parts(moves.airspace.free)
            if not any(part.covers(home) and part.distance(area.polygon) <= sees_m for part in parts):
                came = "a start came from which no way leads to the search area, but through no-fly zones or margins"
                self.faults.once(key, came, "expected another start, a wider area.flight_area or a smaller margin_m")
            ends = [home, shapely.Point(moves.end or moves.home)]
            far_m = sum(max(float(area.polygon.distance(each)) - sees_m, 0.0) for each in ends)
            if sortie.vehicle is not None and far_m / moves.pace.speed_mps > searcher.budget:
                came = f"{far_m:.0f} m to the search area and back came, and {searcher.budget:.0f} s for it"
                self.faults.once(key, came, "expected a nearer start, or a longer endurance_s")

    def _cut_off(self, searchers: list[Searcher], grid: Grid, sight: Sight) -> tuple[str, ...]:
        """How much lies on ground that drones could see from the airspace, but only where no way leads from a start."""
        import shapely

        moves = [each.moves for each in searchers if isinstance(each.moves, LegMoves)]
        parts = shapely.get_parts(moves[0].airspace.free)
        held = np.array([any(part.covers(shapely.Point(each.home)) for each in moves) for part in parts])
        worth = np.asarray(sight.theta, np.float64).ravel()
        cells = np.flatnonzero(worth > 0)
        if held.all() or not len(cells):
            return ()
        places, sees_m = shapely.points(grid.centres_m[cells]), moves[0].swath.radius_m
        joined, others = (shapely.MultiPolygon(list(parts[which])) for which in (held, ~held))
        shapely.prepare([joined, others])
        lost = shapely.dwithin(others, places, sees_m) & ~shapely.dwithin(joined, places, sees_m)
        share = float(worth[cells[lost]].sum() / worth.sum())
        told = f"{share:.1%} of the {sight.unit} on the map lies on ground to which no way leads from any start"
        return (told,) if share > LEAST_TOLD else ()

    def _searcher(
        self,
        number: int,
        budget_s: float,
        home: Metres,
        end: Metres | None,
        pace: Pace,
        swath: Swath,
        departs_s: float,
    ) -> Searcher | None:
        key = f"searcher[{number}]"
        assert self.space is not None
        try:
            moves = LegMoves(self.space, pace, swath, home, end, departs_s)
        except InvalidProblemError as error:
            came, _, expected = str(error).partition("; ")
            which = "end" if came.startswith("end") else "start"
            self.faults.add(f"{key}.{which}", came, f"expected a place in the area: {expected}")
            return None
        searcher = Searcher(self._under(home), budget_s, None if end is None else self._under(end), moves)
        try:
            moves.check(Grid(self.layers.shape or (1, 1), "square8", self.layers.cell_m or 1.0), searcher)
        except InvalidProblemError as error:
            came, _, more = str(error).partition("; ")
            self.faults.add(f"{key}.end", came, f"expected a place that can be reached in time: {more}".rstrip(": "))
            return None
        return searcher

    def _under(self, place: Metres) -> Place:
        """The cell beneath a place."""
        assert self.layers.shape is not None
        assert self.layers.cell_m is not None
        height, width = self.layers.shape
        row, col = height - 1 - round(place[1] / self.layers.cell_m), round(place[0] / self.layers.cell_m)
        return min(max(row, 0), height - 1), min(max(col, 0), width - 1)
