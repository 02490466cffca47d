"""A small mission that is right, for tests to spoil."""

from pathlib import Path

import pytest

from tests.small_mission import small_mission, written

POC = "1,2,3,4\n5,6,7,8\n9,8,7,6\n"
THETA = "0.5,0.5,0.2,0.3\n0.5,0.5,0.97,0.5\n0.1,0.9,0.5,0.5\n"
CERTAIN = "0.5,0.5,0.5,0.5\n0.5,0.5,0.5,0.5\n0.5,1,0.5,0.5\n"
WALL = "0,0,1,0\n0,0,1,0\n0,0,1,0\n"
MISSION = small_mission()


@pytest.fixture
def mission(tmp_path):
    """mission(text, **files) -> path of the mission file, beside its rasters."""

    def write(text: str = MISSION, **files: str | bytes) -> Path:
        rasters = {"poc_csv": POC, "theta_csv": THETA, "certain_csv": CERTAIN, "wall_csv": WALL}
        return written(tmp_path, text, **(rasters | files))

    return write


def spoiled(old: str, new: str) -> str:
    assert old in MISSION
    return MISSION.replace(old, new)
