"""A feature: a thing drawn on a map, with its name; and what is checked of every one, whatever file it came from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault

__all__ = ["MOST_FEATURES", "MOST_VERTICES", "Drawn", "Feature", "checked", "refusal"]

MOST_VERTICES = 100_000  # of one feature
MOST_VERTICES_IN_ALL = 1_000_000
MOST_FEATURES = 100_000
FARTHEST_NORTH = 89.9  # degrees: nearer to a pole no map of ours is true
SIMPLER = "simplify it (QGIS: Vector, Geometry Tools, Simplify, 1 m) or cut it to the search area"


@dataclass(frozen=True, eq=False)
class Feature:
    """A thing drawn on a map.

    Parameters
    ----------
    name : str                      its title, "" where it has none
    kind : str                      CalTopo's class, or waypoint, route or track of GPX; "" where nobody says
    geometry : shapely geometry     longitude and latitude, degrees of WGS 84; points, lines, polygons, or many of one
    properties : mapping            what else the file says of it
    """

    name: str
    kind: str
    geometry: Any
    properties: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Drawn:
    """A feature as a file's reader leaves it: not yet checked, coordinates as in the file."""

    key: str
    name: str
    kind: str
    geometry: Any
    properties: Mapping[str, Any]


def refusal(path: Path, key: str, came: str, expected: str) -> DataFormatError:
    """The error for one fault of a vector file."""
    return DataFormatError(Fault(str(path), key, came, expected))


def checked(path: Path, drawn: Sequence[Drawn]) -> tuple[Feature, ...]:
    """Features in longitude and latitude, if these are such.

    Raises
    ------
    DataFormatError         none, too many, too many vertices, coordinates beyond the globe, near a pole, or across the
                            date line
    """
    if not drawn:
        raise refusal(path, "", "a file without any shape or point came", "expected at least one")
    if len(drawn) > MOST_FEATURES:
        expected = f"expected at most {MOST_FEATURES:,}: cut the file to the search area"
        raise refusal(path, "", f"{len(drawn):,} features came", expected)
    geometries = np.array([each.geometry for each in drawn], dtype=object)
    counts = shapely.get_num_coordinates(geometries)
    if counts.max() > MOST_VERTICES:
        each = drawn[int(counts.argmax())]
        raise refusal(
            path, each.key, f"{counts.max():,} vertices came", f"expected at most {MOST_VERTICES:,}: {SIMPLER}"
        )
    if counts.sum() > MOST_VERTICES_IN_ALL:
        expected = f"expected at most {MOST_VERTICES_IN_ALL:,} in one file: {SIMPLER}"
        raise refusal(path, "", f"{counts.sum():,} vertices came", expected)
    places, whose = shapely.get_coordinates(geometries, return_index=True)
    _check_places(path, drawn, places, whose)
    _check_date_line(path, drawn, shapely.bounds(geometries))
    return tuple(Feature(each.name, each.kind, each.geometry, each.properties) for each in drawn)


def _check_places(path: Path, drawn: Sequence[Drawn], places: NDArray[np.float64], whose: NDArray[np.int64]) -> None:
    lon, lat = places.T
    wrong = (
        (~np.isfinite(places).all(axis=1), "expected finite numbers"),
        ((np.abs(lon) > 180.0) | (np.abs(lat) > 90.0), "expected longitude from -180 to 180, then latitude to 90"),
        (np.abs(lat) > FARTHEST_NORTH, f"expected latitudes from -{FARTHEST_NORTH} to {FARTHEST_NORTH}"),
    )
    for bad, expected in wrong:
        if bad.any():
            first = int(np.argmax(bad))
            came = f"longitude {lon[first]:g}, latitude {lat[first]:g} came"
            raise refusal(path, drawn[int(whose[first])].key, came, expected)


def _check_date_line(path: Path, drawn: Sequence[Drawn], bounds: NDArray[np.float64]) -> None:
    wide = bounds[:, 2] - bounds[:, 0] > 180.0
    if wide.any():
        first = int(np.argmax(wide))
        came = f"a shape from longitude {bounds[first, 0]:g} to {bounds[first, 2]:g} came"
        expected = "expected one that does not cross the date line: draw each side by itself"
        raise refusal(path, drawn[first].key, came, expected)
