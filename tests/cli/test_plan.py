import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sooner.errors import InvalidProblemError
from tests.cli.conftest import MISSION

KEYS = """planner objective value bound bound_proof gap reference reference_name efficiency status seconds seed
plan_file searchers"""


def plan(sooner, mission, *more):
    return sooner("plan", mission, "--planner", "greedy", "--seconds", "0.2", *more)


def test_json_prints_one_object_with_the_promised_keys(sooner, mission):
    ended = plan(sooner, mission, "--json", "--seed", "5")
    told = ended.json
    assert ended.status == 0
    assert list(told)[:4] == ["planner", "objective", "value", "bound"]
    assert set(KEYS.split()) <= set(told)
    assert told["planner"] == "greedy"
    assert told["objective"] == "detection"
    assert told["seed"] == 5
    assert told["reference_name"] == "teleport"
    assert told["efficiency"] == pytest.approx(told["value"] / told["reference"])
    assert told["plan_file"] == str(mission.parent / "mission-plan" / "plan.csv")
    (searcher,) = told["searchers"]
    assert searcher["cells"][0] == [2, 2]
    assert len(searcher["cells"]) == 13
    assert [row * 6 + col for row, col in searcher["cells"]] == searcher["actions"]
    assert searcher["duration_s"] == 24.0


def test_gap_is_what_the_value_misses_of_the_bound(sooner, mission):
    told = plan(sooner, mission, "--json").json
    if told["bound"] is None:
        assert told["gap"] is None
    else:
        assert told["bound_proof"]
        assert told["gap"] == pytest.approx(max(told["bound"] - told["value"], 0) / told["bound"])


def test_plan_result_and_picture_are_written(sooner, mission, tmp_path):
    ended = plan(sooner, mission, "--out", tmp_path / "out")
    assert ended.status == 0
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        ".sooner-files.json",
        "plan.csv",
        "plan.json",
        "plan.png",
    ]
    assert (tmp_path / "out" / "plan.csv").read_text().startswith("searcher,step,row,col\n0,0,2,2\n")
    assert (tmp_path / "out" / "plan.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "out" / "plan.json").read_text())["planner"] == "greedy"
    assert str(tmp_path / "out" / "plan.png") in ended.out


def test_progress_goes_to_stderr_and_quiet_silences_it(sooner, mission):
    assert "planning with greedy" in plan(sooner, mission, "--json").err
    assert plan(sooner, mission, "--json", "--quiet").err == ""


def test_evaluate_gives_the_plan_the_same_value(sooner, mission):
    planned = plan(sooner, mission, "--json").json
    scored = sooner("evaluate", mission, planned["plan_file"], "--json").json
    assert scored["value"] == planned["value"]
    assert scored["efficiency"] == planned["efficiency"]


def test_planning_again_replaces_but_never_what_somebody_edited(sooner, mission):
    first = plan(sooner, mission, "--json").json
    assert plan(sooner, mission, "--seed", "1").status == 0
    with Path(first["plan_file"]).open("a") as file:
        file.write("0,13,2,2\n")
    ended = plan(sooner, mission)
    assert ended.status == 2
    assert "plan.csv: this file has been changed since sooner wrote it" in ended.err
    assert plan(sooner, mission, "--force").status == 0


def test_a_target_is_planned_soonest(sooner, mission):
    mission.write_text(MISSION + "[objective]\ndetection_target = 0.1\n")
    told = plan(sooner, mission, "--json").json
    assert told["objective"] == "detection 0.1 soonest"
    assert told["value"] == -told["time_to"]["0.1"]


def test_a_target_out_of_reach_has_no_value(sooner, mission):
    mission.write_text(MISSION + "[objective]\ndetection_target = 0.99\n")
    ended = plan(sooner, mission, "--json")
    assert ended.status == 0
    assert ended.json["value"] is None


def test_several_searchers_are_planned_together(sooner, mission):
    mission.write_text(MISSION.replace("[budget]", "[[searcher]]\nstart = [4, 5]\nspeed_mps = 12.0\n[budget]"))
    told = plan(sooner, mission, "--json").json
    assert [searcher["cells"][0] for searcher in told["searchers"]] == [[2, 2], [4, 5]]
    assert sooner("evaluate", mission, told["plan_file"], "--json").json["value"] == told["value"]


def test_a_fixed_wing_that_is_stuck_is_refused(sooner, mission):
    (mission.parent / "poc.csv").write_text("1,2,3\n")
    mission.write_text(MISSION.replace("start = [2, 2]", 'start = [0, 0]\nkind = "fixed_wing"'))
    ended = plan(sooner, mission)
    assert ended.status == 2
    assert "mission.toml: searcher: no flight of 12 steps" in ended.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--planner", "clever"], "planner 'clever' came; expected one of"),
        (["--format", "shp"], "'shp' came; expected one or more of qgc"),
        (["--seconds", "0"], "--seconds: 0 came"),
        (["--seconds", "nan"], "--seconds: nan came"),
        (["--seconds", "long"], "--seconds"),
        (["--seed", "-1"], "--seed"),
        (["--loud"], "--loud"),
    ],
)
def test_a_bad_option_is_refused(sooner, mission, arguments, told):
    ended = sooner("plan", mission, "--planner", "greedy", *arguments)
    assert ended.status == 2
    assert told in ended.err
    assert not (mission.parent / "mission-plan").exists()


