"""A mission file, read and checked: every fault it has is reported at once."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from sooner.belief import Belief
from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.grid import Grid
from sooner.io import Raster, read_raster
from sooner.io.rasters import opened
from sooner.missions.settings import MAX_STEPS, Searching, Settings, not_yet
from sooner.problem import CellMoves, Objective, Searcher, SearchProblem, detection_gains
from sooner.sensors import glimpse_from_difficulty

__all__ = ["Mission", "read_mission"]

MAX_BYTES = 10_000_000


@dataclass(frozen=True, eq=False)
class Mission:
    """A search as its file describes it.

    Parameters
    ----------
    path : Path                 the mission file
    settings : Settings         what it says
    problem : SearchProblem     what planners are asked
    belief : Belief             where the person may be
    glimpse : (H, W) float      P(detect in one look | there)
    cell_m : float or None      metres between cell centres; None where nobody says
    step_s : float or None      seconds that one step takes; None where the file says nothing about speed
    notes : tuple of str        what the user should know about how the file was understood
    """

    path: Path
    settings: Settings
    problem: SearchProblem
    belief: Belief
    glimpse: NDArray[np.float64]
    cell_m: float | None
    step_s: float | None
    notes: tuple[str, ...]

    @property
    def name(self) -> str:
        """What the file calls the mission, or else the file's own name."""
        return self.settings.name or self.path.stem


def read_mission(path: Path) -> Mission:
    """Read a mission file and the rasters it names.

    Raises
    ------
    DataFormatError        with every fault of the file and of its rasters
    """
    reading = _Reading(path)
    settings = reading.settings(_toml(path))
    reading.faults += not_yet(settings, str(path))
    layers = reading.layers(settings)
    grid = reading.grid(settings, layers)
    step_s = reading.step_s(settings, layers)
    belief = reading.belief(settings, layers)
    glimpse = reading.glimpse(settings, layers)
    searchers = reading.searchers(settings, grid, step_s)
    reading.target(settings)
    if reading.faults or grid is None or belief is None or glimpse is None:
        raise DataFormatError(*reading.faults)
    gains = detection_gains(belief, glimpse, settings.sensor.correlation)
    objective = Objective("detection", settings.objective.detection_target)
    problem = reading.problem(grid, gains, searchers, objective)
    return Mission(
        path,
        settings,
        problem,
        belief,
        glimpse,
        cell_m=reading.cell_m(settings, layers),
        step_s=step_s[0] if step_s else None,
        notes=_notes(settings, belief, grid),
    )


def _toml(path: Path) -> dict[str, Any]:
    expected = "expected a mission file in TOML"
    with opened(path) as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise DataFormatError(Fault(str(path), "", "a file of more than 10 MB came", expected))
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise DataFormatError(Fault(str(path), "", "something that is not text came", expected)) from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise DataFormatError(Fault(str(path), "", f"it is not TOML ({error})", expected)) from None


@dataclass(frozen=True)
class _Layers:
    """The rasters that could be read."""

    poc: Raster | None
    difficulty: Raster | None
    glimpse: Raster | None
    obstacles: Raster | None


