"""The next mission: the same file, but for where the person may be now, and what has been searched so far."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault
from sooner.io.georeference import Georeference
from sooner.io.geotiff import geotiff
from sooner.io.reading import bytes_of, read_toml, text_of
from sooner.missions.debrief_ground import next_ground, tags_of
from sooner.missions.mission_file import Mission

__all__ = ["MISSION", "SEARCHED", "Searched", "next_files"]

MISSION, SEARCHED = "mission.toml", "searched.json"
PRIORS = ("poc", "evidence", "segments", "last_known")  # keys of [area] that say where the person may be
MOST_BYTES = 64_000_000
LONGEST = 64  # of a digest
_EXPECTED = "expected what `sooner debrief` wrote there"


@dataclass(frozen=True)
class Searched:
    """What was searched before a mission, as the debrief that wrote the mission kept it.

    Parameters
    ----------
    name : str          of the first mission
    pos : float         probability of having found the person by then
    flights : int
    tracks : of str     digests of those flights' tracks
    """

    name: str
    pos: float = 0.0
    flights: int = 0
    tracks: tuple[str, ...] = field(default=(), repr=False)

    @classmethod
    def before(cls, mission: Mission) -> Searched:
        """What stands beside a mission file; nothing where it is the first, or another mission's.

        Raises
        ------
        DataFormatError     where it is not what a debrief writes
        """
        path = mission.path.parent / SEARCHED
        if not path.exists():
            return cls(mission.name)
        try:
            said = json.loads(text_of(path, bytes_of(path, MOST_BYTES, "64 MB", _EXPECTED), _EXPECTED))
            if said["mission"] != mission.path.name:
                return cls(mission.name)
            tracks = said.get("tracks", [])
            if not (
                isinstance(tracks, list) and all(isinstance(each, str) and len(each) <= LONGEST for each in tracks)
            ):
                raise ValueError(tracks)
            found = cls(str(said["name"]), float(said["pos"]), int(said["flights"]), tuple(tracks))
            if not (0.0 <= found.pos < 1.0 and 0 <= found.flights < 1_000_000):
                raise ValueError(said)
        except (ValueError, KeyError, TypeError, RecursionError, OverflowError) as error:
            if isinstance(error, DataFormatError):
                raise
            raise DataFormatError(Fault(str(path), "", "it cannot be understood", _EXPECTED)) from None
        return found

    def and_then(self, pos: float, flights: int, tracks: tuple[str, ...] = ()) -> Searched:
        """After more flights, which found the person with this probability if nobody had before.

        POS = POS_1 + (1 - POS_1) POS_2

        >>> Searched("Ridge", 0.5, 1).and_then(0.2, 2)
        Searched(name='Ridge', pos=0.6, flights=3)
        """
        pos = self.pos + (1.0 - self.pos) * pos
        return Searched(self.name, pos, self.flights + flights, (*self.tracks, *tracks))


def next_files(
    mission: Mission,
    ground: Georeference,
    after: NDArray[np.float64],
    outside: float,
    searched: Searched,
    folder: Path,
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """The files of the next mission, and what the user should know of it.

    Parameters
    ----------
    mission : Mission         the one that was flown
    ground : Georeference     of its cells
    after : (H, W) float      probability of each cell now
    outside : float           likewise of not being on the map
    searched : Searched       with this mission's flights
    folder : Path             where the files will stand: other files are named as seen from there
    """
    said = _moved(read_toml(mission.path, "expected a mission file in TOML"), mission.path.parent, folder)
    area, over_evidence, notes = said["area"], mission.belief is None, []
    key = "evidence" if over_evidence else "poc"
    said["area"] = {key: f"{key}.tif"} | {name: value for name, value in area.items() if name not in PRIORS}
    if not over_evidence:
        said["area"]["outside"] = outside
    said["name"] = f"{searched.name}, after {searched.flights} flight{'s' * (searched.flights != 1)}"
    target = mission.settings.objective.detection_target
    if target is not None and target > 1.0 - outside:
        del said["objective"]["detection_target"]
        notes.append(f"a CDP of {target:g} cannot be reached any more: the next mission asks for the most by the end")
    kept = {"mission": MISSION, "name": searched.name, "pos": searched.pos, "flights": searched.flights}
    kept["tracks"] = list(searched.tracks)
    about = "probability that the person is there, after the flights so far"
    files = next_ground(mission, ground, said)
    files |= {
        MISSION: toml(said),
        f"{key}.tif": geotiff(after, ground, about, tags_of(mission)),
        SEARCHED: (json.dumps(kept, allow_nan=False) + "\n").encode(),
    }
    return files, tuple(notes)


def _moved(said: Any, here: Path, there: Path) -> Any:
    """The same, with every file that it names as seen from another folder."""
    if isinstance(said, dict):
        return {key: deepcopy(value) if key == "name" else _moved(value, here, there) for key, value in said.items()}
    if isinstance(said, list):
        return [_moved(each, here, there) for each in said]
    if isinstance(said, str) and Path(said).suffix and "\0" not in said and (here / said).is_file():
        place = (here / said).resolve()
        try:
            return Path(os.path.relpath(place, there.resolve())).as_posix()
        except ValueError:  # another drive
            return place.as_posix()
    return said


# ---------------------------------------------------------------- TOML


def toml(said: Mapping[str, Any]) -> bytes:
    """What a mission file says, as TOML: plain keys first, then tables, and those that come several times.

    >>> print(toml({"name": "Ridge", "area": {"poc": "a.tif"}, "searcher": [{"start": [1, 2]}]}).decode(), end="")
    name = "Ridge"
    <BLANKLINE>
    [area]
    poc = "a.tif"
    <BLANKLINE>
    [[searcher]]
    start = [1, 2]
    """
    lines = [f"{_key(key)} = {_value(value)}" for key, value in said.items() if not _is_tables(value)]
    for key, value in said.items():
        if _is_tables(value):
            several = isinstance(value, list)
            for table in value if several else [value]:
                head = f"[[{_key(key)}]]" if several else f"[{_key(key)}]"
                lines += ["", head, *(f"{_key(inner)} = {_value(each)}" for inner, each in table.items())]
    return ("\n".join(lines) + "\n").encode()


def _is_tables(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _key(key: str) -> str:
    return key if key and all(each.isascii() and (each.isalnum() or each in "-_") for each in key) else _value(key)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
