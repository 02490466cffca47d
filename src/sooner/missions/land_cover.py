"""Land cover: what a look detects by the class of ground, forest or meadow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import printable
from sooner.missions.area_layers import Ground, brought
from sooner.missions.drawings import Drafts, is_drawn
from sooner.missions.faults import Faults
from sooner.missions.settings import LandCover, Settings

__all__ = ["ELSE", "check_land_cover", "class_glimpse"]

ELSE = "else"  # the class of ground that has none, or one that is not in the table

Floats = NDArray[np.float64]


def check_land_cover(faults: Faults, settings: Settings) -> None:
    """Classes of ground need a table of what a look detects there, and the table needs them."""
    table, said = settings.sensor.land_cover, settings.area.land_cover
    if table is not None and said is None and not faults.among("area.land_cover"):
        faults.add("area.land_cover", "nothing came beside sensor.land_cover", "expected classes of ground")
    elif said is not None and table is None and not faults.among("sensor.land_cover"):
        expected = "expected P(detect in one look) of each class"
        faults.add("sensor.land_cover", "nothing came beside area.land_cover", expected)


def class_glimpse(faults: Faults, settings: Settings, ground: Ground) -> Floats | None:
    """(H, W) float: P(detect in one look) of each cell, by its class; of polygons, the mean over its ground."""
    table, said = settings.sensor.land_cover, settings.area.land_cover
    if said is None:
        return None
    said = LandCover(file=said) if isinstance(said, str) else said
    if said.file is None:
        faults.add("area.land_cover.file", "nothing came", "expected a GeoTIFF or a vector file")
        return None
    assert table is not None
    if is_drawn(said.file):
        return _of_polygons(faults, table, said, ground)
    return _of_raster(faults, table, said.file, ground)


def _of_raster(faults: Faults, table: Mapping[str, float], name: str, ground: Ground) -> Floats | None:
    from sooner.io.warped import sampled_on

    frame = ground.frame
    found = brought(faults, "area.land_cover", name, lambda path: sampled_on(path, frame.ground, frame.shape))
    if found is None:
        return None
    glimpse = np.full(frame.shape, table.get(ELSE, np.nan))
    classes = {each: value for each, value in table.items() if each != ELSE}
    for each, value in classes.items():
        if not each.lstrip("-").isdigit():
            expected = "expected whole numbers, as the raster has them, or else"
            faults.add("sensor.land_cover", f"class {printable(each)[:40]!r} came", expected)
            return None
        glimpse[found.values == int(each)] = value
    lacking = np.isnan(glimpse) & (ground.inside > 0)
    if lacking.any():
        values, counts = np.unique(found.values[lacking], return_counts=True)
        most = values[int(counts.argmax())]
        told = "no class" if np.isnan(most) else f"class {most:g}"
        came = f"nothing came for {told} of {name}, on {int(counts.max())} cells"
        faults.add("sensor.land_cover", came, "expected P(detect in one look) of each class there, or else")
        return None
    return np.where(np.isnan(glimpse), 0.0, glimpse)


def _of_polygons(faults: Faults, table: Mapping[str, float], said: LandCover, ground: Ground) -> Floats | None:
    from sooner.io.vectors import cover, crossing

    frame, rest = ground.frame, table.get(ELSE)
    summed, covered = np.zeros(frame.shape), np.zeros(frame.shape)
    assert said.file is not None
    for each in Drafts(faults).features("area.land_cover", said.file, said.layer):
        if not each.geometry.geom_type.endswith("Polygon"):
            continue
        if wrong := crossing(each.geometry):
            faults.once("area.land_cover", f"{said.file}: {wrong}", "expected borders that do not cross")
            return None
        glimpse = table.get(_class(each.properties, said.attribute), rest)
        if glimpse is None:
            came = f"nothing came for {said.attribute} = {_class(each.properties, said.attribute)!r} of {said.file}"
            faults.once("sensor.land_cover", came, "expected P(detect in one look) of each class there, or else")
            return None
        share = cover(_whole(frame.moved(each.geometry)), frame.shape, frame.ground.cell_m)
        summed += glimpse * share
        covered += share
    lacking = (covered < ground.inside - 1e-6) if rest is None else np.zeros(frame.shape, bool)
    if lacking.any():
        came = f"{said.file} has no class for {int(lacking.sum())} cells of the area"
        faults.once("sensor.land_cover", came, "expected polygons that cover the area, or else = a number")
        return None
    summed += (rest or 0.0) * np.maximum(1.0 - covered, 0.0)
    return np.clip(summed / np.maximum(covered, 1.0), 0.0, 1.0)


def _class(properties: Mapping[str, Any], attribute: str) -> str:
    found = {str(key).lower(): value for key, value in properties.items()}.get(attribute.lower())
    return str(int(found)) if isinstance(found, float) and found.is_integer() else str(found)


def _whole(geometry: Any) -> Any:
    return geometry if geometry.is_valid else geometry.buffer(0)
