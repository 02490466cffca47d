"""What a mission file may say, key by key; `docs/mission_file.md` is checked against this."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from sooner.errors import Fault
from sooner.missions.separations import SeparationSettings
from sooner.missions.winds import WindSettings

__all__ = [
    "MAX_STEPS",
    "Area",
    "Budget",
    "CameraSettings",
    "Cutting",
    "Drawing",
    "Estimating",
    "Hearing",
    "LandCover",
    "LastKnown",
    "NoFlyCircle",
    "Place",
    "Searching",
    "Segments",
    "Sensor",
    "Settings",
    "TargetSettings",
    "Window",
    "Wish",
    "misplaced",
    "not_yet",
]

Cell = Annotated[list[Annotated[int, Field(strict=True)]], Field(min_length=2, max_length=2)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Metres = Annotated[float, Field(ge=0.001, le=1_000_000, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Speed = Annotated[float, Field(ge=0.001, le=1_000, allow_inf_nan=False)]
Altitude = Annotated[float, Field(ge=1, le=10_000, allow_inf_nan=False)]

# no control characters, ends of lines, or marks that turn the direction of writing: it is shown on terminals
Name = Annotated[str, Field(pattern="^[^\\p{Cc}\\p{Zl}\\p{Zp}\\u202a-\\u202e\\u2066-\\u2069]*$")]
Share = Annotated[float, Field(gt=0, lt=1, allow_inf_nan=False)]
Sensitivity = Annotated[float, Field(ge=0, le=30, allow_inf_nan=False)]

MAX_STEPS = 200_000


class _Table(BaseModel):
    # every key has a default, so that a file with faults still shows what else is wrong with it
    model_config = ConfigDict(extra="forbid", frozen=True)


class Place(_Table):
    """A place by its coordinates."""

    lat: float = Field(default=0.0, ge=-90, le=90, description="degrees north")
    lon: float = Field(default=0.0, ge=-180, le=180, description="degrees east")


class Window(_Table):
    """`[area.window]`: the part of an OpenStreetMap extract that is searched; left out: all that its bounds hold."""

    rows: Annotated[int, Field(strict=True, ge=1)] | None = Field(default=None, description="cells from north to south")
    cols: Annotated[int, Field(strict=True, ge=1)] | None = Field(default=None, description="cells from west to east")
    south_west: Place | None = Field(
        default=None, description="{ lat = 46.1, lon = 11.2 } of its corner; left out: the extract's"
    )
    scale: Positive = Field(default=1.0, description="real metres that become one metre of the map")
    cut: bool = Field(default=False, description="end streets where the extract lacks their nodes; else a fault")


class Drawing(_Table):
    """`{ file = ... }`: what is drawn in a vector file, wherever a file's name alone may stand too."""

    file: str | None = Field(default=None, description=".geojson, .json, .gpkg, .kml, .kmz or .gpx")
    layer: str | None = Field(default=None, description="of a .gpkg that has several")
    title: str | None = Field(default=None, description="only what has this title; left out: all")
    radius_m: Metres | None = Field(
        default=None,
        description="of `no_fly` and `obstacles`: around points and lines, which need one; left out: their own "
        "`radius_m`",
    )


class NoFlyCircle(_Table):
    """`{ lat, lon, radius_m }`: a circle that nothing flies over, wherever `no_fly` may name a file."""

    lat: float | None = Field(default=None, ge=-89.9, le=89.9, description="degrees north; required")
    lon: float | None = Field(default=None, ge=-180, le=180, description="degrees east; required")
    radius_m: Metres | None = Field(default=None, description="required")


Drawings = str | Drawing | list[str | Drawing]
Zones = str | Drawing | NoFlyCircle | list[str | Drawing | NoFlyCircle]


