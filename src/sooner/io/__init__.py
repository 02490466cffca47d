"""The doors to files: rasters and street maps in, plans in and out, and writing that leaves nothing half done."""

from sooner.io.occupancy_graphs import StreetMap, read_street_map, street_map_json
from sooner.io.openstreetmap import read_openstreetmap
from sooner.io.plans import plan_csv, read_plan
from sooner.io.rasters import MAX_CELLS, Raster, raster_csv, read_raster
from sooner.io.region_plans import read_region_plan, region_plan_csv
from sooner.io.writing import Folder

__all__ = [
    "MAX_CELLS",
    "Folder",
    "Raster",
    "StreetMap",
    "plan_csv",
    "raster_csv",
    "read_openstreetmap",
    "read_plan",
    "read_raster",
    "read_region_plan",
    "read_street_map",
    "region_plan_csv",
    "street_map_json",
]
