"""Debrief: what flown tracks have searched, what they left out, and where the person may be now."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sooner
from sooner.belief import BetaGrid, update_on_miss
from sooner.errors import DataFormatError, Fault, ImpossibleObservationError, UnsupportedProblemError
from sooner.io import Folder
from sooner.io.georeference import Georeference
from sooner.io.geotiff import geotiff
from sooner.io.tracks import Track
from sooner.missions.chances import LAYERS, pod_by_cell
from sooner.missions.debrief_again import digest, sole
from sooner.missions.debrief_looks import Flown, flown
from sooner.missions.debrief_next import MISSION, Searched, next_files
from sooner.missions.debrief_plan import Compared, compared, gaps_geojson
from sooner.missions.flight_plans import check_place
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score

__all__ = ["FILES", "NEXT", "Debrief", "debrief"]

FILES = ("debrief.json", "debrief.png", "pod.tif", "poc-after.tif")
GAPS = "gaps.geojson"
NEXT = "next"
NOTHING_LEFT = 1e-12  # probability on the map below which there is no next mission
MOST_FLIGHTS = 1000
SURE = 1e-12  # probability of not having found the person by then that rounding alone can make
OTHER_HEIGHT = 0.2  # share by which a flight may be higher or lower than its sensor is counted at, untold

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Debrief:
    """Tracks, judged: nobody was found on them.

    Parameters
    ----------
    mission : Mission            as it was before them
    ground : Georeference        of its cells
    tracks : of Flown
    searched : Searched          what flights before these had found
    planned : Score or None      what was to be flown; None where nobody says
    """

    mission: Mission
    ground: Georeference
    tracks: tuple[Flown, ...]
    searched: Searched
    planned: Score | None = None
    notes: tuple[str, ...] = field(default=())

    @cached_property
    def looks(self) -> NDArray[Any]:
        """(N,): how often each cell was looked at; along legs the effort on it."""
        return self._summed()[0]

    @cached_property
    def pod(self) -> Floats:
        """(N,) float: P(these flights detect who is there)."""
        return pod_by_cell(self.mission, self.looks)

    @cached_property
    def found(self) -> float:
        """POS of these flights: sum of POC POD; over evidence the number of targets expected to be found."""
        return self._found(self.pod)

    def _found(self, pod: Floats) -> float:
        return float(np.ravel(self.mission.sight.theta) @ pod)

    @cached_property
    def adds(self) -> list[float]:
        """What each flight adds to those before it in the list: together the POS."""
        return [now - before for before, now in pairwise([0.0, *self._summed()[1]])]

    def _summed(self) -> tuple[NDArray[Any], list[float]]:
        """Looks of all flights, and what they find as one by one is counted in."""
        looks, found = np.zeros_like(self.tracks[0].looks), []
        for each in self.tracks:
            looks[each.cells] += each.worth
            found.append(self._found(pod_by_cell(self.mission, looks)))
        return looks, found

    @cached_property
    def after(self) -> Floats:
        """(H, W) float: the probability of each cell now that nobody was found.

        p'_i = p_i (1 - POD_i) / (1 - POS)                                  [Koopman1956; Stone1975, ch. 1]

        Over evidence every look said no: odds' = odds (1 - POD) / (1 - false_alarm)^looks, cell by cell.

        """
        sight, pod = self.mission.sight, self.pod
        before = np.ravel(sight.theta)
        if self.mission.belief is not None:
            now = update_on_miss(before, pod)
        else:
            there, none = before * (1.0 - pod), (1.0 - before) * (1.0 - sight.false_alarm) ** self.looks
            both = there + none
            now = np.divide(there, both, out=before.copy(), where=both > 0)
        return np.asarray(now.reshape(self.mission.problem.grid.shape))

    @property
    def outside(self) -> float:
        """Probability that the person is not on the map, now."""
        belief = self.mission.belief
        return 0.0 if belief is None else min(belief.outside / (1.0 - self.found), 1.0)

    @property
    def so_far(self) -> Searched:
        """With all flights before: POS adds up."""
        found = self.found if self.mission.belief is not None else 0.0
        return self.searched.and_then(found, len(self.tracks), tuple(digest(each.track) for each in self.tracks))

    @cached_property
    def compared(self) -> Compared | None:
        """Flown beside planned; None where nobody says what was planned."""
        if self.planned is None:
            return None
        return compared(self.planned, self.ground, self.tracks, self.pod, self.after.ravel())

    @property
    def remaining(self) -> dict[str, float] | None:
        """Where the person is if nobody was found, as probabilities before the flights; None over evidence."""
        belief = self.mission.belief
        if belief is None:
            return None
        never = float(belief.poc.ravel()[self.pod == 0].sum())
        missed = max(0.0, 1.0 - belief.outside - never - self.found)
        return {"never_looked": never, "looked_but_missed": missed, "outside": belief.outside}

    @property
    def searchable(self) -> bool:
        """Whether anything is left on the map to search for."""
        return bool(self.after.sum() > NOTHING_LEFT and self.outside < 1.0)

    # ------------------------------------------------------------ told

    def result(self) -> dict[str, Any]:
        """One JSON object; numbers that do not exist are null."""
        mission, probability = self.mission, self.mission.belief is not None
        told = {
            "mission": mission.name,
            "unit": "probability" if probability else "targets",
            "found": self.found,
            "so_far": None,
            "remaining": self.remaining,
            "outside_after": self.outside if probability else None,
            "cells_looked_at": int((self.pod > 0).sum()),
            "area_looked_at_m2": float((self.pod > 0).sum()) * mission.problem.grid.cell_m**2,
            "tracks": [_told(each, adds) for each, adds in zip(self.tracks, self.adds, strict=True)],
            "plan": None if self.compared is None else self.compared.result(self.after.ravel()),
            "notes": list(self.notes),
            "version": sooner.__version__,
        }
        if probability:
            told["so_far"] = {"before": self.searched.pos, "found": self.so_far.pos, "flights": self.so_far.flights}
        return told

    def write(self, folder: Folder) -> dict[str, Any]:
        """Write result, maps, picture and the next mission, all or none; returns the result."""
        from sooner.missions.debrief_picture import debrief_picture

        shape, files = self.mission.problem.grid.shape, {}
        remains = np.ravel(self.mission.sight.theta) * (1.0 - self.pod)
        files["pod.tif"] = geotiff(self.pod.reshape(shape), self.ground, LAYERS["pod"])
        files["poc-after.tif"] = geotiff(remains.reshape(shape), self.ground, LAYERS["poc-after"])
        files["debrief.png"] = debrief_picture(self)
        if self.compared is not None:
            files[GAPS] = gaps_geojson(self.compared.gaps)
        further, result = Folder(folder.path / NEXT, folder.force), self.result()
        result["next"] = None
        following: dict[str, bytes] = {}
        if self.searchable:
            following, told = next_files(self.mission, self.ground, self.after, self.outside, self.so_far, further.path)
            result["next"] = str(further.path / MISSION)
            result["notes"] += told
        else:
            result["notes"].append("nothing is left on this map: there is no next mission")
        files["debrief.json"] = (json.dumps(result, allow_nan=False) + "\n").encode()
        result["files"] = [str(folder.path / name) for name in files] + [str(further.path / name) for name in following]
        folder.check(*files)
        further.check(*following)
        folder.write(files)
        if following:
            further.write(following)
        return result


def _told(each: Flown, adds: float) -> dict[str, Any]:
    track = each.track
    return {
        "file": track.source,
        "name": track.name,
        "started": None if track.started is None else track.started.isoformat(),
        "duration_s": track.duration_s,
        "length_m": each.length_m,
        "fixes": len(track.lat),
        "gaps": len(track.gaps),
        "adds": adds,
        "notes": list(track.notes),
    }


def debrief(mission: Mission, tracks: Sequence[Track], plan: Score | None = None) -> Debrief:
    """What tracks have searched of a mission on which nobody was found; one that comes again is counted once.

    Parameters
    ----------
    mission : Mission         with its place on the globe
    tracks : of Track         at least one
    plan : Score or None      what was to be flown, judged: gaps are told where it stands

    Raises
    ------
    DataFormatError           if the mission has no place on the globe, no track looks at anything of it, or
                              all of them were counted before
    UnsupportedProblemError   where targets come and go, and nobody is found
    ImpossibleObservationError  if the person would have been found for sure
    """
    if isinstance(mission.sight.known, BetaGrid):
        raise UnsupportedProblemError('model = "beta" came, where nobody is found; a debrief expects looks that detect')
    ground, searched = check_place(mission), Searched.before(mission)
    if len(tracks) > MOST_FLIGHTS:
        came, expected = f"{len(tracks):,} flights came", f"expected at most {MOST_FLIGHTS:,} in one debrief"
        raise DataFormatError(Fault(tracks[0].source, "", came, expected))
    kept, again = sole(tracks, searched.tracks)
    if tracks and not kept:
        files = ", ".join(dict.fromkeys(track.source for track in tracks))
        came = "no track came but those that debriefs before this one counted"
        expected = f"expected a flight that {mission.path} does not know of yet"
        raise DataFormatError(Fault(files, "", came, expected))
    found = tuple(flown(mission, ground, track) for track in kept)
    judged = Debrief(mission, ground, found, searched, plan, (*again, *_notes(mission, found)))
    if not found or not judged.pod.any():
        lat, lon = ground.places([[(side - 1) / 2 for side in mission.problem.grid.shape]])[0]
        files = ", ".join(dict.fromkeys(each.track.source for each in found))
        came = "tracks came that look at nothing of this map" if found else "no track came"
        expected = f"expected a flight over {mission.path}, whose middle lies at {lat:.5f}, {lon:.5f}"
        raise DataFormatError(Fault(files or str(mission.path), "", came, expected))
    if mission.belief is not None and 1.0 - judged.found < SURE:
        came = "flights came that would have found the person for sure, and nobody was found"
        expected = "expected area.outside above 0, or a sensor that may miss: one of them cannot be true"
        raise ImpossibleObservationError(f"{came}; {expected}")
    return judged


def _notes(mission: Mission, tracks: Sequence[Flown]) -> tuple[str, ...]:
    """What the user should know of the tracks, each with its name."""
    notes: list[str] = []
    for number, each in enumerate(tracks):
        track, told = each.track, list(each.track.notes)
        if len(each.cells) == 0:
            told.append("it looks at nothing of this map")
        told += _at_another_height(mission, track)
        named = f"flight {number}" + (f" ({track.name})" if track.name else "")
        notes += [f"{named}: {note}" for note in told]
    return tuple(notes)


def _at_another_height(mission: Mission, track: Track) -> list[str]:
    """A flight whose height is not the one that the sensor is counted at."""
    camera = mission.settings.sensor.camera
    heights = {each.altitude_m for each in mission.settings.searcher} | {None if camera is None else camera.altitude_m}
    planned = sorted(height for height in heights if height is not None)
    if track.above != "home" or not planned:
        return []
    flew = float(np.nanmedian(track.altitude_m))
    if any(abs(flew - height) <= OTHER_HEIGHT * height for height in planned):
        return []
    return [f"it flew {flew:.0f} m above home half of the time; looks are counted as at {planned[0]:g} m"]
