"""A mission whose drones fly to waypoints, to map streets that nobody knows and find who walks on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, InvalidProblemError, printable
from sooner.io import StreetMap, read_openstreetmap, read_street_map
from sooner.io.reading import read_toml
from sooner.missions.faults import Faults
from sooner.missions.layers import read_glimpse
from sooner.missions.settings import Hearing, Place, Searching, Settings, TargetSettings, misplaced
from sooner.sensors import GradedSensor
from sooner.simulation import Agent, Estimator, Links, Scene, World
from sooner.simulation.scene import MOST_SECONDS
from sooner.streets import Evasive, TargetWalk

__all__ = ["StreetMission", "is_over_waypoints", "read_street_mission"]

REPLAN_S = 5
CELL_M = 5.0  # of an extract, as in [Wolek2020]
EXTRACTS = (".osm", ".pbf", ".osm.gz", ".osm.bz2")


@dataclass(frozen=True, eq=False)
class StreetMission:
    """A search over unknown streets as its file describes it.

    Parameters
    ----------
    path : Path                 the mission file
    settings : Settings         what it says
    scene : Scene               what is simulated
    attribution : str           who must be named beside the map; "" for nobody
    """

    path: Path
    settings: Settings
    scene: Scene
    attribution: str = ""

    @property
    def name(self) -> str:
        """What the file calls the mission, or else the file's own name."""
        return self.settings.name or printable(self.path.stem)


def is_over_waypoints(path: Path) -> bool:
    """Whether a mission file has streets, or drones that fly to waypoints; nothing else is looked at.

    Raises
    ------
    DataFormatError        missing, or no TOML
    """
    said = read_toml(path, "expected a mission file in TOML")
    area, searchers = said.get("area"), said.get("searcher")
    if isinstance(area, dict) and "streets" in area:
        return True
    if not isinstance(searchers, list):
        return False
    return any(isinstance(each, dict) and each.get("moves") == "waypoints" for each in searchers)


def read_street_mission(path: Path) -> StreetMission:
    """Read a mission file over waypoints, and the streets it names.

    Raises
    ------
    DataFormatError        with every fault of the file; those of the streets by their own file
    """
    faults = Faults(path)
    settings = faults.settings(read_toml(path, "expected a mission file in TOML"))
    for fault in misplaced(settings, str(path)):
        faults.add(fault.key, fault.came, fault.expected)
    if not settings.searcher and not faults.among("searcher"):
        faults.add("searcher", "no searcher came", "expected at least one [[searcher]] table")
    streets = _streets(faults, settings)
    agents = [_agent(faults, settings, number, streets) for number in range(len(settings.searcher))]
    seconds, replan_s = _seconds(faults, settings)
    starts = _starts(faults, settings, streets)
    glimpse = _glimpse(faults, settings, streets)
    estimator, walk = _estimator(faults, settings), _walk(settings.target)
    world = None if streets is None else _world(faults, settings, streets, walk)
    faults.refuse()
    assert world is not None
    assert streets is not None
    assert estimator is not None
    team = tuple(agent for agent in agents if agent is not None)
    try:
        scene = Scene(
            world,
            team,
            estimator,
            seconds,
            replan_s,
            starts_m=starts,
            links=_links(settings.links),
            glimpse=glimpse,
        )
    except InvalidProblemError as error:  # all that can be foreseen has been reported by key
        faults.add("links" if settings.links is not None else "", *_parted(error))
        faults.refuse()
    return StreetMission(path, settings, scene, streets.attribution)


def _streets(faults: Faults, settings: Settings) -> StreetMap | None:
    area = settings.area
    if area.streets is None:
        if "area" not in faults.wrong and not faults.among("area.streets"):
            expected = "expected the name of an occupancy graph (.json) or of an OpenStreetMap extract (.osm, .pbf)"
            faults.add("area.streets", "nothing came", expected)
        return None
    file = faults.path.parent / area.streets
    extract = area.streets.lower().endswith(EXTRACTS)
    if area.window is not None and not extract:
        faults.add(
            "area.window", "it came, and no OpenStreetMap extract", "expected it left out: the graph has its own"
        )
    try:
        found = _extract(file, settings) if extract else read_street_map(file)
    except DataFormatError as error:
        for fault in error.faults:
            where = f", {fault.key}" if fault.key else ""
            faults.add("area.streets", f"{fault.file}{where}: {fault.came}", fault.expected)
        return None
    except InvalidProblemError as error:
        faults.add("area.window" if area.window is not None else "area.streets", *_parted(error))
        return None
    cell_m = found.graph.grid.cell_m
    if area.cell_m is not None and abs(area.cell_m - cell_m) > 1e-6 * cell_m:
        faults.add("area.cell_m", f"{area.cell_m:g} m came", f"expected {cell_m:g} m, as {area.streets} says")
    return found


