"""A mission whose drones search whole regions, flown with true accelerations."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import inf, radians
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.decomposition import Regions, boustrophedon, regions_for, spacing_for
from sooner.errors import InfeasibleProblemError, InvalidProblemError
from sooner.grid import Grid
from sooner.missions.faults import Faults
from sooner.missions.layers import Layers
from sooner.missions.places import Place, components
from sooner.missions.settings import CameraSettings, Cutting, Searching, Settings
from sooner.missions.sight import Sight
from sooner.motion.kinematics import Dynamics
from sooner.problem import SearchProblem
from sooner.problem.region_problem import Sweep, region_problem
from sooner.problem.regions import ROUNDING_S, RegionMoves
from sooner.sensors.camera import Camera, speed_to_stop

__all__ = ["OverRegions", "camera_sight", "dynamics_of"]

# In radii of the sensor: what the paper's counts of regions ask for at its 8.8 m, 75 cells of 2.2 m and 3 columns.
MIN_AREA, MIN_WIDTH = 75 * 2.2**2 / 8.8**2, 3 * 2.2 / 8.8
CHUNK, MIN_CHUNK = 52.8 / 8.8, 363.0 / 8.8**2  # tuned at the same radius, see `regions_for`
FARTHEST_M = 1e6  # that a camera sees, as `sensor.radius_m`
MAX_ACTIONS = 50_000  # of a flight: at four times as many, a plan of 3 s was 30 s late
SMALL_PART = 0.005  # of free ground, cut off: not worth a note


class OverRegions:
    """What the file says of such a search, checked as far as it can be without cutting the ground."""

    step_s = None  # time is told in seconds as it is

    def __init__(
        self, faults: Faults, settings: Settings, layers: Layers, places: list[tuple[Place | None, Place | None]]
    ) -> None:
        self.faults, self.settings, self.layers, self.places = faults, settings, layers, places
        self.notes: tuple[str, ...] = ()
        self._check_keys()
        seen = _Reach.of(faults, settings)
        self.reaches = [seen.ahead(settings.sensor.range_m, each.accel_mps2) for each in settings.searcher]
        self.free = self._free()
        self.sweeps = self._sweeps()
        for reach, said in zip(self.reaches, settings.searcher, strict=True):
            if reach.speed_mps < (said.speed_mps or 0.0):
                note = f"{reach.why} allows {reach.speed_mps:.3g} m/s; nothing flies faster"
                self.notes += (note,) if note not in self.notes else ()

    def _check_keys(self) -> None:
        add, settings = self.faults.add, self.settings
        if settings.area.grid == "hex":
            add("area.grid", "'hex' came", "expected square cells, which regions are cut along")
        if settings.budget.steps is not None and settings.budget.seconds is None:
            add(
                "budget.steps",
                f"{settings.budget.steps} came",
                "expected budget.seconds: over regions flights are timed",
            )
        if self.layers.cell_m is None and self.layers.shape is not None:
            add("area.cell_m", "nothing came", "expected metres: over regions flights are timed")
        if settings.regions is not None and settings.regions.chunk_m is not None and settings.regions.cut == "plain":
            add("regions.chunk_m", f"{settings.regions.chunk_m:g} m came", 'expected cut = "aware", which has chunks')
        for number, searcher in enumerate(settings.searcher):
            for key, unit in (("speed_mps", "metres a second"), ("accel_mps2", "metres a second squared")):
                if getattr(searcher, key) is None:
                    add(f"searcher[{number}].{key}", "nothing came", f"expected {unit}: over regions flights are timed")

    def _sweeps(self) -> list[Sweep] | None:
        """How each drone flies regions; None where something is missing."""
        cell_m, radius_m = self.layers.cell_m, self.reaches[0].radius_m
        cutting = self.settings.regions or Cutting()
        if radius_m is None:
            return None
        if cell_m is not None and radius_m < cell_m / 2:
            key = "sensor.radius_m" if self.settings.sensor.camera is None else "sensor.camera"
            came = f"{radius_m:.3g} m came, and cells of {cell_m:g} m"
            self.faults.add(key, came, f"expected at least half a cell, {cell_m / 2:g} m: looks must cover the path")
        found = [each.dynamics(said) for each, said in zip(self.reaches, self.settings.searcher, strict=True)]
        flown = [dynamics for dynamics in found if dynamics is not None]
        if len(flown) < len(found):
            return None
        spacing_m = self._spacing_m(radius_m, flown)
        return [
            Sweep(
                dynamics,
                radius_m,
                spacing_m,
                taut=cutting.ways == "taut",
                round_turns=cutting.turns == "rounded",
                looks=cutting.looks,
            )
            for dynamics in flown
        ]

    def _spacing_m(self, radius_m: float, flown: list[Dynamics]) -> float:
        """Between plow lines: what the file says; else the radius, more where time is short."""
        said = self.settings.regions.spacing_m if self.settings.regions else None
        if said is not None:
            if said > 2 * radius_m:
                came = f"{said:g} m came, and looks reach {radius_m:.3g} m"
                expected = (
                    f"expected at most twice as much, {2 * radius_m:.3g} m: the ground between lines must be seen"
                )
                self.faults.add("regions.spacing_m", came, expected)
            return said
        ground_m2 = 0.0 if self.free is None else float(self.free.sum()) * (self.layers.cell_m or 0.0) ** 2
        spacing_m = spacing_for(radius_m, float(self._swept_m2(radius_m, flown).sum()), ground_m2)
        if spacing_m > radius_m:
            self.notes += (f"time is short for so much ground: lines are flown {spacing_m:.3g} m apart",)
        return spacing_m

    def _swept_m2(self, spacing_m: float, flown: list[Dynamics]) -> NDArray[np.float64]:
        """About how much ground each drone can sweep in the time."""
        speeds = np.array([dynamics.v_max for dynamics in flown])
        return speeds * spacing_m * (self.settings.budget.seconds or 0.0)

    def _free(self) -> NDArray[np.bool_] | None:
        """(H, W) bool: free ground that can be reached from some start."""
        if self.layers.shape is None:
            return None
        stones = self.layers.obstacles
        free = np.ones(self.layers.shape, bool) if stones is None else ~stones
        pieces = components(free)
        for number, (start, end) in enumerate(self.places):
            if start is not None and end is not None and pieces[start] != pieces[end]:
                came = f"{list(end)} came, which cannot be reached from {list(start)}: obstacles lie all around one"
                self.faults.add(f"searcher[{number}].end", came, "expected ground that hangs together with the start")
        starts = [pieces[start] for start, _ in self.places if start is not None]
        reached = np.isin(pieces, starts)
        left_out = 1.0 - reached.sum() / max(free.sum(), 1)
        if starts and left_out > SMALL_PART:
            self.notes += (f"{left_out:.1%} of the free ground cannot be reached from the start, and is left out",)
        return reached

    def problem(self, sight: Sight) -> SearchProblem:
        """The search as planners are asked it.

        Raises
        ------
        DataFormatError        where there is not enough time, or too little ground around the start
        """
        assert self.free is not None
        assert self.sweeps is not None
        assert self.layers.cell_m is not None
        seconds = self.settings.budget.seconds or 0.0
        grid = Grid(self.free.shape, "square8", self.layers.cell_m, None if self.free.all() else ~self.free)
        starts, ends = zip(*self.places, strict=True)
        try:
            regions = self._regions(grid, sight, self.sweeps)
            posed = region_problem(grid, regions, self.sweeps, sight.rows, starts, seconds, ends, sight.objective)
        except InfeasibleProblemError as error:
            self.faults.add("budget.seconds", re.sub(r"^searcher \d+: ", "", str(error)), "expected more time")
        except InvalidProblemError as error:
            self.faults.add("searcher", str(error), "expected a search that can be posed")
        self.faults.refuse()
        self._check_time(posed)
        return posed

    def _regions(self, grid: Grid, sight: Sight, sweeps: list[Sweep]) -> Regions:
        """The ground, cut as the file says."""
        cutting, radius_m = self.settings.regions or Cutting(), sweeps[0].radius_m
        plain = boustrophedon(grid, **self._thresholds(grid, radius_m))
        self._check_sizes(grid, plain)
        if cutting.cut == "plain":
            return plain
        chunk_m = CHUNK * radius_m if cutting.chunk_m is None else cutting.chunk_m
        shortest_m2 = float(self._swept_m2(sweeps[0].spacing_m, [sweep.dynamics for sweep in sweeps]).min())
        least_m2 = MIN_CHUNK * radius_m**2
        return regions_for(
            grid, sight.first_look, plain, chunk_m, min_m2=least_m2, swept_m2=shortest_m2, smooth_m=radius_m
        )

    def _thresholds(self, grid: Grid, radius_m: float) -> dict[str, float]:
        """Least sizes of regions in cells, whatever the size of the map."""
        cutting, cell_m = self.settings.regions or Cutting(), grid.cell_m
        area_m2 = MIN_AREA * radius_m**2 if cutting.min_area_m2 is None else cutting.min_area_m2
        width_m = MIN_WIDTH * radius_m if cutting.min_width_m is None else cutting.min_width_m
        return {
            "overlap": cutting.overlap,
            "min_cells": area_m2 / cell_m**2,
            "min_columns": width_m / cell_m,
            "min_obstacle": cutting.min_obstacle_m2 / cell_m**2,
            "at_width": grid.shape[1],
        }

    def _check_sizes(self, grid: Grid, plain: Regions) -> None:
        """Some region is as large as the file asks: the largest stays, whatever its size, for what nobody has said."""
        cutting, cell_m = self.settings.regions or Cutting(), grid.cell_m
        if plain.n_regions > 1:
            return  # others than the largest stay only where they are large enough
        area_m2 = float(plain.sizes[0]) * cell_m**2
        width_m = float((plain.labels == 0).any(axis=0).sum()) * cell_m
        for key, said, there, unit in (
            ("min_area_m2", cutting.min_area_m2, area_m2, "m2"),
            ("min_width_m", cutting.min_width_m, width_m, "m"),
        ):
            if said is not None and said > there:
                came = f"{said:g} {unit} came, which leaves no region: the largest has {there:g} {unit}"
                self.faults.add(f"regions.{key}", came, "expected a number that leaves at least one")
        self.faults.refuse()

    def _check_time(self, problem: SearchProblem) -> None:
        """At least one region can be searched in time, by every searcher, and a flight is not endless."""
        for number, searcher in enumerate(problem.searchers):
            moves = searcher.moves
            assert isinstance(moves, RegionMoves)
            actions = slice(moves.graph.n_regions + moves.graph.n_edges)
            most_s = MAX_ACTIONS * float(moves.graph.seconds[actions].min())
            if searcher.budget > most_s:
                came = f"{searcher.budget:g} s came, time for more than {MAX_ACTIONS:,} actions of searcher[{number}]"
                self.faults.add("budget.seconds", came, f"expected at most {int(most_s)} s")
            searches = moves.graph.seconds[: moves.graph.n_regions]
            least = float((moves.from_first + searches + moves.to_last).min()) + moves.leg_s
            if least > searcher.budget + ROUNDING_S:
                came = f"{searcher.budget:g} s came, too short for searcher[{number}] to search any region"
                expected = f"expected at least {least:.0f} s: the quickest search, with the ways to and from it"
                self.faults.add("budget.seconds", came, expected)
        self.faults.refuse()


def dynamics_of(settings: Settings, number: int) -> Dynamics:
    """How a drone flies that a file without faults describes: no faster than its sensors let it."""
    said = settings.searcher[number]
    reach = _Reach.of(Faults(Path()), settings).ahead(settings.sensor.range_m, said.accel_mps2)
    found = reach.dynamics(said)
    assert found is not None
    return found


@dataclass(frozen=True)
class _Reach:
    """How far looks reach, and how fast the sensors let anything fly.

    Parameters
    ----------
    radius_m : float or None
    speed_mps : float           inf where no sensor caps it
    why : str                   what caps it
    """

    radius_m: float | None
    speed_mps: float = inf
    why: str = ""

    def dynamics(self, said: Searching) -> Dynamics | None:
        """How a drone flies whose sensors let it; None where the file does not say."""
        speed = min(said.speed_mps or inf, self.speed_mps)
        return Dynamics(speed, said.accel_mps2) if 0 < speed < inf and said.accel_mps2 is not None else None

    def ahead(self, range_m: float | None, accel: float | None) -> _Reach:
        """The same for a drone that must stop within what it sees of obstacles."""
        if range_m is None or accel is None:
            return self
        caps = [(self.speed_mps, self.why), (float(speed_to_stop(range_m, accel)), "sensor.range_m")]
        return _Reach(self.radius_m, *min(caps))

    @classmethod
    def of(cls, faults: Faults, settings: Settings) -> _Reach:
        """From the radius or the camera."""
        sensor = settings.sensor
        if sensor.camera is not None and sensor.radius_m is not None:
            faults.add("sensor", "radius_m and camera came", "expected one of them")
        elif sensor.camera is not None:
            radius_m, sharp = camera_sight(faults, sensor.camera)
            if radius_m is not None and radius_m > FARTHEST_M:
                came = f"a camera came that sees {radius_m:.3g} m to each side"
                faults.add("sensor.camera", came, f"expected at most {FARTHEST_M:g} m: a narrower view")
            return cls(radius_m, sharp, "[sensor.camera]")
        elif sensor.radius_m is None and not faults.among("sensor.radius_m") and not faults.among("sensor.camera"):
            expected = "expected metres, or a camera: over regions cells so near to the path are looked at"
            faults.add("sensor.radius_m", "nothing came", expected)
        return cls(sensor.radius_m)


def camera_sight(faults: Faults, said: CameraSettings) -> tuple[float | None, float]:
    """Radius of the ground in view, and the speed up to which pictures are sharp."""
    for key in type(said).model_fields:
        if getattr(said, key) is None:
            faults.add(f"sensor.camera.{key}", "nothing came", f"expected {', '.join(type(said).model_fields)}")
    if said.fov_deg is None or said.altitude_m is None or said.pixels is None or said.exposure_s is None:
        return None, inf
    camera = Camera(radians(said.fov_deg), said.pixels, said.exposure_s)
    sharp = float(camera.largest_speed(said.altitude_m))
    if sharp <= 0:
        came = f"exposure_s = {said.exposure_s:g} came, with which turns of the drone alone blur the picture"
        faults.add("sensor.camera", came, "expected a shorter exposure, fewer pixels or a wider view")
    return float(camera.footprint_radius(said.altitude_m)), sharp
