"""Tracks: fixes in order of time, and the gaps between which nothing is known."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from sooner.errors import InvalidProblemError
from sooner.io.georeference import ground_m

__all__ = ["Track"]

_NONE = np.empty(0, np.int64)


@dataclass(frozen=True, eq=False)
class Track:
    """Where one aircraft was in one flight.

    Parameters
    ----------
    name : str                     what the file calls it; "" where it does not say
    source : str                   the file
    lat, lon : (n,) float          degrees north and east, of WGS 84; longitudes go on over the date line
    times_s : (n,) float or None   from the first fix, rising; None where the file holds no times
    started : datetime or None     of the first fix: in UTC, or without a zone where the file tells local time
    altitude_m : (n,) float        NaN where nobody knows
    above : str                    what altitudes count from: "sea", "home", or "" where nobody knows
    gaps : (k,) int                fixes from which to the next nothing is known
    notes : tuple of str           what was dropped, and what was taken for granted

    Raises
    ------
    InvalidProblemError            if lengths differ, a number is none, or times do not rise

    Examples
    --------
    >>> lat, lon, times_s = np.array([[46.0, 46.001, 46.001], [9.0, 9.0, 9.001], [0.0, 10.0, 60.0]])
    >>> track = Track("", "", lat, lon, times_s, gaps=np.array([1]))
    >>> [piece.tolist() for piece in track.pieces]
    [[[46.0, 9.0], [46.001, 9.0]], [[46.001, 9.001]]]
    >>> round(track.length_m, 1), track.duration_s
    (111.2, 60.0)
    """

    name: str
    source: str
    lat: NDArray[np.float64]
    lon: NDArray[np.float64]
    times_s: NDArray[np.float64] | None = None
    started: datetime | None = None
    altitude_m: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    above: str = ""
    gaps: NDArray[np.int64] = field(default_factory=lambda: _NONE)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.lat)
        if n == 0 or self.lat.shape != (n,) or self.lon.shape != (n,):
            raise InvalidProblemError(
                f"{n} latitudes and {len(self.lon)} longitudes came; expected as many, at least 1"
            )
        if not (np.isfinite(self.lat).all() and np.isfinite(self.lon).all()):
            raise InvalidProblemError("a place that is no number came; expected degrees north and east")
        if self.times_s is not None and (self.times_s.shape != (n,) or not (np.diff(self.times_s) > 0).all()):
            raise InvalidProblemError("times came that do not rise from fix to fix; expected one for each, rising")
        if self.altitude_m.size == 0:
            object.__setattr__(self, "altitude_m", np.full(n, np.nan))

    @property
    def places(self) -> NDArray[np.float64]:
        """(n, 2) float: latitude and longitude of every fix."""
        return np.column_stack([self.lat, self.lon])

    @property
    def pieces(self) -> list[NDArray[np.float64]]:
        """(m, 2) float each: the places from gap to gap; within a piece it flew straight from fix to fix."""
        return np.split(self.places, self.gaps + 1)

    @property
    def length_m(self) -> float:
        """Metres over ground, without what lies in gaps."""
        return float(sum(ground_m(piece).sum() for piece in self.pieces))

    @property
    def duration_s(self) -> float | None:
        """Seconds from the first fix to the last; None where the file holds no times."""
        return None if self.times_s is None else float(self.times_s[-1])
