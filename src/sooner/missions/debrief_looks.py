"""What flown tracks looked at: their lines in metres of the mission, looks or effort by cell, and what that detects."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import radians
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.errors import DataFormatError, Fault, InvalidProblemError
from sooner.grid import Grid, rows_and_cols
from sooner.io.georeference import Georeference
from sooner.io.tracks import Track
from sooner.missions.mission_file import Mission
from sooner.problem.leg_moves import LegMoves
from sooner.sensors.camera import Camera
from sooner.sensors.footprint import cell_passes

__all__ = ["Flown", "crossed_cells", "flown", "reach_m"]

JITTER_M = 2.0  # by which receivers err from fix to fix: lines are straightened by as much
FINE = 0.1  # of how far looks reach: lines are straightened by no more
LEAST = 0.25  # of a cell's side, flown within it, to be a look: a corner that is clipped is none
BLOCK = 1000  # fixes straightened at once, so that no line takes longer than it is long
MOST_PARTS = 50_000_000

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Flown:
    """A track over the mission's map.

    Parameters
    ----------
    track : Track
    pieces : of (n, 2) float    metres east and north of the south-west cell's centre, between gaps, straightened
    cells : (m,) int            that it looked at, each once
    worth : (m,)                how often; along legs the effort on it
    n_cells : int               of the map, N
    """

    track: Track
    pieces: tuple[Floats, ...]
    cells: NDArray[np.int64]
    worth: NDArray[Any]
    n_cells: int

    @property
    def looks(self) -> NDArray[Any]:
        """(N,): how often each cell was looked at; along legs the effort on it."""
        found = np.zeros(self.n_cells, self.worth.dtype)
        found[self.cells] = self.worth
        return found

    @property
    def length_m(self) -> float:
        """Of its pieces, metres of the map."""
        return float(sum(np.hypot(*np.diff(piece, axis=0).T).sum() for piece in self.pieces))


def flown(mission: Mission, ground: Georeference, track: Track) -> Flown:
    """A track as the mission's judge sees it: looks by the same sensor, counted as the mission's plans count them.

    - along legs: the effort of the swath swept along the line, which adds up by the metre
    - over regions: a look each time that a cell comes within the sensor's radius of the line
    - over cells: a look each time that the line crosses a cell's ground, by a quarter of its side at least

    Fixes are joined by straight lines. The line is straightened by up to two metres (a tenth of how far looks reach,
    where that is less), so that a receiver's jitter is no flight. Over regions and cells a piece between gaps that is
    shorter than half of that reach is none: who stands there, with gaps in the log, would look again and again.

    Raises
    ------
    DataFormatError         where the projection does not reach the track, or it is too long for so fine a map
    """
    grid, reach = mission.problem.grid, reach_m(mission)
    try:
        cells = ground.cells(track.places)
    except InvalidProblemError as error:
        raise DataFormatError(Fault(track.source, "", str(error), "expected a track over the mission's map")) from None
    height = grid.shape[0]
    line = np.column_stack([cells[:, 1], height - 1 - cells[:, 0]]) * grid.cell_m
    parts = np.split(line, track.gaps + 1)
    pieces = tuple(_straightened(part, min(JITTER_M, FINE * reach)) for part in parts)
    looks = _looks(mission, track, pieces, reach)
    seen = np.flatnonzero(looks)
    return Flown(track, pieces, seen, looks[seen], grid.n_cells)


def reach_m(mission: Mission) -> float:
    """How far looks reach: the sensor's radius; over cells a cell's side."""
    moves = mission.problem.searchers[0].moves
    if isinstance(moves, LegMoves):
        return moves.swath.radius_m
    if not mission.over_regions:
        return mission.problem.grid.cell_m
    sensor = mission.settings.sensor
    if sensor.radius_m is not None:
        return sensor.radius_m
    said = sensor.camera
    assert said is not None
    assert None not in (said.fov_deg, said.pixels, said.exposure_s, said.altitude_m)
    camera = Camera(radians(said.fov_deg or 0.0), said.pixels or 0, said.exposure_s or 0.0)
    return float(camera.footprint_radius(said.altitude_m or 0.0))


# ---------------------------------------------------------------- looks


def _looks(mission: Mission, track: Track, pieces: Iterable[Floats], reach: float) -> NDArray[Any]:
    grid, moves = mission.problem.grid, mission.problem.searchers[0].moves
    if isinstance(moves, LegMoves):
        effort = np.zeros(grid.n_cells)
        for piece in pieces:
            cells, worth, _ = moves.swath.effort(grid, piece)
            effort += np.bincount(cells, worth, minlength=grid.n_cells)
        return effort
    looks = np.zeros(grid.n_cells, np.int64)
    for piece in pieces:
        if np.hypot(*np.diff(piece, axis=0).T).sum() < reach / 2:
            continue
        if mission.over_regions:
            cells, _, _ = cell_passes(grid, piece, reach)
        else:
            cells = crossed_cells(grid, piece, track.source)
        looks += np.bincount(cells, minlength=grid.n_cells)
    looks[~grid.passable] = 0
    return looks


def crossed_cells(grid: Grid, line: Floats, source: str = "") -> NDArray[np.int64]:
    """Cells whose ground a polyline crosses, each as often as it does, in order.

    Parameters
    ----------
    grid : Grid             of squares
    line : (n, 2) float     metres in the frame of `Grid.centres_m`

    Examples
    --------
    >>> crossed_cells(Grid((1, 4)), np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 0.0]]))
    array([0, 1, 2, 1, 0])
    """
    places = rows_and_cols(grid, line) + 0.5  # cell (r, c) is the square from (r, c) to (r + 1, c + 1)
    begins, ends = _within(places[:-1], places[1:], grid.shape)
    if len(begins) == 0:
        return np.zeros(0, np.int64)
    legs, shares = _parted(begins, ends, source)
    middles = begins[legs[:-1]] + ((shares[1:] + shares[:-1]) / 2)[:, None] * (ends - begins)[legs[:-1]]
    lengths = np.diff(shares) * np.hypot(*(ends - begins).T)[legs[:-1]]
    within = legs[1:] == legs[:-1]
    middles, lengths = middles[within], lengths[within]
    rows, cols = np.floor(middles).astype(np.int64).T
    inside = (rows >= 0) & (rows < grid.shape[0]) & (cols >= 0) & (cols < grid.shape[1])
    cells = np.where(inside, rows * grid.shape[1] + cols, -1)
    first = np.flatnonzero(np.append(True, cells[1:] != cells[:-1]))
    long_enough = np.add.reduceat(lengths, first) >= LEAST
    visits = cells[first][long_enough]
    visits = visits[np.append(True, visits[1:] != visits[:-1])] if len(visits) else visits  # a clipped corner between
    return np.asarray(visits[visits >= 0])


def _within(begins: Floats, ends: Floats, shape: tuple[int, int]) -> tuple[Floats, Floats]:
    """Legs cut to the map and a cell around it, as far as they reach it at all: who flies far off costs no time."""
    low, high = np.array([-1.0, -1.0]), np.array(shape, np.float64) + 1.0
    along = ends - begins
    with np.errstate(divide="ignore", invalid="ignore"):
        to_low, to_high = (low - begins) / along, (high - begins) / along
    still = along == 0
    out = still & ((begins < low) | (begins > high))
    enters = np.where(still, 0.0, np.minimum(to_low, to_high)).max(axis=1, initial=0.0)
    leaves = np.where(still, 1.0, np.maximum(to_low, to_high)).min(axis=1, initial=1.0)
    kept = (enters <= leaves) & ~out.any(axis=1)
    cut_begins, cut_ends = begins + enters[:, None] * along, begins + leaves[:, None] * along
    return cut_begins[kept], cut_ends[kept]


def _parted(begins: Floats, ends: Floats, source: str) -> tuple[NDArray[np.int64], Floats]:
    """Where legs cross borders of cells: the leg, and the share of it that is flown by then, in order; 0 and 1 too."""
    numbers = np.arange(len(begins))
    legs, shares = [numbers, numbers], [np.zeros(len(begins)), np.ones(len(begins))]
    for axis in (0, 1):
        first, last = begins[:, axis], ends[:, axis]
        low, high = np.ceil(np.minimum(first, last)), np.floor(np.maximum(first, last))
        count = np.maximum(high - low + 1, 0).astype(np.int64)
        if count.sum() > MOST_PARTS:
            came = f"a track that crosses {count.sum():,} borders of cells came"
            raise DataFormatError(
                Fault(source, "", came, f"expected at most {MOST_PARTS:,}: cut it, or coarsen the map")
            )
        leg = np.repeat(numbers, count)
        border = low[leg] + np.arange(len(leg)) - np.repeat(np.cumsum(count) - count, count)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (border - first[leg]) / (last - first)[leg]
        legs.append(leg)
        shares.append(np.clip(np.nan_to_num(share), 0.0, 1.0))
    leg, share = np.concatenate(legs), np.concatenate(shares)
    order = np.lexsort([share, leg])
    return leg[order], share[order]


def _straightened(line: Floats, tolerance: float) -> Floats:
    """The line without fixes that lie within the tolerance of the last one kept, or of a straight line.

    Where it turns back it is cut first: to and fro along one line is flown as often as it is.
    """
    import shapely

    kept = _apart(line, tolerance)
    along = np.diff(kept, axis=0)
    back = np.flatnonzero((along[:-1] * along[1:]).sum(axis=1) <= 0.0) + 1
    cuts = np.union1d(back, np.arange(0, len(kept), BLOCK)).tolist()
    found = [kept[:1]]
    for first, last in pairwise([*cuts, len(kept) - 1]):
        part = kept[first : last + 1]
        if len(part) > 2:
            part = shapely.get_coordinates(shapely.LineString(part).simplify(tolerance, preserve_topology=False))
        found.append(part[1:])
    return np.ascontiguousarray(np.concatenate(found))


def _apart(line: Floats, tolerance: float) -> Floats:
    """The first place, each that lies farther than the tolerance from the last one kept, and the last."""
    kept, square = [0], tolerance**2
    east, north = line[0].tolist()
    for which, (x, y) in enumerate(line.tolist()):
        if (x - east) ** 2 + (y - north) ** 2 > square:
            kept.append(which)
            east, north = x, y
    return line[kept if kept[-1] == len(line) - 1 else [*kept, len(line) - 1]]
