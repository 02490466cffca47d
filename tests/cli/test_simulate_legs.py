"""`sooner simulate` of a mission along legs."""

import pytest

from sooner.io.leg_plans import leg_plan_csv
from tests.missions.leg_missions import leg_mission, there_and_back


@pytest.fixture
def legs(tmp_path):
    """A mission and a plan for it."""
    path = leg_mission(tmp_path / "legs", 2)
    score = there_and_back(path, [[200, 900], [800, 900]])
    (path.parent / "mine.csv").write_bytes(leg_plan_csv(score.plan, score.mission.problem, score.mission.ground))
    return path, path.parent / "mine.csv", score


def test_a_plan_along_legs_is_flown(sooner, legs):
    path, plan, score = legs
    out = path.parent / "out"
    ended = sooner("simulate", path, "--plan", plan, "--trials", 300, "--out", out, "--json")
    assert ended.status == 0
    assert abs(ended.json["value"]["off_by_errors"]) < 4.5
    assert ended.json["value"]["promised"] == pytest.approx(score.evaluation.total)
    assert (ended.json["moves"], ended.json["time_unit"]) == ("legs", "seconds")
    assert {file.name for file in out.iterdir() if not file.name.startswith(".")} == {
        "trials.csv",
        "simulation.json",
        "plan.csv",
        "plan.png",
    }
    told = sooner("simulate", path, "--plan", plan, "--trials", 20, "--out", path.parent / "again")
    assert "finds the person in" in told.out
    assert "episode" not in told.out


@pytest.mark.parametrize(("option", "why"), [(["--replan", 60], "flown to their end"), (["--animate"], "no episode")])
def test_what_is_not_done_along_legs_is_refused(sooner, legs, option, why):
    path, plan, _ = legs
    ended = sooner("simulate", path, "--plan", plan, *option)
    assert ended.status == 2
    assert f'{option[0]}: it came, and moves = "legs"' in ended.err
    assert why in ended.err
