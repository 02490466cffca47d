"""Fixes as a file holds them, before anybody has looked whether they can be true."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from math import isfinite, nan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault

__all__ = ["MOST_FIXES", "Fixes", "Recorded", "moment", "number", "place", "refusal"]

MOST_FIXES = 2_000_000  # of a file: ten times a second for two days
SAID = 60  # characters of what a file said that are told


@dataclass(frozen=True, eq=False)
class Recorded:
    """One line of fixes, as recorded.

    Parameters
    ----------
    name : str
    lat, lon : (n,) float     degrees; NaN where the file leaves them blank
    seconds : (n,) float      of the file's clock; NaN where it does not say; all NaN where it holds no times
    altitude_m : (n,) float   NaN where it does not say
    above : str               "sea", "home" or ""
    clock : str               "utc" (seconds since 1970), "local" (likewise, of an unknown zone) or ""
    begins : (k,) int         fixes that begin a new segment: from the one before nothing is known
    notes : tuple of str
    """

    name: str
    lat: NDArray[np.float64]
    lon: NDArray[np.float64]
    seconds: NDArray[np.float64]
    altitude_m: NDArray[np.float64]
    above: str = ""
    clock: str = ""
    begins: Sequence[int] = ()
    notes: tuple[str, ...] = ()


@dataclass
class Fixes:
    """Fixes while a file is being read, one by one.

    Parameters
    ----------
    path : Path
    """

    path: Path
    rows: list[tuple[float, float, float, float]] = field(default_factory=list)
    begins: list[int] = field(default_factory=list)

    def add(self, lat: float, lon: float, seconds: float = nan, altitude_m: float = nan) -> None:
        """One more."""
        if len(self.rows) == MOST_FIXES:
            raise refusal(self.path, "", f"more than {MOST_FIXES:,} fixes came", "expected a track of fewer: cut it")
        self.rows.append((lat, lon, seconds, altitude_m))

    def begin(self) -> None:
        """What comes is a new segment."""
        if self.rows:
            self.begins.append(len(self.rows))

    def recorded(self, name: str = "", above: str = "", clock: str = "", notes: tuple[str, ...] = ()) -> Recorded:
        """All of them as arrays."""
        columns = np.array(self.rows, np.float64).reshape(-1, 4).T
        lat, lon, seconds, altitude_m = (np.ascontiguousarray(column) for column in columns)
        begins = [each for each in self.begins if each < len(self.rows)]
        return Recorded(name, lat, lon, seconds, altitude_m, above, clock, begins, notes)


def refusal(path: Path, key: str, came: str, expected: str) -> DataFormatError:
    """A track that cannot be read, and why."""
    return DataFormatError(Fault(str(path), key, came, expected))


def number(path: Path, key: str, said: object, expected: str = "expected a finite number") -> float:
    """What a file says, as a finite number."""
    try:
        found = nan if isinstance(said, bool) else float(said)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        found = nan
    if not isfinite(found) or abs(found) > 1e18:
        raise refusal(path, key, f"{str(said)[:SAID]!r} came", expected)
    return found


def place(path: Path, key: str, lat: object, lon: object) -> tuple[float, float]:
    """A latitude and longitude, as numbers within the globe."""
    north = number(path, key, lat, "expected a latitude in degrees")
    east = number(path, key, lon, "expected a longitude in degrees")
    if not (abs(north) <= 90.0 and abs(east) <= 180.0):
        came = f"latitude {north:g}, longitude {east:g} came"
        raise refusal(path, key, came, "expected degrees north within 90 and degrees east within 180")
    return north, east


def moment(path: Path, key: str, said: str) -> float:
    """Seconds since 1970 of a time as ISO 8601 writes it; without a zone it is UTC.

    >>> moment(Path("a.gpx"), "time", "2024-05-03T12:00:00.5Z")
    1714737600.5
    """
    try:
        found = datetime.fromisoformat(said.strip())
        return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError):
        raise refusal(path, key, f"{said[:SAID]!r} came", "expected a time such as 2024-05-03T12:00:00Z") from None
