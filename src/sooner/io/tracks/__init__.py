"""Flown tracks as recorders, ground stations and aircraft write them: where it was, when, and where nobody knows."""

from sooner.io.tracks.read import TRACKS, read_tracks
from sooner.io.tracks.track import Track

__all__ = ["TRACKS", "Track", "read_tracks"]
