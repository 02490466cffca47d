"""The reference page of the mission file, written from what is checked."""

from __future__ import annotations

import types
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

from sooner.missions.settings import Area, Budget, Searching, Sensor, Settings, Wish

__all__ = ["reference_page"]

_EXAMPLE = """\
```toml
name = "Hiker, 30 minutes"
[area]
poc = "poc.csv"               # .csv, .npy or GeoTIFF; weights of at least 0; row 0 is north
outside = 0.05                # probability that the person is not on this map
cell_m = 24.0                 # where the raster has no georeference
obstacles = "rocks.csv"
[sensor]                      # difficulty or glimpse
difficulty = "forest.csv"
[[searcher]]
start = [50, 50]              # [row, col]
end = [50, 50]
kind = "copter"
speed_mps = 12.0
[budget]
seconds = 1800                # or steps = 900
```
"""

_TABLES: tuple[tuple[str, type[BaseModel]], ...] = (
    ("[area]", Area),
    ("[sensor]", Sensor),
    ("[[searcher]]", Searching),
    ("[budget]", Budget),
    ("[objective]", Wish),
)


def reference_page() -> str:
    """`docs/mission_file.md`, as Markdown."""
    parts = [
        "# The mission file",
        "A mission file is TOML. Paths are relative to its folder. Every fault of the file and of its rasters is "
        "reported at once, with file, key, what came and what was expected. Keys marked *not yet* have their meaning "
        "already, but this version refuses them.",
        _EXAMPLE.strip(),
        f"At the top: `name`, {Settings.model_fields['name'].description}.",
    ]
    for title, model in _TABLES:
        head = "| key | value | left out | meaning |\n|---|---|---|---|"
        parts.append(f"## `{title}`\n\n{_about(model)}\n\n{head}\n{_rows(model)}")
    parts.append(
        "## Time\n\nWith `steps` time is counted in moves from cell to cell, as the papers do. With `seconds` a step "
        "takes `cell_m / speed_mps` (on `square8` the length of a diagonal counts for every step, so that no flight "
        "takes longer than it says), and the budget is the steps that fit. Flight is level and at constant speed; "
        "turns cost no time in this version."
    )
    parts.append(
        "## Georeference\n\nA GeoTIFF must be in a projection in metres or feet, with square cells, north up. Its cell "
        "size goes before `cell_m`, which must agree where both are given; rasters of one mission must lie on the same "
        'cells. "No data" counts as weight 0 in `poc` and as free ground in `obstacles`.'
    )
    return "\n\n".join(parts) + "\n"


def _about(model: type[BaseModel]) -> str:
    return (model.__doc__ or "").partition(": ")[2].strip().rstrip(".").capitalize() + "."


def _rows(model: type[BaseModel]) -> str:
    lines = []
    for name, field in model.model_fields.items():
        default = "" if field.default is None else f"`{_toml(field.default)}`"
        meaning = (field.description or "").replace("(not yet)", "(*not yet*)")
        lines.append(f"| `{name}` | {_kind(field.annotation)} | {default} | {meaning} |")
    return "\n".join(lines)


def _toml(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


def _kind(annotation: Any) -> str:
    """A type in words."""
    origin = get_origin(annotation)
    if origin is Literal:
        return ", ".join(f'`"{choice}"`' for choice in get_args(annotation))
    if origin in (types.UnionType, None) or str(origin) == "typing.Union":
        parts = get_args(annotation) or (annotation,)
        return " or ".join(dict.fromkeys(_word(part) for part in parts if part is not type(None)))
    return _word(annotation)


def _word(part: Any) -> str:
    if get_origin(part) is not None and hasattr(part, "__metadata__"):
        return _word(get_args(part)[0])
    if get_origin(part) is list:
        return "[row, col]"
    words = {str: "text", float: "number", int: "whole number"}
    return words.get(part, "{lat, lon}")