class Segments(_Table):
    """`[area.segments]`: polygons of search segments, each with its own POC, even within it.

    A file's name alone may stand instead: `segments = "segments.gpkg"`, whose polygons have an attribute `poc`.
    """

    file: str | None = Field(default=None, description="vector file with a polygon, or several, for each segment")
    layer: str | None = Field(default=None, description="of a .gpkg that has several")
    attribute: str = Field(
        default="poc", description="of each polygon: its POC; shares where none is above 1, else percent"
    )
    poc: dict[str, NotNegative] | None = Field(
        default=None, description="instead of the attribute: { title = POC } of each segment, as above"
    )


class LastKnown(_Table):
    """`[area.last_known]`: a first map from where the person was last known to be, and how far others were found.

    The rest, 1 less the last quantile, lies outside. Even by area within each ring: of all maps that agree with the
    table the one that claims least.
    """

    place: Place | str | None = Field(default=None, description="{ lat, lon }, or the title of a point in the files")
    rings_m: list[Metres] | None = Field(default=None, description="distances, growing, metres")
    quantiles: list[Annotated[float, Field(gt=0, le=1)]] | None = Field(
        default=None, description="share of cases found within each distance, growing"
    )


class LandCover(_Table):
    """`[area.land_cover]`: classes of ground, of which `[sensor.land_cover]` says what a look detects there.

    A file's name alone may stand instead.
    """

    file: str | None = Field(default=None, description="a GeoTIFF of whole numbers, or a vector file of polygons")
    layer: str | None = Field(default=None, description="of a .gpkg that has several")
    attribute: str = Field(default="class", description="of each polygon: its class")


class Area(_Table):
    """`[area]`: where the person may be."""

    poc: str | None = Field(
        default=None, description="raster of weights, at least 0; normalised; row 0 is north (this or `evidence`)"
    )
    outside: float = Field(
        default=0.0, ge=0, lt=1, strict=True, description="probability that the person is not on this map"
    )
    evidence: str | None = Field(
        default=None, description="instead of `poc`: raster of P(a target is in this cell), each cell by itself"
    )
    streets: str | None = Field(
        default=None,
        description="over waypoints, instead of `poc`: true streets, an occupancy graph (.json) or an OpenStreetMap "
        "extract (.osm, .pbf); the team does not know them",
    )
    window: Window | None = Field(default=None, description="of an extract: a table, as below")
    cell_m: Metres | None = Field(
        default=None,
        description="metres between cell centres, where the raster has no georeference or a grid is laid over "
        "`polygon`, there at most 40,000 cells if left out; of an extract, 5 if left out",
    )
    polygon: Drawings | None = Field(
        default=None,
        description="vector file of the search area, or several, or a table as below; holes are kept. Without `poc`, "
        "`segments` and `last_known` the person is anywhere in it alike; what `poc` has beyond it counts as `outside`",
    )
    flight_area: Drawings | None = Field(
        default=None,
        description="likewise, of where drones may be, where that is more than the search area: with the car park that "
        "they launch from, say. Left out: the search area. Looks count within the search area alone",
    )
    no_fly: Zones | None = Field(
        default=None,
        description="likewise, of ground that nothing flies over; points and lines with a radius too, and circles as "
        "below",
    )
    margin_m: Annotated[float, Field(ge=0, le=10_000, allow_inf_nan=False)] = Field(
        default=0.0, description="to keep from the border of `flight_area`, else of `polygon`, and from `no_fly`"
    )
    points: Drawings | None = Field(
        default=None, description="likewise, of points whose titles `start`, `end` and `place` may name; all others too"
    )
    segments: str | Segments | None = Field(default=None, description="instead of `poc`: a file or a table, as below")
    last_known: LastKnown | None = Field(default=None, description="instead of `poc`: a table, as below")
    elevation: str | None = Field(default=None, description="GeoTIFF of metres above the sea, in any projection")
    land_cover: str | LandCover | None = Field(
        default=None, description="of `sensor.land_cover`: a file or a table, as below"
    )
    frame: str | None = Field(
        default=None,
        description="projection in metres of the grid, `EPSG:32632` say; left out: one centred on `polygon`. Rasters "
        "may be of any projection where it, `polygon`, `flight_area`, `segments` or `last_known` is given",
    )
    obstacles: Drawings | None = Field(
        default=None,
        description="raster; non-zero cells cannot be entered. Or drawn, as `no_fly`; or an OpenStreetMap extract "
        "(.osm, .pbf): its buildings",
    )
    grid: Literal["square4", "square8", "hex"] = Field(
        default="square4",
        description="neighbours of a cell: 4, 8 (none past an obstacle's corner), or 6 (odd rows half a cell east); "
        "drones that move over regions fly as with 8",
    )


