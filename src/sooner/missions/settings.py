"""What a mission file may say, key by key; `docs/mission_file.md` is checked against this."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from sooner.errors import Fault

__all__ = ["MAX_STEPS", "Area", "Budget", "Place", "Searching", "Sensor", "Settings", "Wish", "not_yet"]

Cell = Annotated[list[Annotated[int, Field(strict=True)]], Field(min_length=2, max_length=2)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Metres = Annotated[float, Field(ge=0.001, le=1_000_000, allow_inf_nan=False)]
Speed = Annotated[float, Field(ge=0.001, le=1_000, allow_inf_nan=False)]

MAX_STEPS = 200_000


class _Table(BaseModel):
    # every key has a default, so that a file with faults still shows what else is wrong with it
    model_config = ConfigDict(extra="forbid", frozen=True)


class Place(_Table):
    """A place by its coordinates."""

    lat: float = Field(default=0.0, ge=-90, le=90, description="degrees north")
    lon: float = Field(default=0.0, ge=-180, le=180, description="degrees east")


class Area(_Table):
    """`[area]`: where the person may be."""

    poc: str | None = Field(
        default=None, description="raster of weights, at least 0; normalised; row 0 is north (required)"
    )
    outside: float = Field(
        default=0.0, ge=0, lt=1, strict=True, description="probability that the person is not on this map"
    )
    evidence: str | None = Field(
        default=None, description="instead of `poc`: independent probability per cell (not yet)"
    )
    cell_m: Metres | None = Field(
        default=None, description="metres between cell centres, where the raster has no georeference"
    )
    obstacles: str | None = Field(default=None, description="raster; non-zero cells cannot be entered")
    grid: Literal["square4", "square8", "hex"] = Field(
        default="square4",
        description="neighbours of a cell: 4, 8 (none past an obstacle's corner), or 6 (odd rows half a cell east)",
    )


class Sensor(_Table):
    """`[sensor]`: what one look detects; left out: every look detects."""

    difficulty: str | None = Field(
        default=None, description="raster of levels d, at least 0; glimpse = 1 - d / (d_max + 1)"
    )
    glimpse: float | str | None = Field(
        default=None, description="P(detect in one look, if there): a number or a raster in [0, 1]"
    )
    correlation: float = Field(
        default=0.0, ge=0, le=1, description="of two looks at one place; 0: independent, 1: a second look adds nothing"
    )
    detect: float | None = Field(default=None, ge=0, le=1, description="an evidence-grid sensor's hit rate (not yet)")
    false_alarm: float | None = Field(
        default=None, ge=0, le=1, description="an evidence-grid sensor's false alarms (not yet)"
    )
    radius_m: Positive | None = Field(
        default=None, description="what one look covers; left out: the cell below (not yet)"
    )


class Searching(_Table):
    """`[[searcher]]`: a drone."""

    start: Cell | Place | None = Field(
        default=None, description="[row, col] where it starts (required); lat and lon: not yet"
    )
    end: Cell | Place | None = Field(
        default=None, description="[row, col] where it must be at the end; lat and lon: not yet"
    )
    moves: Literal["cells", "regions", "waypoints"] = Field(default="cells", description="`cells` (others not yet)")
    kind: Literal["copter", "fixed_wing"] = Field(
        default="copter", description="a copter may hover; a fixed wing neither hovers nor turns straight back"
    )
    speed_mps: Speed | None = Field(
        default=None, description="metres a second, the same for all; turns steps into seconds"
    )
    accel_mps2: Positive | None = Field(default=None, description="metres a second squared (not yet)")


class Budget(_Table):
    """`[budget]`: how long the search lasts; one of the two."""

    steps: Annotated[int, Field(strict=True, ge=1, le=MAX_STEPS)] | None = Field(
        default=None, description="moves from cell to cell, at least 1"
    )
    seconds: Positive | None = Field(default=None, description="flying time; needs `cell_m` and `speed_mps`")


class Wish(_Table):
    """`[objective]`: what is good."""

    kind: Literal["detection", "information"] = Field(
        default="detection", description="`detection` (`information`: not yet)"
    )
    detection_target: float | None = Field(default=None, gt=0, le=1, description="reach this CDP as soon as possible")


class Settings(_Table):
    """A whole mission file."""

    name: str = Field(default="", description="what the picture is called")
    area: Area = Area()
    sensor: Sensor = Sensor()
    searcher: list[Searching] = []
    budget: Budget = Budget()
    objective: Wish = Wish()


def not_yet(settings: Settings, file: str) -> list[Fault]:
    """Faults for keys that have their meaning already, but that this version cannot act on."""
    faults = []

    def refuse(key: str, came: str, instead: str) -> None:
        faults.append(Fault(file, key, f"{came} came, which this version does not do yet", instead))

    if settings.area.evidence is not None:
        refuse("area.evidence", "an evidence grid", "give area.poc")
    for key in ("detect", "false_alarm", "radius_m"):
        if getattr(settings.sensor, key) is not None:
            what = "a footprint of several cells" if key == "radius_m" else "an evidence-grid sensor"
            refuse(f"sensor.{key}", what, "give sensor.difficulty or sensor.glimpse; a look covers the cell below")
    if settings.objective.kind == "information":
        refuse("objective.kind", "'information'", "give 'detection'")
    if len(settings.searcher) > 1 and settings.objective.detection_target is not None:
        refuse("objective.detection_target", "a target for several searchers", "give one searcher, or no target")
    speeds = [searcher.speed_mps for searcher in settings.searcher]
    for number, speed in enumerate(speeds):
        if speed != speeds[0]:
            refuse(f"searcher[{number}].speed_mps", "another speed than searcher[0]'s", "give all the same")
    for number, searcher in enumerate(settings.searcher):
        key = f"searcher[{number}]"
        if searcher.moves != "cells":
            refuse(f"{key}.moves", f"'{searcher.moves}'", "give 'cells'")
        if searcher.accel_mps2 is not None:
            refuse(f"{key}.accel_mps2", "an acceleration", "leave it out: steps take cell_m / speed_mps")
        for name in ("start", "end"):
            if isinstance(getattr(searcher, name), Place):
                refuse(f"{key}.{name}", "a latitude and longitude", "give [row, col]")
    return faults
