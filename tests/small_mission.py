"""A small mission over cells that is right, for tests to fly and to spoil."""

from pathlib import Path


def small_mission(start: tuple[int, int] = (0, 0), steps: int = 6) -> str:
    return f"""
name = "Small"
[area]
poc = "poc.csv"
cell_m = 24.0
[sensor]
glimpse = 0.5
[[searcher]]
start = [{start[0]}, {start[1]}]
speed_mps = 12.0
[budget]
steps = {steps}
"""


def written(folder: Path, text: str, **files: str | bytes) -> Path:
    """The mission file, beside its rasters: `poc_csv` holds what poc.csv shall."""
    for name, content in files.items():
        data = content.encode() if isinstance(content, str) else content
        (folder / name.replace("_", ".")).write_bytes(data)
    path = folder / "mission.toml"
    path.write_text(text)
    return path
