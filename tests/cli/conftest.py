"""sooner, as its command line is used, within this process."""

import json
from dataclasses import dataclass

import pytest

from sooner.cli.main import run
from tests.small_mission import small_mission, written

MISSION = small_mission(start=(2, 2), steps=12)
POC = "\n".join(",".join(str((r * c) % 7) for c in range(6)) for r in range(5))


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
    return written(tmp_path, MISSION, poc_csv=POC)
