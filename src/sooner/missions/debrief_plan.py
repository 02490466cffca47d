"""Flown against planned: how much of the plan's line was flown, how far off it, and what was not looked at."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.grid import Grid
from sooner.io.georeference import Georeference
from sooner.missions.chances import pod_by_cell
from sooner.missions.debrief_looks import Flown, reach_m
from sooner.missions.flight_plans import flights
from sooner.missions.mission_file import Mission
from sooner.missions.score import Score
from sooner.problem.leg_moves import LegMoves, places_of

__all__ = ["Compared", "Gap", "compared", "gaps_geojson"]

NEAR = 0.5  # of how far looks reach: so near to the plan's line, it was flown
MISSED = 0.5  # of the POD that was planned for a cell: with less, it is a gap
MOST_GAPS = 10_000
MOST_POINTS = 200_000

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Gap:
    """Ground, all of a piece, that the plan would have looked at and the flight did not.

    Parameters
    ----------
    area_m2, poc : float         its size, and the probability that the person is there now
    place : (lat, lon)           of one of its cells, near to its middle
    rings : of (n, 2) float      its border and those of its holes: latitude, longitude
    """

    area_m2: float
    poc: float
    place: tuple[float, float]
    rings: tuple[Floats, ...]

    def result(self) -> dict[str, Any]:
        """For JSON, without its border."""
        return {"area_m2": self.area_m2, "poc": self.poc, "place": list(self.place)}


@dataclass(frozen=True, eq=False)
class Compared:
    """A plan beside what was flown of it.

    Parameters
    ----------
    score : Score                what the plan would have been worth
    found : float                likewise, by POD of each cell: to compare with that of the flight
    share_flown : float or None  of the plan's line, that the flight came within half of how far looks reach of; None
                                 where the plan flies nothing
    farthest_m : float           that the flight was off the plan's line, and
    farthest_at : (lat, lon)     where
    lines : of (n, 2) float      the plan's lines, metres of the map
    missed : (N,) bool           cells whose POD is less than half of what was planned, in gaps of `least_m2` at least
    least_m2 : float             ground that one look covers: pi R^2; over cells that of a cell
    slivers_m2 : float           ground in gaps that are smaller, and left out
    gaps : of Gap                the same in pieces, those with the most probability first
    """

    score: Score
    found: float
    share_flown: float | None
    farthest_m: float
    farthest_at: tuple[float, float]
    lines: tuple[Floats, ...]
    missed: NDArray[np.bool_]
    least_m2: float
    slivers_m2: float
    gaps: tuple[Gap, ...]

    @property
    def gap_m2(self) -> float:
        """Ground in gaps."""
        return float(self.missed.sum()) * self.score.mission.problem.grid.cell_m**2

    def result(self, poc: Floats) -> dict[str, Any]:
        """One JSON object; `poc` (N,) is the probability of each cell after the flight."""
        return {
            "found": self.found,
            "share_flown": self.share_flown,
            "farthest_m": None if self.share_flown is None else self.farthest_m,
            "farthest_at": None if self.share_flown is None else list(self.farthest_at),
            "gap_m2": self.gap_m2,
            "gap_poc": float(poc[self.missed].sum()),
            "gap_cells": int(self.missed.sum()),
            "gap_least_m2": self.least_m2,
            "slivers_m2": self.slivers_m2,
            "gaps": [gap.result() for gap in self.gaps[:100]],
        }


def compared(score: Score, ground: Georeference, tracks: Sequence[Flown], pod: Floats, poc: Floats) -> Compared:
    """A plan beside tracks.

    Parameters
    ----------
    score : Score            the plan, judged
    ground : Georeference    of the mission's cells
    tracks : of Flown        all that was flown
    pod, poc : (N,) float    POD of each cell by the tracks, and the probability that the person is there after them
    """
    mission = score.mission
    planned = pod_by_cell(mission, score.looks)
    short = (planned > 0.0) & (pod < MISSED * planned)
    least_m2 = _look_m2(mission)
    missed = _large(mission.problem.grid, short, least_m2)
    lines = tuple(_lines(score, ground))
    pieces = [piece for each in tracks for piece in each.pieces]
    on_plan, (farthest_m, place) = _share(lines, pieces, NEAR * reach_m(mission)), _farthest(pieces, lines)
    return Compared(
        score=score,
        found=float(np.ravel(mission.sight.theta) @ planned),
        share_flown=on_plan,
        farthest_m=farthest_m,
        farthest_at=_on_globe(score, ground, place),
        lines=lines,
        missed=missed,
        least_m2=least_m2,
        slivers_m2=float((short & ~missed).sum()) * mission.problem.grid.cell_m**2,
        gaps=_gaps(score, ground, missed, poc),
    )


def _lines(score: Score, ground: Georeference) -> list[Floats]:
    """What each searcher would have flown, metres of the map."""
    grid = score.mission.problem.grid
    if isinstance(score.mission.problem.searchers[0].moves, LegMoves):
        return [places_of(actions) for actions in score.plan.actions]
    found = []
    for plan in flights(score).plans:
        cells = ground.cells([plan.home, *plan.places])
        found.append(np.column_stack([cells[:, 1], grid.shape[0] - 1 - cells[:, 0]]) * grid.cell_m)
    return found


# ---------------------------------------------------------------- lines beside lines


def _share(lines: Sequence[Floats], others: Sequence[Floats], near_m: float) -> float | None:
    """Share of the lines' length that lies near to one of the others; None where they have none."""
    step = max(near_m / 2, sum(map(_length, lines)) / MOST_POINTS)
    flown_m = total_m = 0.0
    for line in lines:
        points, weights = _sampled(line, step)
        flown_m += float(weights @ (_away(points, others) <= near_m))
        total_m += float(weights.sum())
    return flown_m / total_m if total_m > 0 else None


