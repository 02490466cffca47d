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
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from importlib.util import find_spec
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sooner.campaigns.campaign import Asked
from sooner.campaigns.trial import Case, Limits
from sooner.errors import DataFormatError, Fault

__all__ = ["Cell", "Study", "Table", "read_study"]

MAX_BYTES = 10_000_000
FLIGHT = "sooner.experiments.flight:fly"
RASTERS = (".csv", ".npy", ".tif", ".tiff")
Number = int | float
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class _Settings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Limits(_Settings):
    seconds: Positive = Field(default=3600.0, description="on the clock, of one trial")
    memory_mb: Positive | None = Field(default=None, description="of one trial; left out: its share of the machine")


class Table(_Settings):
    """`[[tables]]`: a table of the report, and the cases behind it.

    Its cells are instances x planners x budgets; `row` and `column` name them. Cells of one name are pooled.
    """

    name: str = Field(min_length=1, description="of the table")
    times: str | None = Field(default=None, description="a second table, of seconds: flown again, one at a time")
    instances: list[str] = Field(default=["*"], description="names; * and ? allowed")
    planners: list[str] = Field(default=["*"], description="names; * and ? allowed")
    budgets: list[Number] | None = Field(default=None, description="left out: those of the study")
    row: str = Field(default="{planner}", description="made of {instance}, {planner}, {budget}")
    column: str = Field(default="{instance} {budget}", description="made of {instance}, {planner}, {budget}")
    measure: str | None = Field(default=None, description="which number of a trial; left out: that of the study")
    statistic: Literal["mean", "median", "rate"] = Field(default="mean", description="over the seeds")
    versus: str | None = Field(default=None, description="a planner: paired differences from it, seed by seed")


class _File(_Settings):
    title: str = Field(min_length=1, description="of the report")
    trial: str = Field(default=FLIGHT, pattern=r"^[\w.]+:\w+$", description="module:function that flies one trial")
    trials: int = Field(default=10, ge=1, le=100_000_000, description="seeds 0, 1, ... of each case")
    timed_trials: int = Field(default=3, ge=1, description="seeds flown again, alone, where a table has times")
    measure: str = Field(default="value", description="the number of a trial that tables show")
    data: str = Field(default="", description="folder of real maps, below --data or SOONER_DATA")
    data_files: list[str] = Field(default=[], description="patterns of its files that decide what comes out")
    budgets: list[Number] = Field(default=[], description="left out: one case without a budget")
    limits: _Limits = _Limits()
    instances: dict[str, dict[str, Any]] = Field(min_length=1, description="name = { what the trial needs }")
    planners: dict[str, dict[str, Any]] = Field(min_length=1, description="name = { what the trial needs }")
    tables: list[Table] = []
    rules: list[dict[str, Any]] = Field(default=[], description="how numbers are judged against published ones")
    paper: dict[str, Any] = Field(default={}, description="of a published study: claims, figures")


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
    file : _File             what the file says
    """

    folder: Path
    file: _File

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
    def data_files(self) -> tuple[str, ...]:
        """Patterns of the files that decide what comes out: those the study names, missions and what lies by them."""
        missions = [PurePosixPath(said["mission"]) for said in self.file.instances.values() if "mission" in said]
        beside = [str(mission.parent / f"*{suffix}") for mission in missions for suffix in RASTERS]
        return tuple(dict.fromkeys([*self.file.data_files, *map(str, missions), *beside]))

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
        """Every case of every table once, with its seeds; `trials` overrules the file's number."""
        count = trials or self.file.trials
        seeds: dict[Case, range] = {}
        for table in self.tables:
            for cell in self.cells(table):
                seeds.setdefault(cell.case, self._seeds(cell.case, count))
                if cell.versus is not None:
                    seeds.setdefault(cell.versus, self._seeds(cell.versus, count))
                if table.times:
                    timed = min(len(seeds[cell.case]), self.file.timed_trials)
                    seeds.setdefault(self.alone(cell).case, range(timed))
        return Asked(tuple(seeds.items()))

    def cells(self, table: Table) -> Iterator[Cell]:
        """Of one table; planners that need a package that is not there are left out."""
        budgets: Sequence[Number | None] = table.budgets or self.file.budgets or [None]
        for instance in _chosen(table.instances, self.file.instances):
            for planner in _chosen(table.planners, self.file.planners):
                if planner == table.versus or not self._usable(planner):
                    continue
                for budget in budgets:
                    names = {"instance": instance, "planner": planner, "budget": "" if budget is None else budget}
                    versus = self._case(instance, table.versus, budget) if table.versus else None
                    row, column = (part.format(**names).strip() for part in (table.row, table.column))
                    yield Cell(row, column, self._case(instance, planner, budget), versus)

    def alone(self, cell: Cell) -> Cell:
        """The same cell of the table of times, flown while nothing else runs."""
        return replace(cell, case=replace(cell.case, alone=True), versus=None)

    def _usable(self, planner: str) -> bool:
        return find_spec(self.file.planners[planner].get("needs", "sooner")) is not None

    def _case(self, instance: str, planner: str, budget: Number | None) -> Case:
        said = {key: value for key, value in self.file.planners[planner].items() if key not in OURS}
        settings = {"instance": self.file.instances[instance], "planner": said}
        return Case(instance, planner, budget, json.dumps(settings, sort_keys=True))

    def _seeds(self, case: Case, count: int) -> range:
        said = self.file.planners[case.planner]
        return range(min(count * said.get("seeds_factor", 1), said.get("most_trials", count * 1_000_000)))