def _extract(file: Path, settings: Settings) -> StreetMap:
    area, window = settings.area, settings.area.window
    cell_m = CELL_M if area.cell_m is None else area.cell_m
    if window is None:
        return read_openstreetmap(file, cell_m=cell_m)
    if (window.rows is None) != (window.cols is None):
        raise InvalidProblemError("one of rows and cols came; expected both or neither")
    shape = None if window.rows is None or window.cols is None else (window.rows, window.cols)
    corner = None
    if window.south_west is not None:
        if window.south_west.model_fields_set != {"lat", "lon"}:
            raise InvalidProblemError("half of south_west came; expected lat and lon")
        corner = window.south_west.lat, window.south_west.lon
    return read_openstreetmap(file, shape, cell_m, corner, window.scale, window.cut)


def _agent(faults: Faults, settings: Settings, number: int, streets: StreetMap | None) -> Agent | None:
    said, sensor, key = settings.searcher[number], settings.sensor, f"searcher[{number}]"
    _check_searcher(faults, key, said)
    radius_m = sensor.radius_m if said.radius_m is None else said.radius_m
    cell_m = None if streets is None else streets.graph.grid.cell_m
    if radius_m is not None and cell_m is not None and radius_m < cell_m / 2:
        where = "sensor.radius_m" if said.radius_m is None else f"{key}.radius_m"
        came = f"{radius_m:.3g} m came, and cells of {cell_m:g} m"
        faults.once(where, came, f"expected at least half a cell, {cell_m / 2:g} m: looks must cover the path")
    if radius_m is None and not faults.among("sensor.radius_m") and not faults.among(f"{key}.radius_m"):
        faults.add("sensor.radius_m", "nothing came", "expected metres: how far a drone sees")
    if radius_m is None or said.speed_mps is None or said.accel_mps2 is None:
        return None
    eyes = [
        GradedSensor(shared if own is None else own, sensor.levels)
        for own, shared in (
            (said.map_sensitivity, sensor.map_sensitivity),
            (said.target_sensitivity, sensor.target_sensitivity),
        )
    ]
    try:
        return Agent(said.speed_mps, said.accel_mps2, radius_m, *eyes)
    except InvalidProblemError as error:
        faults.add(f"{key}.accel_mps2", *_parted(error))
        return None


def _check_searcher(faults: Faults, key: str, said: Searching) -> None:
    if said.moves != "waypoints":
        expected = "expected 'waypoints' of all: drones over streets fly to waypoints"
        faults.add(f"{key}.moves", f"'{said.moves}' came", expected)
    if said.kind != "copter":
        faults.add(f"{key}.kind", f"'{said.kind}' came, and moves = \"waypoints\"", "expected 'copter': it may hover")
    for name, what in (("speed_mps", "metres a second"), ("accel_mps2", "metres a second squared")):
        if getattr(said, name) is None and not faults.among(f"{key}.{name}"):
            faults.add(f"{key}.{name}", "nothing came", f"expected {what}, the most")


def _glimpse(faults: Faults, settings: Settings, streets: StreetMap | None) -> NDArray[np.float64] | None:
    """(H, W) float; None where every look sees, or where it is wrong."""
    said = settings.sensor.glimpse
    if isinstance(said, float) and not 0.0 <= said <= 1.0:
        expected = "expected a probability in [0, 1], or the name of a raster"
        faults.add("sensor.glimpse", f"{said} came", expected)
        return None
    if said is None or streets is None:
        return None
    shape = streets.graph.grid.shape
    if isinstance(said, float):
        return np.full(shape, said)
    return read_glimpse(faults, said, shape, settings.area.streets or "")


