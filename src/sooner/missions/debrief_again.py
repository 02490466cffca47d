"""Tracks that come again: the same flight in two files, or in two debriefs, has searched but once."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from hashlib import sha256

import numpy as np

from sooner.io.tracks import Track

__all__ = ["digest", "sole"]


def digest(track: Track) -> str:
    """What tells a track from others: its places, and its times where the file tells the day.

    Nobody flies the same line twice to a centimetre and a millisecond. A line without a day is told by its places
    alone: its times may be those of the mission's speed.

    >>> line = np.array([46.0, 46.001]), np.array([9.0, 9.0])
    >>> digest(Track("", "a.gpx", *line)) == digest(Track("Team 4", "b.gpx", *line))
    True
    """
    told = sha256(np.round(track.places * 1e7).astype(np.int64).tobytes())
    if track.started is not None and track.times_s is not None:
        told.update(track.started.isoformat().encode())
        told.update(np.round(track.times_s * 1e3).astype(np.int64).tobytes())
    return told.hexdigest()[:32]


def sole(tracks: Sequence[Track], before: Collection[str]) -> tuple[tuple[Track, ...], tuple[str, ...]]:
    """Each track once, without those counted before; and a note for each that is passed over.

    Parameters
    ----------
    tracks : of Track
    before : of str         digests of tracks that debriefs before this one counted
    """
    first: dict[str, Track] = {}
    notes, counted = [], frozenset(before)
    for track in tracks:
        key = digest(track)
        named = f"{track.source}: a track" + (f" ({track.name})" if track.name else "")
        if key in counted:
            notes.append(f"{named} was counted in a debrief before this one; it is passed over")
        elif key in first:
            notes.append(f"{named} has the places and times of one in {first[key].source}; it is counted once")
        else:
            first[key] = track
    return tuple(first.values()), tuple(notes)