class CameraSettings(_Table):
    """`[sensor.camera]`: a camera that looks straight down; it sets `radius_m` and caps the speed."""

    fov_deg: float | None = Field(default=None, gt=0, lt=180, description="full angle of view, degrees")
    altitude_m: Metres | None = Field(default=None, description="above the ground; radius = altitude tan(fov / 2)")
    pixels: Annotated[int, Field(strict=True, ge=1)] | None = Field(
        default=None, description="along the direction of flight"
    )
    exposure_s: Positive | None = Field(
        default=None, description="of one picture: no faster than it moves by a pixel meanwhile, turning at 0.5 rad/s"
    )


class Sensor(_Table):
    """`[sensor]`: what one look detects: difficulty, glimpse, or detect; left out: every look detects."""

    difficulty: str | None = Field(
        default=None, description="raster of levels d, at least 0; glimpse = 1 - d / (d_max + 1)"
    )
    glimpse: float | str | None = Field(
        default=None,
        description="P(detect in one look, if there): a number or a raster in [0, 1]; over waypoints P(a look sees the "
        "cell, its street and its target): else, under canopy say, both sensors read noise; 1 if left out",
    )
    land_cover: dict[str, Annotated[float, Field(ge=0, le=1)]] | None = Field(
        default=None,
        description="instead of `glimpse`: { class = glimpse } of each class of `area.land_cover`; `else`: all others",
    )
    correlation: float = Field(
        default=0.0, ge=0, le=1, description="of two looks at one place; 0: independent, 1: a second look adds nothing"
    )
    detect: float | None = Field(default=None, ge=0, le=1, description="P(a look says yes, if a target is there)")
    false_alarm: float | None = Field(
        default=None,
        ge=0,
        le=1,
        description="P(a look says yes, if none is there): 0, or below `detect`; not with `correlation`",
    )
    model: Literal["binary", "beta"] = Field(
        default="binary",
        description="`beta`: targets come and go, and evidence is the mean of a Beta law of how often they are in view",
    )
    prior_looks: Positive = Field(
        default=2.0, description="of model `beta`: how many looks the evidence stands for; 2 with theta 0.5: any rate"
    )
    sweep_width_m: Metres | str | None = Field(
        default=None,
        description="along legs, instead of `glimpse`: sweep width W of search theory in metres, a number or a "
        "raster; coverage C = W L / A of legs L over ground A adds up, and POD = 1 - exp(-C), as for effort laid at "
        "random; one straight leg alone finds less, see below",
    )
    law: Literal["exponential", "inverse_cube"] | None = Field(
        default=None,
        description="of `sweep_width_m`: `exponential`, alike for each metre in view, if left out, within `radius_m`, "
        "else W / 2; `inverse_cube`: falling off with the cube of the distance, within `radius_m`, else 3 W",
    )
    radius_m: Metres | None = Field(
        default=None,
        description="over regions: cells with centres so near to the path are looked at (or `camera`); along legs: the "
        "ground so near to the line is (or `camera`, here or in the vehicle file); over waypoints: all cells with "
        "centres so near are looked at every second",
    )
    map_sensitivity: Sensitivity = Field(
        default=4.0,
        description="over waypoints: standard deviations by which a look at a street stands out from one beside it",
    )
    target_sensitivity: Sensitivity = Field(
        default=4.0, description="over waypoints: likewise of a look at a target; 0 is blind"
    )
    levels: Annotated[int, Field(strict=True, ge=2, le=1000)] = Field(
        default=25, description="over waypoints: how many different answers a look can give"
    )
    camera: CameraSettings | None = Field(
        default=None, description="over regions and along legs, instead of `radius_m`: a table, as below"
    )
    range_m: Metres | None = Field(
        default=None, description="over regions: how far ahead obstacles are seen; no faster than stops within it"
    )


