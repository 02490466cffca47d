"""Fixes that cannot be true are dropped, and what is left becomes tracks, cut where nothing is known."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sooner.io.georeference import ground_m
from sooner.io.tracks.fixes import Recorded
from sooner.io.tracks.track import Track

__all__ = ["FASTEST_MPS", "FLIGHT_S", "cleaned", "flights_of"]

FASTEST_MPS = 100.0  # no drone that searches flies faster
ERROR_M = 10.0  # of a fix, so that two of them a moment apart are no jump
FLIGHT_S = 300.0  # without a fix: what follows is another flight
NOWHERE_DEG = 1e-5  # so near to 0, 0 there is no drone, only a receiver without a fix
MOST_JUMPS = 2000
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def cleaned(recorded: Recorded) -> Recorded:
    """The fixes that may be true, with what was dropped told in notes; their longitudes go on over the date line."""
    keep, told = _kept(recorded)
    begins = np.zeros(len(keep), bool)
    begins[list(recorded.begins)] = True
    pieces = np.cumsum(begins)[keep]  # where a segment's first fix is dropped, the segment still begins
    return replace(
        recorded,
        lat=recorded.lat[keep],
        lon=np.unwrap(recorded.lon[keep], period=360.0),
        seconds=recorded.seconds[keep],
        altitude_m=recorded.altitude_m[keep],
        begins=(np.flatnonzero(np.diff(pieces)) + 1).tolist(),
        notes=(*recorded.notes, *told),
    )


def flights_of(recorded: Recorded, source: str, gap_s: float, speed_mps: float | None) -> list[Track]:
    """The tracks that a line of clean fixes holds: long silences part flights.

    Parameters
    ----------
    recorded : Recorded           cleaned, with one fix at least
    source : str                  the file
    gap_s : float                 from fixes so far apart in time nothing is known of what lies between
    speed_mps : float or None     for lines without times: as if flown at that speed
    """
    n = len(recorded.lat)
    begins = np.zeros(n, bool)
    begins[list(recorded.begins)] = True
    if np.isnan(recorded.seconds).all():
        times = _times_at(recorded, speed_mps)
        told = () if times is None else (f"no times in it: told as if flown at {speed_mps:g} m/s",)
        return [_track(recorded, source, slice(None), times, begins[1:], told)]
    silent = np.diff(recorded.seconds)
    ends = [0, *(np.flatnonzero(silent > FLIGHT_S) + 1).tolist(), n]
    found = []
    for first, last in pairwise(ends):
        legs = slice(first, last - 1)
        gaps = begins[1:][legs] | (silent[legs] > gap_s)
        times = recorded.seconds[first:last] - recorded.seconds[first]
        found.append(_track(recorded, source, slice(first, last), times, gaps, _told_gaps(silent[legs][gaps])))
    return found


def _track(
    recorded: Recorded,
    source: str,
    part: slice,
    times_s: NDArray[np.float64] | None,
    gaps: NDArray[np.bool_],
    told: tuple[str, ...],
) -> Track:
    altitude_m = recorded.altitude_m[part]
    return Track(
        recorded.name,
        source,
        recorded.lat[part],
        recorded.lon[part],
        times_s,
        _started(recorded.clock, recorded.seconds[part][0]),
        altitude_m,
        recorded.above if np.isfinite(altitude_m).any() else "",
        np.flatnonzero(gaps).astype(np.int64),
        (*(recorded.notes if not part.start else ()), *told),
    )


def _started(clock: str, seconds: float) -> datetime | None:
    try:
        if not clock or not np.isfinite(seconds):
            return None
        found = _EPOCH + timedelta(seconds=float(seconds))
    except OverflowError:
        return None
    return found if clock == "utc" else found.replace(tzinfo=None)


def _times_at(recorded: Recorded, speed_mps: float | None) -> NDArray[np.float64] | None:
    """When each place is passed at that speed; places that are passed in no time come a millisecond later."""
    if speed_mps is None:
        return None
    legs = np.maximum(ground_m(np.column_stack([recorded.lat, recorded.lon])) / speed_mps, 1e-3)
    return np.concatenate([[0.0], np.cumsum(legs)])


def _told_gaps(seconds: NDArray[np.float64]) -> tuple[str, ...]:
    if seconds.size == 0:
        return ()
    many = "1 gap" if seconds.size == 1 else f"{seconds.size:,} gaps"
    return (f"{many} without fixes, {seconds.sum():.0f} s in all: what lies between counts as not flown",)


# ---------------------------------------------------------------- what cannot be true


def _kept(recorded: Recorded) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """(n,) bool, fixes that may be true, and how many are not and why."""
    told: list[str] = []
    keep = np.ones(len(recorded.lat), bool)

    def drop(wrong: NDArray[np.bool_], why: str) -> None:
        gone = int((wrong & keep).sum())
        if gone:
            told.append(f"{gone:,} of {len(keep):,} fixes dropped: {why}")
            keep[wrong] = False

    drop(~(np.isfinite(recorded.lat) & np.isfinite(recorded.lon)), "no place")
    drop(np.hypot(recorded.lat, recorded.lon) < NOWHERE_DEG, "at latitude 0, longitude 0, where there was no fix")
    if np.isfinite(recorded.seconds[keep]).any():
        drop(~np.isfinite(recorded.seconds), "no time")
        drop(_thinned(keep, _rising(recorded.seconds[keep])), "their times stand still or go back")
        drop(_thinned(keep, _reachable(recorded, keep)), f"farther off than {FASTEST_MPS:g} m/s could be")
    return keep, tuple(told)


def _thinned(keep: NDArray[np.bool_], still: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(n,) bool: those of the kept that are not kept still."""
    gone = np.zeros(len(keep), bool)
    gone[np.flatnonzero(keep)[~still]] = True
    return gone


