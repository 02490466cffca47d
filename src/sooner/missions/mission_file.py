"""A mission file, read and checked: every fault it has is reported at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.belief import Belief
from sooner.errors import DataFormatError, Fault, InvalidProblemError, printable
from sooner.io.georeference import Georeference
from sooner.io.reading import read_toml
from sooner.missions.faults import Faults
from sooner.missions.fleet import Sortie
from sooner.missions.layers import Layers
from sooner.missions.over_cells import OverCells
from sooner.missions.over_legs import OverLegs
from sooner.missions.over_regions import OverRegions
from sooner.missions.places import places
from sooner.missions.real_area import RealArea
from sooner.missions.settings import Settings, misplaced, not_yet
from sooner.missions.sight import Sight
from sooner.problem import SearchProblem

__all__ = ["Mission", "read_mission"]


@dataclass(frozen=True, eq=False)
class Mission:
    """A search as its file describes it.

    Parameters
    ----------
    path : Path                 the mission file
    settings : Settings         what it says
    problem : SearchProblem     what planners are asked
    sight : Sight               where targets may be, and what a look pays
    cell_m : float or None      metres between cell centres; None where nobody says
    step_s : float or None      seconds that one step takes; None over regions, and where the file says no speed
    notes : tuple of str        what the user should know about how the file was understood
    ground : Georeference or None  where its cells lie on the globe; None where the rasters do not say
    sorties : of Sortie         along legs: what each searcher of the problem is, drone and battery
    area : RealArea or None     its polygons and heights, where it is drawn
    obstacles : (H, W) bool or None  cells that cannot be entered
    """

    path: Path
    settings: Settings
    problem: SearchProblem
    sight: Sight
    cell_m: float | None
    step_s: float | None
    notes: tuple[str, ...]
    ground: Georeference | None = None
    sorties: tuple[Sortie, ...] = ()
    area: RealArea | None = None
    obstacles: NDArray[np.bool_] | None = None

    @property
    def name(self) -> str:
        """What the file calls the mission, or else the file's own name."""
        return self.settings.name or printable(self.path.stem)

    @property
    def over_regions(self) -> bool:
        """Whether drones move over regions."""
        return self.settings.over_regions

    @property
    def over_legs(self) -> bool:
        """Whether drones fly straight legs between any places."""
        return self.settings.over_legs

    @property
    def timed(self) -> bool:
        """Whether time is told in seconds, not in steps."""
        return self.over_regions or self.over_legs

    @property
    def moves(self) -> str:
        """How drones move: "cells", "regions" or "legs"."""
        return "regions" if self.over_regions else "legs" if self.over_legs else "cells"

    @property
    def belief(self) -> Belief | None:
        """Where the one person may be; None where evidence is of each cell by itself."""
        return self.sight.known if isinstance(self.sight.known, Belief) else None

    @property
    def glimpse(self) -> NDArray[np.float64]:
        """(H, W) float: P(detect in one look | there)."""
        return self.sight.glimpse

    @property
    def unit_s(self) -> float | None:
        """Seconds of the problem's unit of time: of a step, or one over regions; None where nobody knows."""
        return 1.0 if self.timed else self.step_s


