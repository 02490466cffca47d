"""The picture of the rooms is true: who may import whom."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
KERNELS = sorted((ROOT / "src" / "sooner").rglob("*_kernels.py"))
MAY_IMPORT = {"__future__", "math", "numpy", "numba", "typing"}


def test_rooms_open_only_onto_those_below_them():
    tool = Path(sys.executable).with_name("lint-imports")
    run = subprocess.run([tool, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_kernels_import_arrays_and_the_compiler_only(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
        else:
            continue
        for name in names:
            assert name.split(".")[0] in MAY_IMPORT or name.endswith("_kernels"), f"{path.name} imports {name}"


def test_importing_sooner_imports_nothing_heavy():
    code = (
        "import sys, sooner; print([m for m in ('numpy', 'numba', 'scipy', 'pydantic', 'typer') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out == "[]\n"


def test_planning_a_mission_leaves_pictures_and_mixtures_to_those_who_need_them():
    code = (
        "import sys, sooner.missions, sooner.planners.anneal\n"
        "print([m for m in ('matplotlib', 'sklearn', 'rasterio') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out == "[]\n"
