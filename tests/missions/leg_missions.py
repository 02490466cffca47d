"""Missions along legs on the globe, for tests of files that fly."""

from itertools import pairwise
from pathlib import Path

import numpy as np

from sooner.missions import Score, read_mission, score_plan
from sooner.problem import Plan
from sooner.problem.leg_moves import place_numbers
from tests.missions.drawn import box, drawn, place, point, raster

VEHICLE = """
name = "Test"
speed_mps = 12.0
accel_mps2 = 2.0
airspeed_mps = 15.0
climb_mps = 2.5
descent_mps = 1.5
endurance_s = 1500
reserve = 0.2
swap_s = 60
takeoff_s = 5
landing_mps = 0.5
landing_below_m = 10.0
"""
AREA = box(0, 0, 1500, 1000, (900, 600, 1000, 700))
TOWER = box(500, 300, 600, 420)
LAUNCH, FARM = point(60, 60), point(1300, 80)


def ridges(rows: int = 45, cols: int = 70) -> np.ndarray:
    """Hills of up to some 150 m around 600 m above the sea, in cells of 25 m."""
    r, c = np.indices((rows, cols))
    peaks = ((10, 20, 5, 90), (30, 45, 6, 140), (25, 12, 4, 60), (15, 55, 5, 110))
    return 600.0 + sum(h * np.exp(-((r - row) ** 2 + (c - col) ** 2) / (2 * w**2)) for row, col, w, h in peaks)


def leg_mission(
    folder: Path,
    drones: int = 1,
    batteries: int = 1,
    hilly: bool = False,
    more: str = "",
    area: str = "",
    searcher: str = "",
    vehicle: str = VEHICLE,
) -> Path:
    """A mission over AREA less TOWER, launched at its south-west corner."""
    folder.mkdir(exist_ok=True)
    drawn(folder / "area.geojson", ("search", AREA), ("launch", LAUNCH), ("farm", FARM))
    drawn(folder / "tower.geojson", ("tower", TOWER))
    (folder / "vehicle.toml").write_text(vehicle)
    heights = ""
    if hilly:
        raster(folder / "heights.tif", ridges().astype(np.float32), 25.0)
        heights = 'elevation = "heights.tif"'
    one = f'[[searcher]]\nstart = "launch"\nmoves = "legs"\nvehicle = "vehicle.toml"\nbatteries = {batteries}\n'
    path = folder / "mission.toml"
    path.write_text(
        f'name = "Ridge"\n[area]\npolygon = {{ file = "area.geojson", title = "search" }}\nno_fly = "tower.geojson"\n'
        f"cell_m = 25.0\nmargin_m = 8.0\n{heights}\n{area}\n[sensor]\nradius_m = 60.0\n"
        f"{(one + searcher) * drones}\n{more}\n"
    )
    return path


def there_and_back(path: Path, *corners: list[list[float]]) -> Score:
    """A plan that flies round corners, metres from the area's corner, in each sortie; round everything else itself."""
    mission = read_mission(path)
    actions = []
    for number, searcher in enumerate(mission.problem.searchers):
        moves = searcher.moves
        wanted = corners[min(number, len(corners) - 1)]
        lon_lat = np.array([place(*corner) for corner in wanted]).reshape(-1, 2)
        assert mission.area is not None
        stops = [moves.home, *mission.area.frame.metres(lon_lat[:, ::-1]).tolist(), moves.end or moves.home]
        line = [np.array(stops[:1])]
        for here, there in pairwise(stops):
            line.append(moves.airspace.way(here, there)[1:])
        actions.append(place_numbers(np.concatenate(line)))
    return score_plan(mission, Plan(tuple(actions)))