def _farthest(lines: Sequence[Floats], others: Sequence[Floats]) -> tuple[float, Floats]:
    """How far the lines' places lie from the others at most, and where."""
    places = np.concatenate([np.asarray(line) for line in lines])
    away = _away(places, others)
    most = int(np.argmax(away))
    return float(away[most]), places[most]


def _length(line: Floats) -> float:
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def _sampled(line: Floats, step: float) -> tuple[Floats, Floats]:
    """Middles of parts of a line, no longer than the step, and their lengths."""
    legs = np.hypot(*np.diff(line, axis=0).T)
    count = np.maximum(np.ceil(legs / step), 1).astype(np.int64)
    leg = np.repeat(np.arange(len(legs)), count)
    within = np.arange(len(leg)) - np.repeat(np.cumsum(count) - count, count)
    share = (within + 0.5) / count[leg]
    return line[:-1][leg] + share[:, None] * np.diff(line, axis=0)[leg], (legs / count)[leg]


def _away(points: Floats, lines: Sequence[Floats]) -> Floats:
    """(n,) float: metres from each place to the nearest of the lines."""
    import shapely

    if len(points) == 0:
        return np.zeros(0)
    legs = [np.stack([line[:-1], line[1:]], axis=1) if len(line) > 1 else line[None].repeat(2, 1) for line in lines]
    tree = shapely.STRtree(shapely.linestrings(np.concatenate(legs)))
    (asked, _), away = tree.query_nearest(shapely.points(points), return_distance=True, all_matches=False)
    found = np.empty(len(points))
    found[asked] = away
    return found


def _on_globe(score: Score, ground: Georeference, place: Floats) -> tuple[float, float]:
    grid = score.mission.problem.grid
    col, up = place / grid.cell_m
    lat, lon = ground.places([[grid.shape[0] - 1 - up, col]])[0]
    return float(lat), float(lon)


# ---------------------------------------------------------------- gaps


def _look_m2(mission: Mission) -> float:
    """Ground that one look covers."""
    if mission.over_legs or mission.over_regions:
        return pi * reach_m(mission) ** 2
    return mission.problem.grid.cell_m**2


def _large(grid: Grid, short: NDArray[np.bool_], least_m2: float) -> NDArray[np.bool_]:
    """(N,) bool: of these cells those in pieces of so much ground, which hang together by their sides."""
    from scipy.ndimage import label

    labels, _ = label(short.reshape(grid.shape))
    sizes_m2 = np.bincount(labels.ravel()) * grid.cell_m**2
    return np.asarray(short & (sizes_m2 >= least_m2 * (1.0 - 1e-9))[labels.ravel()])


def _gaps(score: Score, ground: Georeference, missed: NDArray[np.bool_], poc: Floats) -> tuple[Gap, ...]:
    """The missed cells in pieces that hang together by their sides."""
    from scipy.ndimage import find_objects, label, sum_labels

    grid = score.mission.problem.grid
    labels, count = label(missed.reshape(grid.shape))
    if count == 0:
        return ()
    numbers = np.arange(1, count + 1)
    masses = np.atleast_1d(sum_labels(poc.reshape(grid.shape), labels, numbers))
    sizes = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    windows = find_objects(labels)
    found = []
    for which in np.lexsort([-sizes, -masses])[:MOST_GAPS].tolist():
        window = windows[which]
        offset = np.array([window[0].start, window[1].start])
        here = labels[window] == which + 1
        rows, cols = np.nonzero(here)
        middle = int(np.argmin((rows - rows.mean()) ** 2 + (cols - cols.mean()) ** 2))
        lat, lon = ground.places([[rows[middle] + offset[0], cols[middle] + offset[1]]])[0]
        rings = tuple(ground.places(ring - 0.5 + offset) for ring in _rings(here))
        found.append(Gap(float(sizes[which]) * grid.cell_m**2, float(masses[which]), (float(lat), float(lon)), rings))
    return tuple(found)


def _rings(here: NDArray[np.bool_]) -> list[Floats]:
    """Border and holes of cells that hang together: rows and columns of corners, the border counter-clockwise."""
    import shapely
    from rasterio.features import shapes

    (drawn,) = [shape for shape, value in shapes(here.astype(np.uint8), mask=here, connectivity=4) if value]
    polygon = shapely.geometry.polygon.orient(
        shapely.geometry.shape(drawn), -1.0
    )  # rows go down: it turns the other way
    return [np.asarray(ring.coords)[:, ::-1] for ring in (polygon.exterior, *polygon.interiors)]


def gaps_geojson(gaps: Sequence[Gap]) -> bytes:
    """Gaps as GeoJSON polygons, as CalTopo shows shapes."""
    features = [
        {
            "type": "Feature",
            "properties": {
                "class": "Shape",
                "title": f"gap {number}",
                "description": f"{gap.area_m2:.0f} m2, POC {gap.poc:.2%}",
                "stroke": "#d55e00",
                "stroke-width": 2,
                "fill": "#d55e00",
                "fill-opacity": 0.2,
                "area_m2": round(gap.area_m2, 1),
                "poc": gap.poc,
            },
            "geometry": {
                "type": "Polygon",
                "coordinates": [[[round(lon, 8), round(lat, 8)] for lat, lon in ring.tolist()] for ring in gap.rings],
            },
        }
        for number, gap in enumerate(gaps, start=1)
    ]
    return (json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n").encode()
