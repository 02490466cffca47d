"""The reference page of the mission file, written from what is checked."""

from __future__ import annotations

from pydantic import BaseModel

from sooner.io.reference import about, keys_table
from sooner.missions.separations import SeparationSettings
from sooner.missions.settings import (
    Area,
    Budget,
    CameraSettings,
    Cutting,
    Drawing,
    Estimating,
    Hearing,
    LandCover,
    LastKnown,
    NoFlyCircle,
    Place,
    Searching,
    Segments,
    Sensor,
    Settings,
    TargetSettings,
    Window,
    Wish,
)
from sooner.missions.winds import WindSettings

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

An area that is drawn, at a command post:

```toml
[area]
polygon = "search.geojson"    # or .gpkg, .kml, .kmz, .gpx; CalTopo exports as they are
flight_area = "flight.geojson"  # left out: the search area; with the car park that drones launch from, say
no_fly = ["village.kml", { file = "masts.gpx", radius_m = 80 }, { lat = 46.12, lon = 11.25, radius_m = 150 }]
margin_m = 15
points = "launch.gpx"         # whose titles start and end may name
elevation = "terrain.tif"     # rasters in any projection
cell_m = 20.0
[area.last_known]             # or poc = "poc.tif", or segments = "segments.gpkg", or none: anywhere alike
place = { lat = 46.1, lon = 11.2 }
rings_m = [300, 900, 2000]
quantiles = [0.25, 0.5, 0.95]
[sensor]
glimpse = 0.7
[[searcher]]
start = "launch"
end = "launch"
speed_mps = 10.0
[budget]
seconds = 1500
```

A search over regions, of evidence:

```toml
[area]
evidence = "theta.tif"        # P(a target is in this cell), each cell by itself; 0.5 where nothing is known
obstacles = "rocks.tif"
[sensor]
detect = 0.85                 # P(a look says yes, if a target is there)
false_alarm = 0.15            # P(a look says yes, if none is there)
radius_m = 8.8                # or camera = { fov_deg = 90, altitude_m = 8.8, pixels = 1200, exposure_s = 0.001 }
[[searcher]]
start = [90, 33]
moves = "regions"
speed_mps = 5.0
accel_mps2 = 2.0
[budget]
seconds = 1500
[objective]
kind = "information"          # or "detection"
```

A team that maps streets which nobody knows, and hunts whoever walks on them; `sooner simulate` flies it:

```toml
[area]
streets = "streets.json"      # the truth, or an OpenStreetMap extract; the team does not know it
[target]                      # left out: nobody is there
bias = "evasive"
[estimator]
detector = "lrdt"
[sensor]
radius_m = 12.5
[[searcher]]                  # one table for each drone
moves = "waypoints"
speed_mps = 3.0
accel_mps2 = 2.0
[budget]
seconds = 240
replan_s = 5
```
"""

_STREETS = """\
## Streets

`area.streets` names a file in JSON, as `sooner scenario street-grid` writes one:

```json
{
  "name": "Two blocks",
  "sw_corner_latlon": [46.1, 11.2],
  "cell_m": 5.0,
  "shape": [3, 4],
  "node_columns": ["id", "x_m", "y_m", "bx", "by"],
  "nodes": [[0, 2.5, 2.5, 0, 0], [1, 7.5, 2.5, 1, 0], [2, 12.0, 7.5, 2, 1], [3, 17.5, 12.5, 3, 2]],
  "edges": [[0, 1], [1, 2], [2, 3]]
}
```

| key | value | left out | meaning |
|---|---|---|---|
| `cell_m` | number |  | metres between cell centres, 0.001 to 1,000,000 |
| `shape` | [rows, columns] |  | of the grid of cells; or `size_m` |
| `size_m` | number |  | instead of `shape`: metres from edge to edge of a square of whole cells |
| `nodes` | list of [id, x_m, y_m, bx, by] |  | points of streets, at least one; a cell holds one at most |
| `edges` | list of [id, id] |  | pairs of nodes between which one can walk; their cells touch, at a side or a corner |
| `sw_corner_latlon` | [lat, lon] |  | of the grid's south-west corner, in degrees; needed by starts in `{lat, lon}` |
| `scale_real_metres_per_map_metre` | number | `1.0` | how far on the globe one metre of the map is |
| `name`, `attribution` | text | `""` | of the map, and who must be named beside it |