class Searching(_Table):
    """`[[searcher]]`: a drone."""

    start: Cell | Place | str | None = Field(
        default=None,
        description="[row, col] where it starts (required), or { lat = 46.1, lon = 11.2 } on a georeferenced map, or "
        "the title of a point in the area's files; over waypoints all may leave it out, and start on the edge of the "
        "map, as drawn by the seed or the strategy",
    )
    end: Cell | Place | str | None = Field(default=None, description="where it must be at the end, likewise")
    moves: Literal["cells", "regions", "legs", "waypoints"] = Field(
        default="cells",
        description="`cells`: a cell a step; `regions`: whole regions, with true accelerations; `legs`: straight legs "
        "between any places, as aircraft fly them; `waypoints`: anywhere, mapping unknown `streets`, as "
        "`sooner simulate` flies it",
    )
    vehicle: str | None = Field(
        default=None, description="along legs: a vehicle file, instead of `kind`, `speed_mps` and `accel_mps2`"
    )
    batteries: Annotated[int, Field(strict=True, ge=1, le=100)] = Field(
        default=1, description="along legs, of the vehicle: one sortie each, one after the other"
    )
    kind: Literal["copter", "fixed_wing"] = Field(
        default="copter", description="a copter may hover; a fixed wing neither hovers nor turns straight back"
    )
    speed_mps: Speed | None = Field(
        default=None,
        description="metres a second; over cells the same for all, turns steps into seconds; else the most",
    )
    accel_mps2: Speed | None = Field(
        default=None, description="over regions, legs and waypoints: the most, metres a second squared"
    )
    altitude_m: Altitude | None = Field(
        default=None,
        description="at which an exported flight is flown, above where it takes off; along legs above the ground, as "
        "`elevation` tells it; left out: the camera's, or 60",
    )
    radius_m: Metres | None = Field(default=None, description="over waypoints: its own, instead of the sensor's")
    map_sensitivity: Sensitivity | None = Field(default=None, description="over waypoints: likewise")
    target_sensitivity: Sensitivity | None = Field(default=None, description="over waypoints: likewise")


class Budget(_Table):
    """`[budget]`: how long the search lasts; one of the two."""

    steps: Annotated[int, Field(strict=True, ge=1, le=MAX_STEPS)] | None = Field(
        default=None, description="moves from cell to cell, at least 1"
    )
    seconds: Positive | None = Field(
        default=None,
        description="flying time; needs `cell_m` and `speed_mps`, over regions and legs `accel_mps2` too, or a "
        "`vehicle`; along legs of the whole search, batteries changed and all; over waypoints whole",
    )
    replan_s: Annotated[int, Field(strict=True, ge=1)] | None = Field(
        default=None, description="over waypoints: seconds from one plan to the next, 5 if left out"
    )


class Wish(_Table):
    """`[objective]`: what is good."""

    kind: Literal["detection", "information"] = Field(
        default="detection",
        description="`detection`: find the person (over evidence: as many targets as can be expected); "
        "`information`: learn most, in bits",
    )
    detection_target: float | None = Field(
        default=None,
        gt=0,
        le=1,
        description="over `poc`: reach this CDP as soon as possible; several drones over regions only",
    )
    early: bool | None = Field(
        default=None,
        description="over regions: give up at most 0.5 % of the total to have the rest sooner; along legs: give "
        "up at most 0.1 % for fewer places, and fly the same legs earlier. Left out: so for detection, as a find "
        "counts when it is made; not for information, which is read after the flight",
    )