class _Reading:
    """One reading of a mission file: its parts, and the faults found so far."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.faults: list[Fault] = []
        self.wrong: set[str] = set()  # keys already reported

    def fault(self, key: str, came: str, expected: str) -> None:
        if key not in self.wrong:
            self.faults.append(Fault(str(self.path), key, came, expected))

    # ------------------------------------------------------------ the file itself

    def settings(self, raw: dict[str, Any]) -> Settings:
        """What the file says, without the keys that are wrong; those are reported and left out."""
        for _ in range(10):  # taking out a key can bring another fault of the same table to light
            try:
                settings = Settings.model_validate(raw)
                break
            except ValidationError as error:
                found = error.errors(include_url=False)
            for key, fault in _schema_faults(str(self.path), raw, found):
                if key not in self.wrong:
                    self.wrong.add(key)
                    self.faults.append(fault)
            for detail in found:
                _take_out(raw, detail["loc"])
        else:
            raise DataFormatError(*self.faults)
        self._required(settings)
        return settings

    def _required(self, settings: Settings) -> None:
        if settings.area.poc is None and settings.area.evidence is None and "area" not in self.wrong:
            self.fault("area.poc", "nothing came", "expected the name of a raster of weights (.csv, .npy or GeoTIFF)")
        sensor = settings.sensor
        if sensor.difficulty is not None and sensor.glimpse is not None:
            self.fault("sensor", "difficulty and glimpse came", "expected one of them")
        if not settings.searcher and not any(key.startswith("searcher") for key in self.wrong):
            self.fault("searcher", "no searcher came", "expected at least one [[searcher]] table")
        budget = settings.budget
        if not any(key.startswith("budget") for key in self.wrong):
            if budget.steps is None and budget.seconds is None:
                self.fault(
                    "budget", "nothing came", "expected steps, or seconds with area.cell_m and searcher.speed_mps"
                )
            elif budget.steps is not None and budget.seconds is not None:
                self.fault("budget", "steps and seconds came", "expected one of them")

    # ------------------------------------------------------------ rasters

    def layers(self, settings: Settings) -> _Layers:
        glimpse = settings.sensor.glimpse
        poc = self._raster("area.poc", settings.area.poc)
        like = None if poc is None else (settings.area.poc, poc)
        return _Layers(
            poc,
            self._raster("sensor.difficulty", settings.sensor.difficulty, like),
            self._raster("sensor.glimpse", glimpse if isinstance(glimpse, str) else None, like),
            self._raster("area.obstacles", settings.area.obstacles, like),
        )

    def _raster(self, key: str, name: str | None, like: tuple[Any, Raster] | None = None) -> Raster | None:
        if name is None:
            return None
        try:
            raster = read_raster(self.path.parent / name)
        except DataFormatError as error:
            for fault in error.faults:
                where = f", {fault.key}" if fault.key else ""
                self.fault(key, f"{fault.file}{where}: {fault.came}", fault.expected)
            return None
        if like is not None:
            self._same_place(key, name, raster, *like)
        return raster

    def _same_place(self, key: str, name: str, raster: Raster, first_name: str, first: Raster) -> None:
        if raster.values.shape != first.values.shape:
            came = "{} x {} cells came in {}".format(*raster.values.shape, name)
            self.fault(key, came, "expected {} x {} as in {}".format(*first.values.shape, first_name))
            self.wrong.add(key)
        elif raster.corner is not None and first.corner is not None and not _matches(raster, first):
            came = f"{name} lies at {raster.corner} in {raster.crs} with cells of {raster.cell_m} m"
            expected = f"expected {first.corner} in {first.crs} with cells of {first.cell_m} m, as {first_name}"
            self.fault(key, came, expected)

    def _numbers(
        self, key: str, raster: Raster | None, low: float, high: float, missing: float | None
    ) -> NDArray[np.float64] | None:
        """Values within [low, high]; "no data" counts as `missing`."""
        if raster is None:
            return None
        values = raster.values
        if raster.missing is not None and missing is not None:
            values = np.where(raster.missing, missing, values)
        elif raster.missing is not None:
            self.fault(key, f'{int(raster.missing.sum())} cells of "no data" came', "expected a number in every cell")
            return None
        least = f"at least {low:g}" if high == np.inf else f"in [{low:g}, {high:g}]"
        broken = ~np.isfinite(values)
        beyond = ~broken & ((values < low) | (values > high))
        came = [
            _first(values, bad, what) for bad, what in ((broken, "not finite"), (beyond, "out of range")) if bad.any()
        ]
        if came:
            self.fault(key, "; ".join(came), f"expected finite numbers {least}")
            return None
        return values

    def belief(self, settings: Settings, layers: _Layers) -> Belief | None:
        weights = self._numbers("area.poc", layers.poc, 0.0, np.inf, missing=0.0)
        if weights is None:
            return None
        if not weights.any():
            self.fault("area.poc", "every weight is zero", "expected some cell where the person may be")
            return None
        return Belief.from_weights(weights, settings.area.outside)

    def glimpse(self, settings: Settings, layers: _Layers) -> NDArray[np.float64] | None:
        if layers.poc is None:
            self._numbers("sensor.glimpse", layers.glimpse, 0.0, 1.0, missing=None)
            self._numbers("sensor.difficulty", layers.difficulty, 0.0, np.inf, missing=None)
            return None
        said = settings.sensor.glimpse
        if isinstance(said, float):
            if not 0.0 <= said <= 1.0:
                self.fault(
                    "sensor.glimpse", f"{said} came", "expected a probability in [0, 1], or the name of a raster"
                )
                return None
            return np.full(layers.poc.values.shape, said)
        if isinstance(said, str):
            return self._numbers("sensor.glimpse", layers.glimpse, 0.0, 1.0, missing=None)
        if settings.sensor.difficulty is None:
            return np.ones(layers.poc.values.shape)
        levels = self._numbers("sensor.difficulty", layers.difficulty, 0.0, np.inf, missing=None)
        return None if levels is None else glimpse_from_difficulty(levels)

    def grid(self, settings: Settings, layers: _Layers) -> Grid | None:
        obstacles = None
        if layers.obstacles is not None:
            stones = self._numbers("area.obstacles", layers.obstacles, -np.inf, np.inf, missing=0.0)
            if stones is not None and "area.obstacles" not in self.wrong:
                obstacles = stones != 0
        if layers.poc is None:
            return None
        height, width = layers.poc.values.shape
        if obstacles is not None and obstacles.shape != (height, width):
            obstacles = None
        cell_m = self.cell_m(settings, layers)
        return Grid((height, width), settings.area.grid, 1.0 if cell_m is None else cell_m, obstacles)

    def cell_m(self, settings: Settings, layers: _Layers) -> float | None:
        said = settings.area.cell_m
        found = None if layers.poc is None else layers.poc.cell_m
        if said is not None and found is not None and abs(said - found) > 0.01 * found:
            self.fault("area.cell_m", f"{said:g} m came", f"expected {found:g} m, as the raster's georeference says")
        return said if found is None else found

    # ------------------------------------------------------------ searchers

    def step_s(self, settings: Settings, layers: _Layers) -> list[float] | None:
        """Seconds that a step of each searcher takes; None where the file does not say how fast they are."""
        cell_m = self.cell_m(settings, layers)
        speeds = [searcher.speed_mps for searcher in settings.searcher]
        if settings.budget.seconds is not None:
            if cell_m is None and layers.poc is not None:
                self.fault(
                    "area.cell_m", "nothing came", "expected metres: a budget in seconds needs the size of a cell"
                )
            for number, speed in enumerate(speeds):
                key = f"searcher[{number}].speed_mps"
                if speed is None:
                    self.fault(key, "nothing came", "expected metres a second: a budget in seconds needs the speed")
        if cell_m is None or not speeds or any(speed is None for speed in speeds):
            return None
        # the longest step of the grid, so that no flight takes longer than it says
        longest = cell_m * (2.0**0.5 if settings.area.grid == "square8" else 1.0)
        return [longest / speed for speed in speeds if speed is not None]

    def target(self, settings: Settings) -> None:
        """A CDP that no search of this map can have."""
        target, on_map = settings.objective.detection_target, 1.0 - settings.area.outside
        if target is not None and target > on_map:
            came = f"{target} came, but the person is on this map with probability {on_map:.4g}"
            self.fault("objective.detection_target", came, f"expected at most {on_map:.4g}")

    def searchers(self, settings: Settings, grid: Grid | None, step_s: list[float] | None) -> list[Searcher | None]:
        return [
            self._searcher(settings, grid, number, said, step_s[number] if step_s else None)
            for number, said in enumerate(settings.searcher)
        ]

    def _searcher(
        self, settings: Settings, grid: Grid | None, number: int, said: Searching, step_s: float | None
    ) -> Searcher | None:
        key = f"searcher[{number}]"
        if said.start is None:
            self.fault(f"{key}.start", "nothing came", "expected [row, col]")
        start = self._cell(f"{key}.start", said.start, grid)
        end = self._cell(f"{key}.end", said.end, grid)
        steps = settings.budget.steps
        if settings.budget.seconds is not None and step_s is not None:
            steps = int(settings.budget.seconds / step_s + 1e-9)
            if steps < 1:
                came = f"{settings.budget.seconds:g} s came, and one step takes {step_s:g} s"
                self.fault("budget.seconds", came, "expected time for at least one step")
                return None
            if steps > MAX_STEPS:
                came = f"{settings.budget.seconds:g} s came, and one step takes {step_s:g} s"
                self.fault("budget.seconds", came, f"expected time for at most {MAX_STEPS:,} steps")
                return None
        ends_wrong = said.end is not None and end is None
        if grid is None or start is None or steps is None or ends_wrong:
            return None
        return self._fitting(key, grid, Searcher(start, steps, end, CellMoves(said.kind, step_s or 1.0)))

    def _fitting(self, key: str, grid: Grid, searcher: Searcher) -> Searcher | None:
        """The searcher, if its end can be reached in its budget."""
        try:
            nothing = detection_gains(Belief.from_weights(np.ones(grid.shape)), 1.0)
            SearchProblem(grid, nothing, (searcher,))
        except InvalidProblemError as error:
            came = str(error).removeprefix("searcher 0: ")
            self.fault(f"{key}.end", came, "expected an end that can be reached in the budget")
            return None
        return searcher

    def _cell(self, key: str, said: Any, grid: Grid | None) -> tuple[int, int] | None:
        if not isinstance(said, list) or grid is None:
            return None
        row, col = said
        height, width = grid.shape
        if not (0 <= row < height and 0 <= col < width):
            map_is = f"rows 0 to {height - 1} and columns 0 to {width - 1}"
            self.fault(key, f"[{row}, {col}] came", f"expected a cell of the map, which has {map_is}")
            return None
        if not grid.passable[grid.index((row, col))]:
            self.fault(key, f"[{row}, {col}] came, and an obstacle stands there", "expected a cell that can be entered")
            return None
        return row, col

    def problem(self, grid: Grid, gains: Any, searchers: list[Searcher | None], objective: Objective) -> SearchProblem:
        try:
            return SearchProblem(grid, gains, tuple(s for s in searchers if s is not None), objective)
        except InvalidProblemError as error:  # all that can be foreseen has been reported by key
            self.fault("", str(error), "expected a search that can be posed")
            raise DataFormatError(*self.faults) from None


def _first(values: NDArray[np.float64], bad: NDArray[np.bool_], what: str) -> str:
    row, col = np.unravel_index(int(np.argmax(bad)), bad.shape)
    count = int(bad.sum())
    return f"{count} value{'s are' if count > 1 else ' is'} {what}, the first {values[row, col]:g} at [{row}, {col}]"


def _matches(one: Raster, other: Raster) -> bool:
    if one.crs != other.crs or one.corner is None or other.corner is None or not one.cell_m or not other.cell_m:
        return False
    near = 0.01 * other.cell_m
    apart = max(abs(a - b) for a, b in zip(one.corner, other.corner, strict=True))
    return apart <= near and abs(one.cell_m - other.cell_m) * max(one.values.shape) <= 10 * near


def _schema_faults(file: str, raw: dict[str, Any], found: Iterable[ErrorDetails]) -> list[tuple[str, Fault]]:
    """pydantic's findings in our words, one per key."""
    by_key: dict[str, list[ErrorDetails]] = {}
    for detail in found:
        by_key.setdefault(_key(detail["loc"]), []).append(detail)
    faults = []
    for key, details in by_key.items():
        if details[0]["type"] == "extra_forbidden":
            came, expected = "this key is not known", _known(details[0]["loc"])
        else:
            came = f"{_told(_at(raw, details[0]['loc']))} came"
            expected = "expected " + " or ".join(dict.fromkeys(_wanted(detail) for detail in details))
        faults.append((key, Fault(file, key, came, expected)))
    return faults