def test_a_bad_mission_is_refused_and_nothing_is_left(sooner, mission):
    mission.write_text(MISSION.replace("steps = 12", "steps = 0").replace("start = [2, 2]", "start = [9, 9]"))
    ended = plan(sooner, mission)
    assert ended.status == 2
    assert ended.out == ""
    assert ended.err.splitlines() == [
        f"sooner: {mission}: budget.steps: 0 came; expected a number of at least 1",
        f"sooner: {mission}: searcher[0].start: [9, 9] came; "
        "expected a cell of the map, which has rows 0 to 4 and columns 0 to 5",
    ]
    assert sorted(p.name for p in mission.parent.iterdir()) == ["mission.toml", "poc.csv"]


def test_our_own_fault_is_owned_up_to(sooner, mission, monkeypatch):
    def broken(*arguments, **settings):
        raise ZeroDivisionError("division by zero")

    monkeypatch.delenv("SOONER_TRACEBACK", raising=False)
    monkeypatch.setattr("sooner.missions.planning.solve", broken)
    ended = plan(sooner, mission)
    assert ended.status == 1
    assert "a fault of sooner, not yours: ZeroDivisionError" in ended.err
    assert "please report" in ended.err


def test_a_problem_that_cannot_be_posed_is_the_users_fault(sooner, mission, monkeypatch):
    def refusing(*arguments, **settings):
        raise InvalidProblemError("no such problem")

    monkeypatch.setattr("sooner.missions.planning.solve", refusing)
    assert plan(sooner, mission).status == 2


SLOW = """
import sys, time
from dataclasses import dataclass
from sooner.planners import registry
from sooner.planners.greedy import Greedy

@dataclass(frozen=True)
class Slow:
    def handles(self, problem):
        return None
    def plans(self, problem, rng):
        found = next(Greedy().plans(problem, rng))
        while True:
            time.sleep(0.01)
            yield found

registry.PLANNERS["slow"] = registry.Entry("__main__:Slow", "never ends")
from sooner.cli.main import run
sys.exit(run(sys.argv[1:]))
"""


def started(mission):
    """sooner in a process of its own, once it has a plan and goes on for better."""
    script = mission.parent / "slow.py"
    script.write_text(SLOW)
    running = subprocess.Popen(
        [sys.executable, str(script), "plan", str(mission), "--planner", "slow", "--seconds", "60"],
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"SOONER_TRACEBACK": ""},
        # a job in the background ignores Ctrl-C and hands that on to its children: undo it for this one
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    for line in running.stderr:
        if "found" in line:
            return running
    raise AssertionError("it never found a plan")


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_plan_is_written_and_said(mission, how):
    running = started(mission)
    running.send_signal(how)
    out, err = running.communicate(timeout=50)
    assert running.returncode == 130
    assert "Traceback" not in err
    assert "the best plan so far is written" in err
    assert "plan.csv" in out
    told = json.loads((mission.parent / "mission-plan" / "plan.json").read_text())
    assert told["status"] == "interrupted"
    assert np.loadtxt(mission.parent / "mission-plan" / "plan.csv", delimiter=",", skiprows=1).shape == (13, 4)


def test_a_killed_plan_leaves_nothing_half_written(mission):
    running = started(mission)
    running.kill()
    running.communicate(timeout=50)
    assert not (mission.parent / "mission-plan").exists()


def test_an_interruption_before_the_first_plan_writes_nothing(sooner, mission, monkeypatch):
    def interrupted(*arguments, **settings):
        raise KeyboardInterrupt

    monkeypatch.setattr("sooner.missions.planning.solve", interrupted)
    ended = plan(sooner, mission)
    assert ended.status == 130
    assert not (mission.parent / "mission-plan").exists()


def test_a_target_out_of_reach_is_said_and_the_closest_flight_written(sooner, mission):
    mission.write_text(mission.read_text() + "\n[objective]\ndetection_target = 0.99\n")
    ended = plan(sooner, mission)
    assert ended.status == 0
    assert "cannot be reached in this time" in ended.out
    lines = (mission.parent / "mission-plan" / "plan.csv").read_text().splitlines()
    assert len(lines) > 10


def test_a_target_above_what_is_on_the_map_is_refused(sooner, mission):
    text = mission.read_text()
    mission.write_text(text.replace("[area]", "[area]\noutside = 0.2") + "\n[objective]\ndetection_target = 0.9\n")
    ended = plan(sooner, mission)
    assert ended.status == 2
    assert "objective.detection_target" in ended.err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_behind_the_output_is_not_our_fault():
    with Path("/dev/full").open("w") as full:
        told = subprocess.run(
            [sys.executable, "-m", "sooner", "planners"], stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert told.returncode == 2
    assert b"cannot be written" in told.stderr