class TargetSettings(_Table):
    """`[target]`: who walks on the streets, over waypoints; left out, nobody does, and what is called is false.

    A target begins at a node drawn by the seed and takes a step a second [Wolek2020, eq. (1), (2)].
    """

    count: Annotated[int, Field(strict=True, ge=0, le=1000)] = Field(default=1, description="how many there are")
    rest: float = Field(default=0.5, ge=0, lt=1, description="probability to rest in a second")
    turn_scale: NotNegative = Field(
        default=1.0, description="how much rather it goes on than back: 1 + this times as likely; 0: all the same"
    )
    turn_shape: Positive = Field(default=0.1, description="how that falls off with the angle of the turn")
    bias: Literal["none", "evasive"] = Field(default="none", description="`evasive`: it shies away from drones")
    reach_m: Metres = Field(default=12.5, description="of bias `evasive`: how far off it notices a drone")
    boldness: float = Field(
        default=0.05,
        gt=0,
        le=1,
        description="of bias `evasive`: how likely a step beneath a drone still is; 1: no fear",
    )


class Estimating(_Table):
    """`[estimator]`: what the team makes of its looks, over waypoints."""

    detector: Literal["cbht", "lrdt"] = Field(
        default="lrdt",
        description="`cbht` tests each cell by itself; `lrdt` tracks a target along the streets before it is detected",
    )
    prior: Literal["uniform", "kriged", "known"] = Field(
        default="uniform",
        description="of streets in cells that nobody has seen: the same everywhere, foretold from those seen, or known",
    )
    void: Share = Field(default=0.9, description="prior probability that a cell holds no street")
    absent: Share = Field(default=0.5, description="prior probability that there is no target")
    odds: Positive = Field(default=19.0, description="at which a street or a target is detected; 19 is 95 %")
    decay: float = Field(
        default=0.1, gt=0, le=1, description="of `lrdt`: how fast what was seen of a target is forgotten, a second"
    )
    tracks: Literal["one", "restarted", "each"] | None = Field(
        default=None,
        description="of `lrdt`, after a detection: `each` follows the target by a track of its own and searches for "
        "another; `restarted` searches anew, and detects again what is still in view; `one` seeks nobody else. "
        "Left out: `each` where `target.count` is above 1, else `one`",
    )


class Hearing(_Table):
    """`[links]`: what drones hear of one another; given, each plans for itself. Left out, one computer plans for all.

    Over cells and regions they tell each other their plans before they take off, and count only those that they have
    heard. Over waypoints each second they tell each other what they saw; each believes what it has seen or heard, and
    sends again what others may not have heard yet.
    """

    range_m: NotNegative | None = Field(
        default=None,
        description="between drones that hear each other: their starts, or over waypoints where they are then. Left "
        "out: all do",
    )
    loss: float = Field(default=0.0, ge=0, le=1, description="probability that a message in range is lost")
    relays: bool = Field(default=True, description="whether drones pass on what they have heard")
    delay_s: Annotated[int, Field(strict=True, ge=0, le=100_000)] = Field(
        default=0, description="over waypoints: whole seconds from sending to hearing"
    )