_BRANCHES = {"str", "float", "list[int]", "Place", "constrained-list", "list[constrained-int]"}


def _place(loc: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """Where in the file: without the branches of a union that pydantic names, and whole cells rather than a number."""
    place = []
    for part in loc:
        if isinstance(part, str) and (part in _BRANCHES or "[" in part or "(" in part):
            break
        place.append(part)
    return tuple(place)


def _key(loc: tuple[int | str, ...]) -> str:
    """Dotted, as `searcher[0].start`."""
    key = ""
    for part in _place(loc):
        key += f"[{part}]" if isinstance(part, int) else f".{part}" if key else part
    return key


def _at(raw: Any, loc: tuple[int | str, ...]) -> Any:
    for part in _place(loc):
        raw = raw[part]
    return raw


def _take_out(raw: Any, loc: tuple[int | str, ...]) -> None:
    place = _place(loc)
    for part in place[:-1]:
        if isinstance(raw, dict) and part not in raw:
            return
        raw = raw[part]
    if isinstance(raw, dict):
        raw.pop(place[-1], None)
    elif isinstance(raw, list) and isinstance(place[-1], int):
        raw[place[-1]] = {}


def _known(loc: tuple[int | str, ...]) -> str:
    """The keys of the table that a key was not known in."""
    from pydantic import BaseModel

    model: type[BaseModel] = Settings
    for part in loc[:-1]:
        if isinstance(part, int):
            continue
        if part == "Place":
            return "expected lat, lon"
        annotation = model.model_fields[part].annotation
        model = Searching if part == "searcher" else annotation  # type: ignore[assignment]
    return f"expected one of {', '.join(model.model_fields)}"


def _told(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:60] + "..."


_WANTED = {
    "model_type": "a table",
    "dict_type": "a table",
    "list_type": "a list",
    "too_short": "[row, col]",
    "too_long": "[row, col]",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "finite_number": "a finite number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
}


def _wanted(detail: ErrorDetails) -> str:
    kind, limits = detail["type"], detail.get("ctx", {})
    branch = str(detail["loc"][-1]) if detail["loc"] else ""
    if "start" in detail["loc"] or "end" in detail["loc"]:
        return "[row, col] in whole numbers"
    if branch == "searcher":
        return "[[searcher]] tables"
    if kind in _WANTED:
        return _WANTED[kind]
    if kind == "literal_error":
        return str(limits.get("expected"))
    for name, words in (("ge", "of at least"), ("gt", "above"), ("le", "of at most"), ("lt", "below")):
        if name in limits:
            return f"a number {words} {limits[name]}"
    return detail["msg"]


def _notes(settings: Settings, belief: Belief, grid: Grid) -> tuple[str, ...]:
    notes = []
    if settings.sensor.difficulty is None and settings.sensor.glimpse is None:
        notes.append("[sensor] says nothing, so every look at a cell detects who is there (glimpse 1)")
    blocked = float(belief.poc.ravel()[~grid.passable].sum())
    if blocked > 0.005:
        notes.append(f"{blocked:.1%} of the probability lies on obstacles, where no drone can look")
    if settings.budget.seconds is not None:
        notes.append("seconds count level flight at constant speed; turns cost no time in this version")
    return tuple(notes)