def _starts(faults: Faults, settings: Settings, streets: StreetMap | None) -> NDArray[np.float64] | None:
    """(A, 2) float, metres; None where all leave it open."""
    given = [said.start for said in settings.searcher]
    if all(start is None for start in given):
        return None
    places = []
    for number, start in enumerate(given):
        key = f"searcher[{number}].start"
        if start is None:
            faults.add(key, "nothing came, and others start at places of their own", "expected [row, col], or of none")
        elif streets is not None and (cell := _start(faults, key, start, streets)) is not None:
            places.append(streets.graph.grid.centres_m[streets.graph.grid.index(cell)])
    return np.array(places, float) if len(places) == len(given) else None


def _start(faults: Faults, key: str, said: Sequence[int] | Place | str, streets: StreetMap) -> tuple[int, int] | None:
    """The cell of the map in which an agent starts."""
    if isinstance(said, str):
        faults.add(key, f"{said!r} came", "expected [row, col] in whole numbers, or lat and lon")
        return None
    if isinstance(said, Place):
        missing = [name for name in ("lat", "lon") if name not in said.model_fields_set]
        if missing:
            faults.add(f"{key}.{missing[0]}", "nothing came", "expected degrees: lat and lon make a place together")
            return None
        try:
            row, col = streets.cell_at(said.lat, said.lon)
        except InvalidProblemError as error:
            faults.add(key, str(error), "expected [row, col], or [lat, lon] of the streets' corner on the globe there")
            return None
        came = f"lat {said.lat:g}, lon {said.lon:g}, which is [{row}, {col}], came"
    else:
        row, col = said
        came = f"[{row}, {col}] came"
    rows, cols = streets.graph.grid.shape
    if not (0 <= row < rows and 0 <= col < cols):
        map_is = f"rows 0 to {rows - 1} and columns 0 to {cols - 1}"
        faults.add(key, came, f"expected a cell of the map, which has {map_is}")
        return None
    return row, col


def _seconds(faults: Faults, settings: Settings) -> tuple[int, int]:
    budget = settings.budget
    replan_s = REPLAN_S if budget.replan_s is None else budget.replan_s
    if budget.seconds is None:
        if not faults.among("budget"):
            faults.add("budget.seconds", "nothing came", "expected how long the search lasts, in whole seconds")
        return replan_s, replan_s
    if budget.seconds != int(budget.seconds) or budget.seconds > MOST_SECONDS:
        faults.add("budget.seconds", f"{budget.seconds:g} came", f"expected whole seconds, at most {MOST_SECONDS:,}")
    elif replan_s > budget.seconds:
        came = f"{replan_s} came, and the search lasts {budget.seconds:g} s"
        faults.add("budget.replan_s", came, "expected at most as many seconds")
    return int(budget.seconds), replan_s


def _estimator(faults: Faults, settings: Settings) -> Estimator | None:
    said = {} if settings.estimator is None else settings.estimator.model_dump()
    if said.get("tracks") is None:
        several = settings.target is not None and settings.target.count > 1
        said["tracks"] = "each" if several and said.get("detector") != "cbht" else "one"
    try:
        return Estimator(**said)
    except InvalidProblemError as error:
        faults.add("estimator", *_parted(error))
        return None


def _links(said: Hearing | None) -> Links | None:
    if said is None:
        return None
    return Links(inf if said.range_m is None else said.range_m, said.loss, said.delay_s, said.relays)


def _walk(said: TargetSettings | None) -> TargetWalk:
    return TargetWalk() if said is None else TargetWalk(said.rest, said.turn_scale, said.turn_shape)


def _world(faults: Faults, settings: Settings, streets: StreetMap, walk: TargetWalk) -> World | None:
    said, world = settings.target, World(streets.graph, walk, 0)
    if said is None:
        return world
    evasive = Evasive(np.empty((0, 2)), said.reach_m, said.boldness) if said.bias == "evasive" else None
    for key in ("reach_m", "boldness"):
        if evasive is None and key in said.model_fields_set:
            faults.add(f"target.{key}", "it came without bias", 'expected bias = "evasive" beside it')
    try:
        return replace(world, n_targets=said.count, evasive=evasive)
    except InvalidProblemError as error:
        faults.add("target.count", *_parted(error))
        return None


def _parted(error: InvalidProblemError) -> tuple[str, str]:
    """What came, and what was expected."""
    came, _, expected = str(error).partition("; ")
    return came, expected or "expected a search that can be posed"