class Cutting(_Table):
    """`[regions]`: how ground is cut into regions and how each is flown; only where drones move over regions.

    What is left out follows from the sensor's radius, as in [Kuhlman2017].
    """

    cut: Literal["aware", "plain"] = Field(
        default="aware",
        description="`aware`: at the borders of where there is more to find, too, if it is more here than there; "
        "`plain`: by obstacles alone, as the paper",
    )
    chunk_m: Metres | None = Field(
        default=None,
        description="of cut `aware`: widest region there, wider where there were too many. Left out: 6 radius",
    )
    spacing_m: Metres | None = Field(
        default=None,
        description="between plow lines, at most 2 radius. Left out: the radius; 1.75 radius where time is short",
    )
    min_area_m2: NotNegative | None = Field(
        default=None,
        description="smaller regions are left out before `aware` cuts the others; their ground is seen in passing. "
        "Left out: 4.7 radius^2, and the largest region stays",
    )
    min_width_m: NotNegative | None = Field(default=None, description="narrower ones likewise. Left out: 0.75 radius")
    min_obstacle_m2: NotNegative = Field(default=0.0, description="smaller obstacles do not cut regions in two")
    overlap: float = Field(
        default=0.8, gt=0.5, le=1, description="share of its longer border that a region must keep to go on"
    )
    turns: Literal["stop", "rounded"] = Field(
        default="stop", description="at waypoints: stop, or fly an arc where that is quicker"
    )
    looks: Literal["passes", "actions"] = Field(
        default="passes",
        description="a cell is looked at each time that it comes into view, but for what is in view in passing a "
        "region's middle; or once in each search and flight that sees it, as in the paper",
    )
    ways: Literal["taut", "pruned"] = Field(
        default="taut", description="around obstacles: pulled tight, or as the paper prunes them"
    )


class Settings(_Table):
    """A whole mission file."""

    name: Name = Field(default="", description="what the picture is called, in one line")
    area: Area = Area()
    sensor: Sensor = Sensor()
    searcher: list[Searching] = []
    budget: Budget = Budget()
    objective: Wish = Wish()
    target: TargetSettings | None = None
    estimator: Estimating | None = None
    regions: Cutting | None = None
    links: Hearing | None = None
    wind: WindSettings | None = None
    separation: SeparationSettings | None = None

    @property
    def over_regions(self) -> bool:
        """Whether drones move over regions; all do, or none."""
        return any(searcher.moves == "regions" for searcher in self.searcher)

    @property
    def over_legs(self) -> bool:
        """Whether drones fly straight legs between any places; all do, or none."""
        return any(searcher.moves == "legs" for searcher in self.searcher) and not self.over_regions

    @property
    def over_waypoints(self) -> bool:
        """Whether drones fly to waypoints over unknown streets: all do, or none, and all where there are streets."""
        return self.area.streets is not None or any(searcher.moves == "waypoints" for searcher in self.searcher)

    @property
    def wants_early(self) -> bool:
        """Whether a plan is to be brought forward."""
        timed = self.over_regions or self.over_legs
        if not timed or self.objective.detection_target is not None:
            return False
        return self.objective.kind == "detection" if self.objective.early is None else self.objective.early


# What only a search over waypoints knows, and all that it knows, by table.
_STREET_KEYS: dict[str, set[str]] = {
    "area": {"streets", "window"},
    "sensor": {"map_sensitivity", "target_sensitivity", "levels"},
    "searcher": {"radius_m", "map_sensitivity", "target_sensitivity"},
    "budget": {"replan_s"},
    "objective": set(),
    "links": {"delay_s"},
}
_SHARED_KEYS: dict[str, set[str]] = {
    "area": {"cell_m"},
    "sensor": {"glimpse", "radius_m"},
    "searcher": {"start", "moves", "kind", "speed_mps", "accel_mps2"},
    "budget": {"seconds"},
    "objective": set(),
    "links": {"range_m", "loss", "relays"},
}


