"""A small mission that is right, for tests to spoil."""

from pathlib import Path

import pytest

POC = "1,2,3,4\n5,6,7,8\n9,8,7,6\n"
THETA = "0.5,0.5,0.2,0.3\n0.5,0.5,0.97,0.5\n0.1,0.9,0.5,0.5\n"
CERTAIN = "0.5,0.5,0.5,0.5\n0.5,0.5,0.5,0.5\n0.5,1,0.5,0.5\n"
WALL = "0,0,1,0\n0,0,1,0\n0,0,1,0\n"
MISSION = """
name = "Small"
[area]
poc = "poc.csv"
cell_m = 24.0
[sensor]
glimpse = 0.5
[[searcher]]
start = [0, 0]
speed_mps = 12.0
[budget]
steps = 6
"""


@pytest.fixture
def mission(tmp_path):
    """mission(text, **files) -> path of the mission file, beside its rasters."""

    def write(text: str = MISSION, **files: str | bytes) -> Path:
        others = {"theta_csv": THETA, "certain_csv": CERTAIN, "wall_csv": WALL}
        for name, content in {"poc_csv": POC, **others, **files}.items():
            data = content.encode() if isinstance(content, str) else content
            (tmp_path / name.replace("_", ".")).write_bytes(data)
        path = tmp_path / "mission.toml"
        path.write_text(text)
        return path

    return write


def spoiled(old: str, new: str) -> str:
    assert old in MISSION
    return MISSION.replace(old, new)
