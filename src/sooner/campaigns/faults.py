"""What is wrong with a study file: every fault, with its key, what came and what was expected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from math import isfinite
from pathlib import Path
from string import Formatter
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from sooner.campaigns.schema import OURS, OfCampaign, StudyFile, Table
from sooner.errors import Fault

__all__ = ["chosen", "examined", "more"]

PARTS = "{instance}, {planner}, {budget} and {measure}"


def examined(path: Path, raw: Mapping[str, Any]) -> tuple[StudyFile | None, list[Fault]]:
    """A study file, and its faults: where there are some, as much of it as is sound."""
    try:
        file = StudyFile.model_validate(raw)
    except ValidationError as error:
        details = error.errors(include_url=False)
        found = [_fault(path, detail) for detail in details]
        sound = _sound(raw, {detail["loc"][:2] for detail in details})
        if sound is None:
            return None, found
        file, tables = sound
    else:
        found, tables = [], list(enumerate(file.tables))
    return file, [*found, *more(found, [*_impossible(path, file), *_unknown(path, file, tables)])]


def more(known: Sequence[Fault], found: Sequence[Fault]) -> list[Fault]:
    """Faults of places that had none yet."""
    return [fault for fault in found if not any(_same_place(fault.key, other.key) for other in known)]


def _same_place(key: str, other: str) -> bool:
    """Whether one of two keys is the other or stands below it."""
    return key == other or key.startswith(f"{other}.") or other.startswith(f"{key}.")


def _sound(
    raw: Mapping[str, Any], wrong: set[tuple[int | str, ...]]
) -> tuple[StudyFile, list[tuple[int, Table]]] | None:
    """What is left where every key at the top that has a fault is left out; of instances and planners their names."""
    left: dict[str, Any] = {}
    for key, said in raw.items():
        entries = {loc[1] for loc in wrong if loc[0] == key and len(loc) > 1}
        if key in ("instances", "planners") and isinstance(said, dict):
            left[key] = {name: {} if name in entries else told for name, told in said.items()}
        elif key not in {loc[0] for loc in wrong}:
            left[key] = said
    tables = []
    for number, table in enumerate(raw["tables"] if isinstance(raw.get("tables"), list) else ()):
        try:
            tables.append((number, Table.model_validate(table)))
        except ValidationError:
            continue
    try:
        return StudyFile.model_validate({"title": "?"} | left), tables
    except ValidationError:
        return None


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
    """Names that stand for others, and what no trial can be told: a row of the ledger is JSON."""
    for kind, said in (("instances", file.instances), ("planners", file.planners)):
        yield from _no_json(path, (kind,), said)
        for name in said:
            if "*" in name or "?" in name:  # a table that asks for "*" would get the one of that name alone
                expected = "expected no * or ?: in a table they stand for any text"
                yield Fault(str(path), f"{kind}.{name}", f"the name {_short(name)} came", expected)
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


def _unknown(path: Path, file: StudyFile, tables: Sequence[tuple[int, Table]]) -> Iterator[Fault]:
    """Tables that name what is not there, or ask for what cannot be."""
    for number, table in tables:
        where = f"tables[{number}]"
        for kind, names, known in (
            ("instances", table.instances, file.instances),
            ("planners", table.planners, file.planners),
        ):
            for name in names or [""]:
                if not chosen([name], known):
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


def chosen(wanted: Sequence[str], known: Mapping[str, Any]) -> list[str]:
    """Names in the order of the table, patterns in the order of the study."""
    found: dict[str, None] = {}
    for name in wanted:
        found |= dict.fromkeys([name] if name in known else [each for each in known if fnmatchcase(each, name)])
    return list(found)
