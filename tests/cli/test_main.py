import json
import subprocess
import sys

import pytest

from sooner import __version__
from sooner.planners.registry import PLANNERS

HEAVY = ("numpy", "numba", "scipy", "matplotlib", "sklearn", "rasterio", "pydantic")


def test_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom sooner.cli.main import run\nstatus = run(['--help'])\n"
        f"print(status, [name for name in {HEAVY} if name in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.splitlines()[-1] == "0 []"
    assert "plan " in out


def test_version(sooner):
    assert sooner("--version").out == f"sooner {__version__}\n"


def test_no_command_shows_the_commands(sooner):
    ended = sooner()
    assert ended.status == 2
    assert "evaluate" in ended.out + ended.err


def test_an_unknown_command_is_refused(sooner):
    ended = sooner("fly")
    assert ended.status == 2
    assert "fly" in ended.err


def test_planners_are_listed_with_when_to_choose_which(sooner):
    lines = sooner("planners").out.splitlines()
    assert [line.split()[0] for line in lines] == list(PLANNERS)
    told = json.loads(sooner("planners", "--json").out)
    assert [entry["name"] for entry in told["planners"]] == list(PLANNERS)


def test_every_planner_can_be_cited(sooner):
    for name in PLANNERS:
        ended = sooner("cite", name)
        assert ended.status == 0
        assert ended.out.startswith("@")
    assert "Theory of Optimal Search" in sooner("cite", "Stone1975").out


def test_what_is_not_known_cannot_be_cited(sooner):
    ended = sooner("cite", "Nobody1900")
    assert ended.status == 2
    assert "'Nobody1900' came" in ended.err


@pytest.mark.parametrize("paper", ["lin2015", "nobody1900"])
def test_a_paper_that_is_not_there_is_refused(sooner, paper, tmp_path):
    ended = sooner("reproduce", paper, "--data", tmp_path)
    assert ended.status == 2
    assert paper in ended.err


def test_reproduce_without_data_says_what_to_give(sooner, monkeypatch, tmp_path):
    monkeypatch.delenv("SOONER_DATA", raising=False)
    assert "SOONER_DATA" in sooner("reproduce", "lin2014").err
    assert "expected a folder" in sooner("reproduce", "lin2014", "--data", tmp_path / "none").err


def test_warmup_runs_through_every_planner(sooner):
    ended = sooner("warmup")
    assert ended.status == 0
    assert {line.split()[-1] for line in ended.err.splitlines()} >= set(PLANNERS) | {"bounds", "picture"}
    assert ended.out.startswith("compiled in")
