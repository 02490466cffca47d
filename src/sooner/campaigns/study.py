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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from glob import escape
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sooner.campaigns.campaign import Asked
from sooner.campaigns.faults import chosen, examined, more
from sooner.campaigns.schema import MOST_TRIALS, OURS, OfCampaign, OfTrial, Rule, StudyFile, Table
from sooner.campaigns.trial import Case, Limits
from sooner.errors import DataFormatError, Fault

__all__ = [
    "MOST_TRIALS",
    "OURS",
    "Cell",
    "OfCampaign",
    "OfTrial",
    "Rule",
    "Study",
    "StudyFile",
    "Table",
    "read_study",
    "refused",
]


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
    name : str               of the file
    """

    folder: Path
    file: StudyFile
    name: str = "study.toml"

    @property
    def path(self) -> Path:
        """Where the file is."""
        return self.folder / self.name

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

    @property
    def modules(self) -> tuple[str, ...]:
        """Modules that planners are made from, as far as they are not sooner's: `make` wherever it stands."""
        named = (text.partition(":")[0] for text in _made_from(self.file.planners))
        return tuple(sorted({module for module in named if module.partition(".")[0] != "sooner"}))

    def told(self, planner: str) -> dict[str, Any]:
        """What a trial is told of a planner."""
        return {key: value for key, value in self.file.planners[planner].items() if key not in OURS}

    def usable(self) -> list[str]:
        """Planners that are flown and whose packages are there."""
        flown = (name for table in self.tables for name in (*chosen(table.planners, self.file.planners), table.versus))
        return [name for name in dict.fromkeys(flown) if name is not None and self._usable(name)]

    def only(self, names: Sequence[str]) -> Study:
        """The same study with fewer tables, * and ? allowed.

        Raises
        ------
        DataFormatError      if none is left
        """
        left = [table for table in self.tables if any(fnmatchcase(table.name, name) for name in names)]
        if not left:
            known = ", ".join(dict.fromkeys(repr(table.name) for table in self.tables))
            raise DataFormatError(Fault("tables", "", f"{', '.join(names)} came", f"expected some of {known}"))
        return replace(self, file=self.file.model_copy(update={"tables": left}))

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
        for instance in chosen(table.instances, self.file.instances):
            for planner in chosen(table.planners, self.file.planners):
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
        settings = {"instance": self.file.instances[instance], "planner": self.told(planner)}
        return Case(instance, planner, budget, json.dumps(settings, sort_keys=True))

    def _seeds(self, case: Case, count: int) -> range:
        said = self.file.planners[case.planner]
        return range(min(count * said.get("seeds_factor", 1), said.get("most_trials", count * 1_000_000)))


def read_study(path: Path) -> Study:
    """Read a study file, or the `study.toml` of a folder.

    Raises
    ------
    DataFormatError          with every fault of the file
    """
    from sooner.io.reading import read_toml  # here, because workers need a study but not the geography beside it

    path = path / "study.toml" if path.is_dir() else path
    file, faults = examined(path, read_toml(path, "expected a study in TOML"))
    study = None if file is None else Study(path.parent, file, path.name)
    if faults and study is not None and not any(fault.key == "trial" for fault in faults):
        faults += more(faults, refused(study))
    if faults or study is None:
        raise DataFormatError(*faults)
    return study


def refused(study: Study) -> tuple[Fault, ...]:
    """What the trial, where it is sooner's own, cannot fly of a study: it is asked before anything is flown."""
    module, _, name = study.file.trial.partition(":")
    if module.partition(".")[0] != "sooner":
        return ()
    try:
        loaded = import_module(module)
        getattr(loaded, name)
        getattr(loaded, "check", lambda study: None)(study)
    except (ImportError, AttributeError) as error:
        came = f"{study.file.trial!r} cannot be loaded ({error})"
        return (Fault(str(study.path), "trial", came, "expected a function in a module of sooner's"),)
    except DataFormatError as error:
        return error.faults
    return ()


def _made_from(said: Any) -> Iterator[str]:
    """Every `make = "module:Class"` in what a study says."""
    for key, value in said.items() if isinstance(said, dict) else enumerate(said):
        if key == "make" and isinstance(value, str) and ":" in value:
            yield value
        elif isinstance(value, (dict, list)):
            yield from _made_from(value)


def _named_by(mission: Path) -> list[Path]:
    """Files that a mission names, as far as it can be read."""
    from sooner.io.reading import read_toml

    try:
        said = read_toml(mission, "expected a mission file in TOML")
    except DataFormatError:
        return []
    tables = [table for table in said.values() if isinstance(table, dict)]
    texts = [value for table in tables for value in table.values() if isinstance(value, str) and value]
    return [mission.parent / text for text in texts if (mission.parent / text).is_file()]