A node's `id` is a whole number, once in the file. `x_m` counts metres to the east and `y_m` to the north from the
**south-west corner** of the grid, not from a cell's centre; `bx` counts columns from the west and `by` rows **from the
south**, both from 0: they are the cell that holds the node, so that `bx * cell_m <= x_m <= (bx + 1) * cell_m`, and
likewise `y_m`. (A `start = [row, col]` of the mission file counts rows from the north, as everywhere else:
`row = rows - 1 - by`.)
`node_columns` is there for readers; other keys are passed over. At most 1,000,000 cells and 50 MB are read.
"""

_TABLES: tuple[tuple[str, type[BaseModel]], ...] = (
    ("[area]", Area),
    ("Drawn in a file", Drawing),
    ("A circle of no_fly", NoFlyCircle),
    ("[area.segments]", Segments),
    ("[area.last_known]", LastKnown),
    ("[area.land_cover]", LandCover),
    ("[area.window]", Window),
    ("[sensor]", Sensor),
    ("[sensor.camera]", CameraSettings),
    ("[[searcher]]", Searching),
    ("[budget]", Budget),
    ("[objective]", Wish),
    ("[target]", TargetSettings),
    ("[estimator]", Estimating),
    ("[regions]", Cutting),
    ("[links]", Hearing),
    ("[wind]", WindSettings),
    ("[separation]", SeparationSettings),
)

_NAMED = (CameraSettings, Window, Drawing, NoFlyCircle, Segments, LastKnown, LandCover)
_WORDS = {list: "[row, col]", dict: "table", Place: "{lat, lon}"} | dict.fromkeys(_NAMED, "table")


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
        title = f"`{title}`" if title.startswith("[") else title
        parts.append(f"## {title}\n\n{about(model)}\n\n{keys_table(model, _WORDS)}")
    parts.append(
        "## Time\n\nWith `steps` time is counted in moves from cell to cell, as the papers do. With `seconds` a step "
        "takes `cell_m / speed_mps` (on `square8` the length of a diagonal counts for every step, so that no flight "
        "takes longer than it says), and the budget is the steps that fit. Flight is level and at constant speed; "
        "turns cost no time in this version. Over regions seconds are those of a drone that speeds up, brakes and "
        "turns within its limits: no flight takes longer than its plan says. Along legs likewise: a drone stops where "
        "it turns, and `[wind]` and climbs over `elevation` take their time; with a `vehicle` each battery lasts its "
        "endurance less reserve, climbing and landing, the next begins after `swap_s`, and `seconds`, if there, ends "
        "the whole search. Over waypoints all look, and targets take "
        "a step, once a second."
    )
    parts.append(
        "## What values count\n\nOver `poc`, detection is the probability of having found the person. Over `evidence` "
        "cells are independent and total nothing: detection is the number of targets expected to be found. Information "
        "is what the looks are expected to teach, in bits, over either; over `poc` each cell is taken by itself, and a "
        "yes never errs.\n\n"
        "Along legs `sweep_width_m` by the exponential law is the effort of search theory: legs L over ground A are a "
        "coverage C = W L / A, and POD = 1 - exp(-C), as if the effort lay at random within the radius. One straight "
        "leg alone therefore finds less than a sure strip of width W: as much as one of 0.62 W where `radius_m` is "
        "left out (W / 2), 0.77 W where it is W, 0.92 W where it is 3 W. Who knows a strip in which everybody is seen "
        "writes `radius_m`, half of its width, and no `sweep_width_m`.\n\n"
        "What other combinations mean nobody has said, and they are refused: a target CDP over "
        "evidence or in bits, false alarms over `poc`, correlated looks but for detection over `poc`."
    )
    parts.append(
        "## Georeference\n\nA GeoTIFF in a projection in metres or feet, with square cells, north up, is the grid "
        "itself: its cell size goes before `cell_m`, which must agree where both are given, and the mission's other "
        "rasters must lie on the same cells. Any other GeoTIFF, in degrees say, and every one where `polygon`, "
        "`flight_area`, `segments`, `last_known` or `frame` is given, is brought to a grid of metres over the area: "
        "`poc` by the ground that cells have in common, so that no probability is lost; difficulty, glimpse and "
        "evidence by their mean over a cell; classes at its centre; elevation between centres; an obstacle on any part "
        "of a cell shuts it. The notes of a plan say how true the metres are. Over cells and regions drones enter "
        "cells that lie wholly in `flight_area`, else the area, off `no_fly` and their margins. "
        '"No data" counts as 0 in `poc` and `evidence` and as '
        "free ground in `obstacles`. Files that aircraft fly (`sooner export`, `sooner plan --format`) need a "
        "georeference: of `poc` or `evidence`, or of an area that is drawn."
    )
    parts.append(_STREETS.strip())
    return "\n\n".join(parts) + "\n"
