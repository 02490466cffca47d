"""The ground of the next mission: what its file must say anew where cells were cut finer, or laid over a drawn area."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sooner.io import read_raster
from sooner.io.georeference import Georeference
from sooner.io.geotiff import geotiff
from sooner.io.warped import WITHIN
from sooner.missions.area_layers import grid_over, lies_on_globe
from sooner.missions.drawings import is_drawn
from sooner.missions.faults import Faults
from sooner.missions.mission_file import Mission
from sooner.problem.leg_moves import LegMoves

__all__ = ["next_ground", "tags_of"]

AREA = "area.geojson"
RASTERS = (("area", "obstacles"), ("sensor", "difficulty"), ("sensor", "glimpse"), ("sensor", "sweep_width_m"))


def next_ground(mission: Mission, ground: Georeference, said: dict[str, Any]) -> dict[str, bytes]:
    """Change what a mission file says so that its grid is that of the mission's problem; answers the files it takes.

    A raster that is the grid may have been cut finer along legs: the others are cut likewise. A grid that was laid over
    an area is laid over the same area again, drawn where only segments or distances said where it is. Starts and ends
    are told by latitude and longitude, as neither rows nor titles may mean the same any more.

    Parameters
    ----------
    mission : Mission
    ground : Georeference      of its cells
    said : dict                what its file says, changed here
    """
    files: dict[str, bytes] = {}
    if lies_on_globe(Faults(mission.path), mission.settings):
        said["area"]["cell_m"] = ground.cell_m
        if mission.settings.area.polygon is None:
            files[AREA] = _area(mission)
            said["area"]["polygon"] = AREA
    else:
        area = mission.settings.area
        name = area.evidence if area.poc is None else area.poc
        assert name is not None
        shape = read_raster(mission.path.parent / name).values.shape
        if shape == mission.problem.grid.shape:
            return files
        said["area"].pop("cell_m", None)
        files |= _finer(mission, ground, said, mission.problem.grid.shape[0] // shape[0])
    _tell_places(mission, ground, said["searcher"])
    return files


def tags_of(mission: Mission) -> dict[str, str]:
    """What a map of the mission's probability says of itself: over a drawn area it holds only what lies within."""
    return WITHIN if lies_on_globe(Faults(mission.path), mission.settings) else {}


def _area(mission: Mission) -> bytes:
    """The search area as GeoJSON."""
    import shapely

    found = grid_over(Faults(mission.path), mission.settings)
    assert found is not None
    frame = found.frame

    def placed(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return frame.places(points)[:, ::-1]

    drawn = json.loads(shapely.to_geojson(shapely.transform(found.polygon, placed)))
    feature = {"type": "Feature", "properties": {"title": "search area"}, "geometry": drawn}
    return (json.dumps({"type": "FeatureCollection", "features": [feature]}) + "\n").encode()


def _finer(mission: Mission, ground: Georeference, said: dict[str, Any], parts: int) -> dict[str, bytes]:
    """The other rasters, each cell cut into as many."""
    files = {}
    for table, key in RASTERS:
        name = getattr(getattr(mission.settings, table), key)
        if not isinstance(name, str) or is_drawn(name):
            continue
        raster = read_raster(mission.path.parent / name)
        values = raster.values if raster.missing is None else np.where(raster.missing, 0.0, raster.values)
        files[f"{key}.tif"] = geotiff(np.repeat(np.repeat(values, parts, axis=0), parts, axis=1), ground)
        said[table][key] = f"{key}.tif"
    return files


def _tell_places(mission: Mission, ground: Georeference, tables: list[dict[str, Any]]) -> None:
    """Starts and ends by latitude and longitude, as they are told to the problem's searchers."""
    height, cell_m = mission.problem.grid.shape[0], ground.cell_m
    drones = [sortie.drone for sortie in mission.sorties] or range(len(mission.problem.searchers))
    for drone, searcher in zip(drones, mission.problem.searchers, strict=True):
        places: dict[str, Any] = {"start": searcher.start, "end": searcher.end}
        if isinstance(searcher.moves, LegMoves):
            told = {"start": searcher.moves.home, "end": searcher.moves.end}
            places = {
                key: None if place is None else (height - 1 - place[1] / cell_m, place[0] / cell_m)
                for key, place in told.items()
            }
        for key, place in places.items():
            if key in tables[drone] and place is not None:
                lat, lon = ground.places([place])[0]
                tables[drone][key] = {"lat": float(lat), "lon": float(lon)}
