"""What is drawn in the files that `[area]` names: read once, as shapes with their titles, or as faults of the key."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sooner.errors import DataFormatError, InvalidProblemError, printable
from sooner.missions.faults import Faults
from sooner.missions.settings import Drawing, Drawings, Zones

if TYPE_CHECKING:
    from sooner.io.vectors import Feature

__all__ = ["EXTRACTS", "Drafts", "is_drawn"]

EXTRACTS = (".osm", ".pbf", ".osm.pbf")
_VECTORS = (".geojson", ".json", ".gpkg", ".kml", ".kmz", ".gpx")


def is_drawn(said: Any) -> bool:
    """Whether a key names vector files or extracts, rather than a raster."""
    if isinstance(said, list):
        return any(is_drawn(each) for each in said)
    name = getattr(said, "file", said)
    return not isinstance(said, str) or str(name).lower().endswith((*_VECTORS, *EXTRACTS))


@dataclass(frozen=True, eq=False)
class Draft:
    """A feature, and what the mission file says of it."""

    feature: Feature
    said: Drawing


class Drafts:
    """The vector files of one mission, each read once; what is wrong becomes a fault of the key that named it."""

    def __init__(self, faults: Faults) -> None:
        self.faults = faults
        self._read: dict[tuple[str, str | None], tuple[Feature, ...] | None] = {}

    def features(self, key: str, name: str | None, layer: str | None) -> tuple[Feature, ...]:
        """All of a file's layer; none where it cannot be read."""
        if name is None:
            self.faults.once(f"{key}.file", "nothing came", "expected the name of a vector file")
            return ()
        if (name, layer) not in self._read:
            self._read[name, layer] = self._features(key, name, layer)
        found = self._read[name, layer]
        if found is None:
            self.faults.wrong.add(key)
        return found or ()

    def _features(self, key: str, name: str, layer: str | None) -> tuple[Feature, ...] | None:
        from sooner.io.vectors import read_features
        from sooner.io.vectors.buildings import buildings

        path = self.faults.path.parent / name
        try:
            return buildings(path) if name.lower().endswith(EXTRACTS) else read_features(path, layer)
        except DataFormatError as error:
            for fault in error.faults:
                where = f", {fault.key}" if fault.key else ""
                self.faults.add(key, f"{fault.file}{where}: {fault.came}", fault.expected)
            return None

    def of(self, key: str, said: Drawings | Zones | None) -> list[Draft]:
        """The features that a key names."""
        return [draft for each in _each(said) for draft in self._of(key, each)]

    def _of(self, key: str, said: Drawing) -> Iterator[Draft]:
        found = self.features(key, said.file, said.layer)
        chosen = [each for each in found if said.title is None or each.name == said.title]
        if found and not chosen:
            self.faults.once(key, f"title = {said.title!r} came", f"expected {titles(found)}")
        return (Draft(each, said) for each in chosen)

    def polygons(self, key: str, said: Drawings | None) -> Any | None:
        """The polygons that a key names, joined, in longitude and latitude; None where that is none, or wrong."""
        from sooner.io.vectors import polygons_of

        if said is None or key in self.faults.wrong:
            return None
        drafts = self.of(key, said)
        try:
            found = polygons_of([draft.feature for draft in drafts])
        except InvalidProblemError as error:
            came, expected = str(error), "expected borders that do not cross: draw it again there"
            self.faults.once(key, f"{_names(said)}: {came}", expected)
            return None
        if found.is_empty or not found.area > 0:
            if key not in self.faults.wrong:
                self.faults.once(key, f"{_names(said)} has no polygon", "expected at least one, with an area")
            return None
        return found

    @property
    def points(self) -> dict[str, list[tuple[float, float]]]:
        """Longitude and latitude of the points of every file read so far, by title."""
        found: dict[str, list[tuple[float, float]]] = {}
        for features in self._read.values():
            for each in features or ():
                if each.geometry.geom_type == "Point" and each.name:
                    found.setdefault(each.name, []).append((each.geometry.x, each.geometry.y))
        return found


def titles(features: Sequence[Feature]) -> str:
    """A few of the titles there are, in words."""
    names = sorted({each.name for each in features if each.name})
    told = ", ".join(repr(printable(name[:40])) for name in names[:10])
    return f"one of {told}{' ...' if len(names) > 10 else ''}" if names else "it left out: nothing there has a title"


def _each(said: Drawings | Zones | None) -> list[Drawing]:
    """Those that name files."""
    found = said if isinstance(said, list) else [] if said is None else [said]
    named = [Drawing(file=each) if isinstance(each, str) else each for each in found]
    return [each for each in named if isinstance(each, Drawing)]


def _names(said: Drawings) -> str:
    return ", ".join(str(Path(each.file or "")) for each in _each(said))[:200]
