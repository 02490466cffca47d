"""A study: instances x planners x budgets x seeds, as a file says.

title = "Mine against the default"
trials = 20                                   # seeds 0, 1, ... of each case
budgets = [300, 600]

[instances]
hills = { scenario = "many-hills" }
valley = { mission = "valley/mission.toml" }

[planners]
anneal = { name = "anneal", ticks = 4 }
mine = { make = "my_planner:MyPlanner", width = 3 }
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from glob import escape
from importlib.util import find_spec
from math import isfinite
from pathlib import Path
from string import Formatter
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from sooner.campaigns.campaign import Asked
from sooner.campaigns.trial import Case, Limits
from sooner.errors import DataFormatError, Fault

__all__ = ["Cell", "OfCampaign", "OfTrial", "Rule", "Study", "StudyFile", "Table", "read_study"]

MAX_BYTES = 10_000_000
FLIGHT = "sooner.experiments.flight:fly"


def _number(came: Any) -> Any:
    """Finite, and whole where it is: 300 and 300.0 are one budget."""
    if isinstance(came, bool) or not isinstance(came, (int, float)) or not isfinite(came):
        raise PydanticCustomError("number", "a finite number")
    return int(came) if came == int(came) else came


def _pattern(came: Any) -> Any:
    if isinstance(came, str) and (not came or Path(came).is_absolute()):
        raise PydanticCustomError("pattern", "a name or pattern below the folder of the data")
    return came


Number = Annotated[int | float, BeforeValidator(_number)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
AtLeast0 = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1)]
Pattern = Annotated[str, BeforeValidator(_pattern)]


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class OfTrial(_Settings):
    """`[limits]`: what one trial may take; past it the trial is ended, flown once more, then set aside."""

    seconds: Positive = Field(default=3600.0, description="on the clock")
    memory_mb: Positive | None = Field(
        default=None, description="resident; left out: nine tenths of the machine's, shared by the workers"
    )


class OfCampaign(_Settings):
    """`[planners]`: name = { ... }; all but these keys is what the trial is told."""

    needs: Name | None = Field(
        default=None, description="a Python package; where it is missing this planner is left out"
    )
    seeds_factor: Annotated[int, Field(ge=1, le=1_000_000)] = Field(
        default=1, description="so many times as many seeds as the others"
    )
    most_trials: Annotated[int, Field(ge=1)] | None = Field(default=None, description="no more seeds than this")


class Table(_Settings):
    """`[[tables]]`: instances x planners x budgets, each a case; tables decide what is flown, left out: everything.

    `row` and `column` name the cells of the table; cells of one name are pooled.
    """

    name: Name = Field(description="of the table; what `sooner reproduce --only` asks for (required)")
    times: Name | None = Field(
        default=None, description="name of a second table, of seconds: `timed_trials` seeds are flown again, alone"
    )
    instances: list[str] = Field(default=["*"], description="names; `*` and `?` allowed")
    planners: list[str] = Field(default=["*"], description="names; `*` and `?` allowed")
    budgets: list[Number] | None = Field(default=None, description="left out: those of the study")
    row: str = Field(default="{planner}", description="made of `{instance}`, `{planner}`, `{budget}`, `{measure}`")
    column: str = Field(
        default="{instance} {budget}", description="made of `{instance}`, `{planner}`, `{budget}`, `{measure}`"
    )
    measure: Name | None = Field(default=None, description="which number of a trial; left out: that of the study")
    measures: dict[Name, Name] = Field(
        default={}, description="several of them: what `{measure}` calls each = which number of a trial"
    )
    statistic: Literal["mean", "median", "deviation", "rate"] = Field(
        default="mean", description="over the seeds; `rate` of a measure that is yes or no"
    )
    versus: Name | None = Field(
        default=None, description="a planner; the cells are then the others' differences from it, seed by seed"
    )


class Rule(_Settings):
    """`[[rules]]`: how numbers are judged against published ones; later rules overrule earlier ones, key by key."""

    table: str = Field(default="*", description="which tables; `*` and `?` allowed")
    row: str = Field(default="*", description="which rows")
    column: str = Field(default="*", description="which columns")
    exact: AtLeast0 = Field(default=0.02, description="the largest difference that is still the same")
    near: AtLeast0 = Field(default=2.5, description="the largest difference that is still near")
    sense: Literal["same", "limit", "time"] = Field(
        default="same", description="`same`: both ways count; `limit`: ours must not be more; `time`: less is faster"
    )
    reason: str = Field(default="", description="why ours differs, or cannot be measured")


class StudyFile(_Settings):
    """At the top: what is flown, how often, and what is told of it."""

    title: Name = Field(description="of the report; the ledger knows the study by it (required)")
    trials: int = Field(default=10, ge=1, le=100_000_000, description="seeds 0, 1, ... of each case")
    budgets: list[Number] = Field(default=[], description="of each instance; left out: its own")
    measure: Name = Field(default="value", description="the number of a trial that tables and the picture show")
    timed_trials: int = Field(default=3, ge=1, description="seeds that are flown again where a table has `times`")
    trial: Annotated[str, Field(pattern=r"^\w+(\.\w+)*:\w+$")] = Field(
        default=FLIGHT, description="`module:function` that flies one trial"
    )
    data: str = Field(default="", description="folder of maps below `--data` or `SOONER_DATA`")
    data_files: list[Pattern] = Field(
        default=[], description="patterns of files there; results on other files than these are not mixed"
    )
    limits: OfTrial = OfTrial()
    instances: dict[str, dict[str, Any]] = Field(min_length=1)
    planners: dict[str, dict[str, Any]] = Field(min_length=1)
    tables: list[Table] = []
    rules: list[Rule] = []
    paper: dict[str, Any] = {}


@dataclass(frozen=True)
class Cell:
    """One place of a table, and the case that fills it."""

    row: str
    column: str
    case: Case
    versus: Case | None = None


@dataclass(frozen=True)
class Study:
    """A study, checked.

    Parameters
    ----------
    folder : Path            where its file stands
    file : StudyFile         what the file says
    """

    folder: Path
    file: StudyFile

    @property
    def key(self) -> str:
        """What its ledger knows it by."""
        return self.file.title

    @property
    def limits(self) -> Limits:
        """Of one trial; memory is infinite where the file leaves it to the machine."""
        return Limits(self.file.limits.seconds, self.file.limits.memory_mb or float("inf"))

    @property
    def tables(self) -> tuple[Table, ...]:
        """Those of the file, or one of everything."""
        return tuple(self.file.tables) or (Table(name="All"),)

    @property
    def rules(self) -> tuple[Mapping[str, Any], ...]:
        """What the rules say; what they leave out is left out."""
        return tuple(rule.model_dump(exclude_unset=True) for rule in self.file.rules)

    @property
    def data_files(self) -> tuple[str, ...]:
        """Patterns of the files that decide what comes out: those the study names, missions and what they name."""
        missions = [self.folder / str(said["mission"]) for said in self.file.instances.values() if "mission" in said]
        named = [file for mission in missions for file in (mission, *_named_by(mission))]
        beside = [escape(Path(os.path.relpath(file, self.folder)).as_posix()) for file in named]
        return tuple(dict.fromkeys([*self.file.data_files, *beside]))

    def only(self, names: Sequence[str]) -> Study:
        """The same study with fewer tables, * and ? allowed.

        Raises
        ------
        DataFormatError      if none is left
        """
        chosen = [table for table in self.tables if any(fnmatchcase(table.name, name) for name in names)]
        if not chosen:
            known = ", ".join(repr(table.name) for table in self.tables)
            raise DataFormatError(Fault("tables", "", f"{', '.join(names)} came", f"expected some of {known}"))
        return replace(self, file=self.file.model_copy(update={"tables": chosen}))

    def asked(self, trials: int | None = None) -> Asked:
        """Every case of every table once, with its seeds; `trials` overrules the file's number.

        Raises
        ------
        DataFormatError      if there is no case, because packages are missing
        """
        count = self.file.trials if trials is None else trials
        seeds: dict[Case, range] = {}
        for table in self.tables:
            for cell in self.cells(table):
                if cell.versus is not None:  # it comes first, as what others are held against
                    seeds.setdefault(cell.versus, self._seeds(cell.versus, count))
                seeds.setdefault(cell.case, self._seeds(cell.case, count))
                if table.times:
                    timed = min(len(seeds[cell.case]), self.file.timed_trials)
                    seeds.setdefault(self.alone(cell).case, range(timed))
        if not seeds:
            came, needs = "nothing is left to fly", ", ".join(sorted(self._missing()))
            raise DataFormatError(Fault("planners", "", came, f"install {needs}" if needs else "expected some cases"))
        return Asked(tuple(seeds.items()))

    def cells(self, table: Table, measure: str = "") -> Iterator[Cell]:
        """Of one table and what it calls a measure; planners that need a package that is not there are left out."""
        budgets = dict.fromkeys(table.budgets or self.file.budgets) or [None]
        if table.versus and not self._usable(table.versus):
            return
        for instance in _chosen(table.instances, self.file.instances):
            for planner in _chosen(table.planners, self.file.planners):
                if planner == table.versus or not self._usable(planner):
                    continue
                for budget in budgets:
                    names = {"instance": instance, "planner": planner, "budget": "" if budget is None else budget}
                    names["measure"] = measure
                    versus = self._case(instance, table.versus, budget) if table.versus else None
                    row, column = (part.format(**names).strip() for part in (table.row, table.column))
                    yield Cell(row, column, self._case(instance, planner, budget), versus)

    def alone(self, cell: Cell) -> Cell:
        """The same cell of the table of times, flown while nothing else runs."""
        return replace(cell, case=replace(cell.case, alone=True), versus=None)

    def _usable(self, planner: str) -> bool:
        return self.file.planners[planner].get("needs") not in self._missing()

    def _missing(self) -> set[str]:
        """Packages that planners need and that are not there."""
        needs = {str(said["needs"]) for said in self.file.planners.values() if "needs" in said}
        return {name for name in needs if find_spec(name.partition(".")[0]) is None}

    def _case(self, instance: str, planner: str, budget: int | float | None) -> Case:
        said = {key: value for key, value in self.file.planners[planner].items() if key not in OURS}
        settings = {"instance": self.file.instances[instance], "planner": said}
        return Case(instance, planner, budget, json.dumps(settings, sort_keys=True))

    def _seeds(self, case: Case, count: int) -> range:
        said = self.file.planners[case.planner]
        return range(min(count * said.get("seeds_factor", 1), said.get("most_trials", count * 1_000_000)))


OURS = frozenset(OfCampaign.model_fields)
PARTS = "{instance}, {planner}, {budget} and {measure}"


def read_study(path: Path) -> Study:
    """Read a study file, or the `study.toml` of a folder.

    Raises
    ------
    DataFormatError          with every fault of the file
    """
    path = path / "study.toml" if path.is_dir() else path
    raw = _toml(path)
    try:
        file = StudyFile.model_validate(raw)
    except ValidationError as error:
        raise DataFormatError(*(_fault(path, detail) for detail in error.errors(include_url=False))) from None
    if faults := [*_impossible(path, file), *_unknown(path, file)]:
        raise DataFormatError(*faults)
    return Study(path.parent, file)


def _toml(path: Path) -> dict[str, Any]:
    expected = "expected a study in TOML"
    try:
        with path.open("rb") as opened:
            data = opened.read(MAX_BYTES + 1)
    except OSError as error:
        raise DataFormatError(Fault(str(path), "", str(error.strerror), expected)) from None
    if len(data) > MAX_BYTES:
        raise DataFormatError(Fault(str(path), "", "a file of more than 10 MB came", expected))
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise DataFormatError(Fault(str(path), "", "something that is not text came", expected)) from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise DataFormatError(Fault(str(path), "", f"it is not TOML ({error})", expected)) from None


def _fault(path: Path, detail: ErrorDetails) -> Fault:
    key = _key(detail["loc"])
    if detail["type"] == "extra_forbidden":
        return Fault(str(path), key, "there is no such key", "see the reference of study files, docs/study_file.md")
    if detail["type"] == "missing":
        return Fault(str(path), key, "nothing came", "expected this key")
    if detail["type"] == "too_short":
        return Fault(str(path), key, "none came", "expected at least one")
    said = detail["msg"].removeprefix("Input should be ").removeprefix("String should ")
    return Fault(str(path), key, f"{_short(detail['input'])} came", f"expected {WORDS.get(detail['type'], said)}")


WORDS = {
    "int_type": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "string_type": "text",
    "string_too_short": "text, not empty",
    "string_pattern_mismatch": 'text of the form "module:function"',
    "list_type": "a list",
    "dict_type": "a table, { ... }",
    "model_type": "a table, { ... }",
}


def _key(parts: Sequence[object]) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).lstrip(".")


def _short(came: Any) -> str:
    told = repr(came)
    return told if len(told) <= 60 else f"{told[:57]}..."


def _impossible(path: Path, file: StudyFile) -> Iterator[Fault]:
    """What instances and planners say that no trial can be told: a row of the ledger is JSON."""
    for kind, said in (("instances", file.instances), ("planners", file.planners)):
        yield from _no_json(path, (kind,), said)
    for name, told in file.planners.items():
        try:
            OfCampaign.model_validate({key: value for key, value in told.items() if key in OURS})
        except ValidationError as error:
            for detail in error.errors(include_url=False):
                yield _fault(path, {**detail, "loc": ("planners", name, *detail["loc"])})
    for name, told in file.instances.items():
        if "mission" in told and not isinstance(told["mission"], str):
            came = f"{_short(told['mission'])} came"
            yield Fault(str(path), f"instances.{name}.mission", came, "expected the name of a mission file")
        elif "mission" in told and file.data:
            came = f"{_short(told['mission'])} came with data"
            yield Fault(str(path), f"instances.{name}.mission", came, "leave data out: missions stand beside the study")


def _no_json(path: Path, key: tuple[object, ...], said: Any) -> Iterator[Fault]:
    if isinstance(said, (dict, list)):
        for part, value in said.items() if isinstance(said, dict) else enumerate(said):
            yield from _no_json(path, (*key, part), value)
    elif not isinstance(said, (str, int, float)) or (isinstance(said, float) and not isfinite(said)):
        yield Fault(str(path), _key(key), f"{said} came", "expected finite numbers, text, yes or no, lists, tables")


def _unknown(path: Path, file: StudyFile) -> Iterator[Fault]:
    """Tables that name what is not there, or ask for what cannot be."""
    for number, table in enumerate(file.tables):
        where = f"tables[{number}]"
        for kind, names, known in (
            ("instances", table.instances, file.instances),
            ("planners", table.planners, file.planners),
        ):
            for name in names or [""]:
                if not _chosen([name], known):
                    yield Fault(
                        str(path), f"{where}.{kind}", f"{_short(name)} came", f"expected some of {_listed(known)}"
                    )
        if table.versus is not None and table.versus not in file.planners:
            came = f"{_short(table.versus)} came"
            yield Fault(str(path), f"{where}.versus", came, f"expected one of {_listed(file.planners)}")
        if table.versus is not None and table.statistic == "rate":
            came = "'rate' came with versus"
            yield Fault(str(path), f"{where}.statistic", came, "expected mean or median: differences have no rate")
        if table.measures and table.measure:
            yield Fault(str(path), f"{where}.measures", "it came with measure", "expected one of them")
        for key in ("row", "column"):
            if not _is_template(getattr(table, key)):
                came = f"{_short(getattr(table, key))} came"
                yield Fault(str(path), f"{where}.{key}", came, f"expected {PARTS} only")


def _is_template(text: str) -> bool:
    try:
        parts = list(Formatter().parse(text))
    except ValueError:
        return False
    return all(
        field is None or (f"{{{field}}}" in PARTS and not spec and not conversion)
        for _, field, spec, conversion in parts
    )


def _listed(known: Mapping[str, Any]) -> str:
    names = list(known)
    return ", ".join(names[:20]) + (f" and {len(names) - 20} more" if len(names) > 20 else "")


def _chosen(wanted: Sequence[str], known: Mapping[str, Any]) -> list[str]:
    """Names in the order of the table, patterns in the order of the study."""
    found: dict[str, None] = {}
    for name in wanted:
        found |= dict.fromkeys([name] if name in known else [each for each in known if fnmatchcase(each, name)])
    return list(found)


def _named_by(mission: Path) -> list[Path]:
    """Files that a mission names, as far as it can be read."""
    try:
        tables = [table for table in _toml(mission).values() if isinstance(table, dict)]
    except DataFormatError:
        return []
    texts = [value for table in tables for value in table.values() if isinstance(value, str) and value]
    return [mission.parent / text for text in texts if (mission.parent / text).is_file()]