def _rising(seconds: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(n,) bool: as many fixes as there can be whose times rise, so that one wrong clock does not cost all the others.

    A longest strictly rising subsequence: `tails[k]` is the least end of a rising one of k + 1 fixes so far.
    """
    if (np.diff(seconds) > 0).all():
        return np.ones(len(seconds), bool)
    tails: list[float] = []
    last_of: list[int] = []
    before = np.full(len(seconds), -1, np.int64)
    for fix, time in enumerate(seconds.tolist()):
        length = bisect_left(tails, time)
        before[fix] = last_of[length - 1] if length else -1
        tails[length : length + 1] = [time]
        last_of[length : length + 1] = [fix]
    keep = np.zeros(len(seconds), bool)
    fix = last_of[-1]
    while fix >= 0:
        keep[fix] = True
        fix = int(before[fix])
    return keep


def _reachable(recorded: Recorded, keep: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(n,) bool: as many fixes as there can be that a drone could fly from one to the next.

    Fixes between two jumps stand or fall together: the heaviest chain of such runs, each in reach of the one before.
    """
    places = np.column_stack([recorded.lat[keep], np.unwrap(recorded.lon[keep], period=360.0)])
    seconds = recorded.seconds[keep]
    jumps = np.flatnonzero(ground_m(places) > FASTEST_MPS * np.diff(seconds) + ERROR_M) + 1
    if jumps.size == 0:
        return np.ones(len(seconds), bool)
    if jumps.size > MOST_JUMPS:
        return np.zeros(len(seconds), bool)
    first, last = np.concatenate([[0], jumps]), np.concatenate([jumps, [len(seconds)]])
    weight, before = (last - first).astype(float), np.full(len(first), -1)
    for run in range(1, len(first)):
        pairs = np.stack([places[last[:run] - 1], np.broadcast_to(places[first[run]], (run, 2))], axis=1)
        apart = ground_m(pairs.reshape(-1, 2))[::2]
        within = apart <= FASTEST_MPS * (seconds[first[run]] - seconds[last[:run] - 1]) + ERROR_M
        if within.any():
            best = int(np.argmax(np.where(within, weight[:run], -1.0)))
            weight[run] += weight[best]
            before[run] = best
    still = np.zeros(len(seconds), bool)
    run = int(np.argmax(weight))
    while run >= 0:
        still[first[run] : last[run]] = True
        run = int(before[run])
    return still
