"""Gymnasium and PettingZoo are an extra: nothing loads them unasked, and one is told what to install."""

import subprocess
import sys


def run(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_the_library_and_its_command_import_neither():
    code = (
        "import sys, sooner, sooner.cli.main, sooner.simulation, sooner.missions\n"
        "print([m for m in ('gymnasium', 'pettingzoo', 'sooner.environments') if m in sys.modules])"
    )
    assert run(code) == "[]\n"


def test_without_gymnasium_one_is_told_what_to_install_and_a_policy_still_flies():
    code = """
import sys
sys.modules["gymnasium"] = sys.modules["pettingzoo"] = None
import sooner.environments
from sooner.environments import PolicyStrategy, generated_scenes
from sooner.errors import UnsupportedProblemError
from sooner.simulation import simulate
for name in ("SearchEnv", "SearchParallelEnv"):
    try:
        getattr(sooner.environments, name)
    except UnsupportedProblemError as error:
        print(error)
scene = generated_scenes([0], seconds=5)[0]
print(simulate(scene, PolicyStrategy(lambda seen: [[[0, 0]]] * 4), 1).seconds)
"""
    how = "pip install 'sooner[environments]'"
    team, each = f"SearchEnv needs Gymnasium: {how}", f"SearchParallelEnv needs Gymnasium and PettingZoo: {how}"
    assert run(code).splitlines() == [team, each, "5"]


def test_without_pettingzoo_one_is_told_what_to_install():
    code = """
import sys
sys.modules["pettingzoo"] = None
from sooner.errors import UnsupportedProblemError
from sooner.environments import SearchEnv
try:
    from sooner.environments import SearchParallelEnv
except UnsupportedProblemError as error:
    print(error)
"""
    assert run(code) == "SearchParallelEnv needs Gymnasium and PettingZoo: pip install 'sooner[environments]'\n"