def read_mission(path: Path | str) -> Mission:
    """Read a mission file and the rasters it names.

    Raises
    ------
    DataFormatError        with every fault of the file and of its rasters
    """
    path = Path(path)
    faults = Faults(path)
    settings = faults.settings(read_toml(path, "expected a mission file in TOML"))
    if settings.over_waypoints:
        if settings.area.streets is not None:
            expected = "expected area.poc or area.evidence; `sooner simulate` flies over unknown streets"
            faults.add("area.streets", "streets came, over which nobody plans ahead", expected)
        else:
            number = [searcher.moves for searcher in settings.searcher].index("waypoints")
            expected = "expected 'cells' or 'regions'; `sooner simulate` flies to waypoints"
            faults.add(f"searcher[{number}].moves", "'waypoints' came, which nobody plans ahead", expected)
        faults.refuse()
    _check_required(faults, settings)
    for fault in misplaced(settings, str(path)):
        faults.add(fault.key, fault.came, fault.expected)
    for fault in not_yet(settings, str(path)):
        faults.add(fault.key, fault.came, fault.expected)
    layers = Layers.read(faults, settings)
    search: OverCells | OverRegions | OverLegs
    if settings.over_legs:
        search = OverLegs(faults, settings, layers, places(faults, settings, layers))
        layers = search.layers
        sight = Sight.read(faults, settings, layers)
    else:
        sight = Sight.read(faults, settings, layers)
        over = OverRegions if settings.over_regions else OverCells
        search = over(faults, settings, layers, places(faults, settings, layers))
    _check_target(faults, settings, layers)
    _check_links(faults, settings, layers)
    faults.refuse()
    assert sight is not None
    try:
        problem = search.problem(sight)
    except InvalidProblemError as error:  # all that can be foreseen has been reported by key
        raise DataFormatError(Fault(str(path), "", str(error), "expected a search that can be posed")) from None
    notes = (*layers.notes, *_notes(settings, sight, problem), *search.notes)
    located = layers.first is not None and layers.first.corner is not None
    ground = Georeference.of(layers.first) if located and layers.first is not None else None
    sorties = search.sorties if isinstance(search, OverLegs) else ()
    beneath = ground, sorties, layers.area, layers.obstacles
    return Mission(path, settings, problem, sight, layers.cell_m, search.step_s, notes, *beneath)


def _check_required(faults: Faults, settings: Settings) -> None:
    area, budget = settings.area, settings.budget
    priors = (area.poc, area.evidence, area.polygon, area.flight_area, area.segments, area.last_known, area.frame)
    if all(each is None for each in priors) and "area" not in faults.wrong and not faults.among("area."):
        expected = "expected a raster of weights (.csv, .npy or GeoTIFF), area.polygon, or area.evidence"
        faults.add("area.poc", "nothing came", expected)
    elif area.poc is not None and area.evidence is not None:
        faults.add("area", "poc and evidence came", "expected one of them")
    if not settings.searcher and not faults.among("searcher"):
        faults.add("searcher", "no searcher came", "expected at least one [[searcher]] table")
    if faults.among("budget"):
        return
    flown_out = any(searcher.vehicle is not None for searcher in settings.searcher)  # as long as its batteries last
    if budget.steps is None and budget.seconds is None and not flown_out:
        faults.add("budget", "nothing came", "expected steps, or seconds with area.cell_m and searcher.speed_mps")
    elif budget.steps is not None and budget.seconds is not None:
        faults.add("budget", "steps and seconds came", "expected one of them")


def _check_target(faults: Faults, settings: Settings, layers: Layers) -> None:
    """A CDP that no search of this map can have."""
    target, on_map = settings.objective.detection_target, 1.0 - max(settings.area.outside, layers.outside)
    if target is not None and target > on_map:
        came = f"{target} came, but the person is on this map with probability {on_map:.4g}"
        faults.add("objective.detection_target", came, f"expected at most {on_map:.4g}")
    if target is not None and settings.objective.early:
        expected = "expected one of them: a target is reached soonest as it is"
        faults.add("objective", "detection_target and early came", expected)


def _check_links(faults: Faults, settings: Settings, layers: Layers) -> None:
    """Links are between several drones, and their range is in metres."""
    if settings.links is None:
        return
    if len(settings.searcher) == 1:
        faults.add("links", "it came, and one [[searcher]]", "expected several, or no links")
    if settings.objective.detection_target is not None:
        expected = "expected one of them: nobody on board knows when all together reach a target"
        faults.add("links", "it came beside objective.detection_target", expected)
    if settings.links.range_m is not None and layers.cell_m is None and layers.shape is not None:
        faults.add("area.cell_m", "nothing came", "expected metres: links.range_m needs the size of a cell")


def _notes(settings: Settings, sight: Sight, problem: SearchProblem) -> list[str]:
    notes, sensor = [], settings.sensor
    given = (sensor.difficulty, sensor.glimpse, sensor.land_cover, sensor.sweep_width_m, sensor.detect)
    if all(each is None for each in given) and sensor.model == "binary":
        notes.append("[sensor] says nothing, so every look at a cell detects who is there (glimpse 1)")
    if isinstance(sight.known, Belief):
        blocked = float(sight.known.poc.ravel()[~problem.grid.passable].sum())
        if blocked > 0.005:
            where = "on obstacles or beyond reach" if settings.over_regions else "on obstacles"
            notes.append(f"{blocked:.1%} of the probability lies {where}, where no drone can look")
    return notes
