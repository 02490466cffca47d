"""What is wrong with a mission file: collected, told in our words, and reported at once."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from sooner.errors import DataFormatError, Fault
from sooner.missions.settings import Place, Settings

__all__ = ["Faults"]

Read = TypeVar("Read", bound=BaseModel)

_MOST_LIKE = 10  # faults that differ in numbers and names alone
_NUMBER_OR_NAME = re.compile(r"'[^']*'|\d+(\.\d+)?")


class Faults:
    """The faults of one file found so far, one for each key."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.found: list[Fault] = []
        self.wrong: set[str] = set()  # keys already reported

    def add(self, key: str, came: str, expected: str) -> None:
        """Note a fault, unless the key has one that makes this one moot."""
        if key not in self.wrong:
            self.found.append(Fault(str(self.path), key, came, expected))

    def once(self, key: str, came: str, expected: str) -> None:
        """Note a fault, and nothing more of this key."""
        self.add(key, came, expected)
        self.wrong.add(key)

    def among(self, key: str) -> bool:
        """Whether something is wrong with a key or with one below it."""
        return any(each.startswith(key) for each in self.wrong)

    def refuse(self) -> None:
        """Raise DataFormatError with the faults, ten of each kind, if there are any."""
        if self.found:
            raise DataFormatError(*_some_of_each_kind(self.found))

    def settings(self, raw: dict[str, Any]) -> Settings:
        """What a mission file says, without the keys that are wrong; those are reported and left out."""
        return self.read(raw, Settings)

    def read(self, raw: dict[str, Any], model: type[Read]) -> Read:
        """What a file says, by the model of what it may say, whose keys can all be left out; likewise."""
        for _ in range(10):  # taking out a key can bring another fault of the same table to light
            try:
                return model.model_validate(raw)
            except ValidationError as error:
                found = error.errors(include_url=False)
            for key, fault in _schema_faults(str(self.path), raw, found, model):
                if key not in self.wrong:
                    self.wrong.add(key)
                    self.found.append(fault)
            for detail in found:
                _take_out(raw, detail["loc"])
        raise DataFormatError(*_some_of_each_kind(self.found))


def _some_of_each_kind(found: Iterable[Fault]) -> list[Fault]:
    """The first faults of each kind, and at the end how many more there are of it."""
    told: list[Fault] = []
    count: Counter[tuple[str, ...]] = Counter()
    firsts: dict[tuple[str, ...], Fault] = {}
    for fault in found:
        kind = tuple(_NUMBER_OR_NAME.sub("", text) for text in (fault.key, fault.came, fault.expected))
        count[kind] += 1
        firsts.setdefault(kind, fault)
        if count[kind] <= _MOST_LIKE:
            told.append(fault)
    for kind, first in firsts.items():
        if (more := count[kind] - _MOST_LIKE) > 0:
            key = re.sub(r"\[\d+\]", "[...]", first.key)
            told.append(Fault(first.file, key, f"{more:,} more faults like these", "see the lines above"))
    return told


def _schema_faults(
    file: str, raw: dict[str, Any], found: Iterable[ErrorDetails], model: type[BaseModel]
) -> list[tuple[str, Fault]]:
    """pydantic's findings in our words, one per key."""
    by_key: dict[str, list[ErrorDetails]] = {}
    for detail in found:
        by_key.setdefault(_key(detail["loc"]), []).append(detail)
    faults = []
    for key, details in by_key.items():
        if details[0]["type"] == "extra_forbidden":
            came, expected = "this key is not known", _known(details[0]["loc"], model)
        else:
            came = f"{_told(_at(raw, details[0]['loc']))} came"
            expected = "expected " + " or ".join(dict.fromkeys(_wanted(detail) for detail in details))
        faults.append((key, Fault(file, key, came, expected)))
    return faults


_BRANCHES = {"str", "float", "constrained-float", "list[int]", "Place", "constrained-list", "list[constrained-int]"}
_BRANCHES |= {"Drawing", "NoFlyCircle", "Segments", "LandCover"}


def _place(loc: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """Where in the file: without the branches of a union that pydantic names, and whole cells rather than a number."""
    place = []
    for part in loc:
        if isinstance(part, str) and (part in _BRANCHES or "[" in part or "(" in part):
            break
        place.append(part)
    return tuple(place) or loc[:1]  # a key at the top that looks like a branch


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


def _known(loc: tuple[int | str, ...], model: type[BaseModel]) -> str:
    """The keys of the table that a key was not known in."""
    for part in loc[:-1]:
        if part in model.model_fields:
            model = _table(model.model_fields[str(part)].annotation) or model
    return f"expected {'' if model is Place else 'one of '}{', '.join(model.model_fields)}"


def _table(annotation: Any) -> type[BaseModel] | None:
    """The table that a key holds, or a list of such; None where it holds no table."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := _table(part)) is not None), None)


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
    "string_pattern_mismatch": "text in one line, without control characters",
    "bool_type": "true or false",
}


def _wanted(detail: ErrorDetails) -> str:
    kind, limits = detail["type"], detail.get("ctx", {})
    branch = str(detail["loc"][-1]) if detail["loc"] else ""
    if "start" in detail["loc"] or "end" in detail["loc"]:
        place = isinstance(detail["input"], dict) or branch in Place.model_fields
        return "lat from -90 to 90, lon from -180 to 180" if place else "[row, col] in whole numbers"
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
