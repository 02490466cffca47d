"""The reference page of the mission file, written from what is checked."""

from __future__ import annotations

from pydantic import BaseModel

from sooner.io.reference import about, keys_table
from sooner.missions.settings import Area, Budget, Place, Searching, Sensor, Settings, Wish

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

_WORDS = {list: "[row, col]", Place: "{lat, lon}"}


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
        parts.append(f"## `{title}`\n\n{about(model)}\n\n{keys_table(model, _WORDS)}")
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