OURS = ("needs", "seeds_factor", "most_trials")
"""Keys of a planner that are for the campaign: a package, so many times as many seeds, so many at most."""


def read_study(path: Path) -> Study:
    """Read a study file, or the `study.toml` of a folder.

    Raises
    ------
    DataFormatError          with every fault of the file
    """
    path = path / "study.toml" if path.is_dir() else path
    try:
        with path.open("rb") as opened:
            text = opened.read(MAX_BYTES + 1)
        raw = tomllib.loads(text[:MAX_BYTES].decode("utf-8-sig"))
    except OSError as error:
        raise DataFormatError(Fault(str(path), "", str(error.strerror), "expected a study in TOML")) from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise DataFormatError(Fault(str(path), "", f"it is not TOML ({error})", "expected a study in TOML")) from None
    try:
        file = _File.model_validate(raw)
    except ValidationError as error:
        raise DataFormatError(*(_fault(path, dict(detail)) for detail in error.errors(include_url=False))) from None
    if faults := [*_unknown(path, file)]:
        raise DataFormatError(*faults)
    return Study(path.parent, file)


def _fault(path: Path, detail: Mapping[str, Any]) -> Fault:
    key = ".".join(str(part) for part in detail["loc"])
    if detail["type"] == "extra_forbidden":
        return Fault(str(path), key, "there is no such key", "see the reference of study files, docs/study_file.md")
    came = "nothing came" if detail["type"] == "missing" else f"{detail['input']!r} came"
    return Fault(str(path), key, came, f"expected: {detail['msg'].removeprefix('Input should be ')}")


def _unknown(path: Path, file: _File) -> Iterator[Fault]:
    """Tables that name what is not there."""
    for table in file.tables:
        where = f"tables.{table.name}"
        for kind, names, known in (
            ("instances", table.instances, file.instances),
            ("planners", [*table.planners, *([table.versus] if table.versus else [])], file.planners),
        ):
            for name in names:
                if not any(fnmatchcase(each, name) or each == name for each in known):
                    yield Fault(str(path), f"{where}.{kind}", f"{name!r} came", f"expected some of {', '.join(known)}")
        for key in ("row", "column"):
            try:
                getattr(table, key).format(instance="", planner="", budget="")
            except (KeyError, IndexError, ValueError, AttributeError):
                came = f"{getattr(table, key)!r} came"
                yield Fault(str(path), f"{where}.{key}", came, "expected {instance}, {planner} and {budget} only")


def _chosen(wanted: Sequence[str], known: Mapping[str, Any]) -> list[str]:
    """Names in the order of the table, patterns in the order of the study."""
    found: dict[str, None] = {}
    for name in wanted:
        found |= dict.fromkeys([name] if name in known else [each for each in known if fnmatchcase(each, name)])
    return list(found)