def misplaced(settings: Settings, file: str) -> list[Fault]:
    """Faults for keys that mean nothing with the moves that the file gives."""
    flown, faults = settings.over_waypoints, []
    expected = (
        "expected it left out: drones that fly to waypoints search streets"
        if flown
        else ('expected it left out, or searcher.moves = "waypoints"')
    )
    came = "it came, and area.streets" if settings.area.streets is not None else "it came"
    if flown and settings.area.streets is None:
        came = 'it came, and moves = "waypoints"'
    tables: list[tuple[str, str, BaseModel]] = [
        (name, name, getattr(settings, name)) for name in ("area", "sensor", "budget", "objective")
    ]
    if settings.links is not None:
        tables.append(("links", "links", settings.links))
    tables += [(f"searcher[{number}]", "searcher", each) for number, each in enumerate(settings.searcher)]
    for key, name, table in tables:
        own, shared = _STREET_KEYS[name], _SHARED_KEYS[name]
        wrong = table.model_fields_set - own - shared if flown else table.model_fields_set & own
        faults += [Fault(file, f"{key}.{each}", came, expected) for each in type(table).model_fields if each in wrong]
    for name in ("regions", "wind", "separation") if flown else ("target", "estimator"):
        if getattr(settings, name) is not None:
            faults.append(Fault(file, name, came, expected))
    return faults


def not_yet(settings: Settings, file: str) -> list[Fault]:
    """Faults for keys that have their meaning already, but that this version cannot act on."""
    faults = []

    def refuse(key: str, came: str, instead: str) -> None:
        faults.append(Fault(file, key, f"{came} came, which this version does not do yet", instead))

    if settings.separation is not None and not (settings.over_legs or settings.over_waypoints):
        refuse("separation", "how far drones keep apart", 'give moves = "legs", or leave it out')
    if not settings.over_legs:
        if settings.wind is not None:
            refuse("wind", "a wind", 'give moves = "legs", or leave it out: nothing else is slowed by it')
        for key in ("sweep_width_m", "law"):
            if getattr(settings.sensor, key) is not None:
                refuse(f"sensor.{key}", "effort along legs", 'give moves = "legs", or leave it out')
    if not settings.over_regions and not settings.over_legs:
        for key in ("radius_m", "camera", "range_m"):
            if getattr(settings.sensor, key) is not None:
                what = "how far the sensor reaches, over cells,"
                instead = 'give moves = "regions" or "legs", or leave it out: a look covers the cell below'
                refuse(f"sensor.{key}", what, instead)
    over_cells = not settings.over_regions and not settings.over_legs
    if settings.objective.detection_target is not None and len(settings.searcher) > 1 and over_cells:
        instead = 'leave it out: the most by the end, or give moves = "regions"'
        refuse("objective.detection_target", "a target over several searchers over cells", instead)
    if settings.objective.early and not (settings.over_regions or settings.over_legs):
        refuse("objective.early", "an early plan over cells", "leave it out, or give a detection_target")
    for number, searcher in enumerate(settings.searcher):
        timed = settings.over_regions or settings.over_legs
        if not timed and searcher.speed_mps != settings.searcher[0].speed_mps:
            instead = 'give all the same, as all step together, or moves = "regions"'
            refuse(f"searcher[{number}].speed_mps", "another one than searcher[0]'s over cells", instead)
    for number, searcher in enumerate(settings.searcher):
        _refuse_searcher(f"searcher[{number}]", searcher, settings.searcher[0], refuse)
    return faults


def _refuse_searcher(key: str, searcher: Searching, first: Searching, refuse: Callable[[str, str, str], None]) -> None:
    if searcher.moves != "legs":
        if searcher.vehicle is not None:
            refuse(f"{key}.vehicle", "a vehicle file", 'give moves = "legs", or leave it out')
        if searcher.batteries > 1:
            refuse(f"{key}.batteries", f"{searcher.batteries} batteries", 'give moves = "legs", or leave it out')
    if searcher.moves != first.moves:
        refuse(f"{key}.moves", f"'{searcher.moves}' beside '{first.moves}'", "give all the same")
    if searcher.moves == "regions" and searcher.kind == "fixed_wing":
        refuse(f"{key}.kind", "a fixed wing over regions", "give 'copter': it stops where it turns")
    if searcher.moves == first.moves == "cells" and searcher.accel_mps2 is not None:
        refuse(
            f"{key}.accel_mps2",
            "an acceleration over cells",
            'give moves = "regions", or leave it out: steps take cell_m / speed_mps',
        )
