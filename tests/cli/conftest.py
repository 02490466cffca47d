"""sooner, as its command line is used, within this process."""

import json
from dataclasses import dataclass

import pytest

from sooner.cli.main import run

MISSION = """
name = "Small"
[area]
poc = "poc.csv"
cell_m = 24.0
[sensor]
glimpse = 0.5
[[searcher]]
start = [2, 2]
speed_mps = 12.0
[budget]
steps = 12
"""


@dataclass(frozen=True)
class Ended:
    status: int
    out: str
    err: str

    @property
    def json(self):
        assert self.out.count("\n") == 1
        return json.loads(self.out, parse_constant=pytest.fail)


@pytest.fixture
def sooner(capsys):
    def call(*arguments) -> Ended:
        capsys.readouterr()
        status = run([str(argument) for argument in arguments])
        told = capsys.readouterr()
        assert "Traceback" not in told.err
        return Ended(status, told.out, told.err)

    return call


@pytest.fixture
def mission(tmp_path):
    (tmp_path / "poc.csv").write_text("\n".join(",".join(str((r * c) % 7) for c in range(6)) for r in range(5)))
    path = tmp_path / "mission.toml"
    path.write_text(MISSION)
    return path
