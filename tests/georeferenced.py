"""Small missions that lie somewhere on the globe, for files that fly."""

from pathlib import Path

import numpy as np

from sooner.io.georeference import Georeference
from sooner.io.geotiff import geotiff
from sooner.missions import Mission, Score, score_plan
from sooner.planners import solve
from sooner.planners.registry import make_planner

DOLOMITES = Georeference("EPSG:32632", (720_000.0, 5_150_000.0), 24.0, 24.0)


def located(folder: Path, text: str, poc, ground: Georeference = DOLOMITES, **rasters) -> Path:
    """A mission file beside poc.tif and other rasters: `rocks=...` is rocks.tif."""
    for name, values in ({"poc": poc} | rasters).items():
        (folder / f"{name}.tif").write_bytes(geotiff(values, ground))
    path = folder / "mission.toml"
    path.write_text(text)
    return path


def over_cells(searchers: str, steps: int = 30, area: str = "", sensor: str = "glimpse = 0.6") -> str:
    return f"""
name = "Ridge"
[area]
poc = "poc.tif"
{area}
[sensor]
{sensor}
{searchers}
[budget]
steps = {steps}
"""


def over_regions(searcher: str, seconds: int = 400, regions: str = "", area: str = "") -> str:
    return f"""
name = "Ridge"
[area]
evidence = "poc.tif"
{area}
[sensor]
detect = 0.85
false_alarm = 0.15
radius_m = 40.0
[[searcher]]
moves = "regions"
speed_mps = 10.0
accel_mps2 = 2.0
{searcher}
[budget]
seconds = {seconds}
[objective]
kind = "information"
[regions]
{regions}
"""


def hills(rows: int = 12, cols: int = 16) -> np.ndarray:
    r, c = np.indices((rows, cols))
    return np.exp(-((r - 4) ** 2 + (c - 10) ** 2) / 12.0) + 0.3 * np.exp(-((r - 9) ** 2 + (c - 3) ** 2) / 6.0)


def rocks(rows: int = 12, cols: int = 16) -> np.ndarray:
    """An obstacle in the middle, and one that stands on the border."""
    stones = np.zeros((rows, cols))
    stones[4:8, 5:8] = 1
    stones[:2, 12:] = 1
    return stones


def greedily(mission: Mission) -> Score:
    """Some plan, made at once and without a bound."""
    return score_plan(mission, solve(mission.problem, make_planner("greedy")).best.plan)
