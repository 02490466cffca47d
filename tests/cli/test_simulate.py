"""`sooner simulate` as a stranger uses it."""

import json

import numpy as np
import pytest

from sooner.missions import read_mission
from sooner.missions.plan_episodes import replayed_plan
from sooner.missions.street_trials import DEFAULT_STRATEGY
from sooner.simulation import load_episode, replayed
from sooner.simulation.plan_episode_file import load_plan_episode, plan_episode_npz
from sooner.simulation.strategies import STRATEGIES


@pytest.fixture
def city(sooner, tmp_path):
    assert sooner("scenario", "street-grid", "--out", tmp_path).status == 0
    path = tmp_path / "mission.toml"
    path.write_text(path.read_text().replace("seconds = 240", "seconds = 60"))
    return path


def test_a_team_is_flown_told_and_drawn(sooner, city):
    ended = sooner("simulate", city, "--trials", "4", "--strategy", "lawnmower")
    assert ended.status == 0
    assert "4 drones, 60 s, flown 4 times by lawnmower" in ended.out
    for told in ("streets detected by the end", "targets detected by the end", "false detections of a target", " +- "):
        assert told in ended.out
    folder = city.parent / "mission-simulation"
    assert (folder / "episode.png").read_bytes().startswith(b"\x89PNG")
    lines = (folder / "trials.csv").read_text().splitlines()
    assert lines[0].startswith("seed,e,e_nodes,e_targets,")
    assert [line.split(",")[0] for line in lines[1:]] == list("0123")
    episode = load_episode(folder / "episode.npz")
    assert f"{episode.e:.6f}" == lines[1].split(",")[1]
    np.testing.assert_array_equal(replayed(episode).places_m, episode.places_m)


def test_one_object_of_json_and_the_same_in_the_file(sooner, city):
    ended = sooner("simulate", city, "--trials", "2", "--seed", "7", "--strategy", "random", "--json", "--quiet")
    assert ended.status == 0
    assert ended.err == ""
    told = ended.json
    assert (told["trials"], told["seed"], told["strategy"], told["seconds"]) == (2, 7, "random", 60)
    assert told["e"]["mean"] == pytest.approx(told["e_nodes"]["mean"] + told["e_targets"]["mean"])
    assert told == json.loads((city.parent / "mission-simulation" / "simulation.json").read_text())
    again = sooner("simulate", city, "--trials", "2", "--seed", "7", "--strategy", "random", "--json", "--quiet")
    assert again.json == told


@pytest.mark.slow
def test_workers_change_nothing(sooner, city, tmp_path):
    alone, together = (
        sooner("simulate", city, "--trials", "6", "--strategy", "random", "-q", "--out", tmp_path / n, "--workers", n)
        for n in ("1", "2")
    )
    assert alone.status == together.status == 0
    assert (tmp_path / "1" / "trials.csv").read_text() == (tmp_path / "2" / "trials.csv").read_text()


def test_each_of_several_targets_is_told_of(sooner, city):
    city.write_text(city.read_text().replace("count = 1", "count = 3"))
    ended = sooner("simulate", city, "--trials", "3", "--strategy", "lawnmower")
    assert ended.status == 0
    for told in ("target 1 ", "target 3 ", "all of them by the end", "repeated detections of a target"):
        assert told in ended.out
    lines = (city.parent / "mission-simulation" / "trials.csv").read_text().splitlines()
    assert lines[0].endswith(",repeated_calls")
    again = sooner("simulate", city, "--trials", "3", "--strategy", "lawnmower", "--json", "-q", "--force")
    assert len(again.json["by_target"]) == 3


def test_an_empty_city_tells_of_false_detections(sooner, city):
    city.write_text(city.read_text().replace("count = 1", "count = 0"))
    ended = sooner("simulate", city, "--trials", "2", "--strategy", "random")
    assert ended.status == 0
    assert "targets detected" not in ended.out
    assert "false detections of a target" in ended.out


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--strategy", "wander"), "'wander' came; expected one of random, lawnmower"),
        (("--planner", "anneal"), "these moves do not know"),
        (("--seconds", "3"), "budget.replan_s"),
        (("--plan", "plan.csv"), "these moves do not know"),
        (("--trials", "2000000"), "expected at most 1,000,000"),
        (("--out", ""), "an empty name came"),
    ],
)
def test_a_wish_that_cannot_be_is_refused(sooner, city, options, told):
    ended = sooner("simulate", city, *options)
    assert ended.status == 2
    assert told in ended.err
    assert not (city.parent / "mission-simulation").exists()


def test_a_strategy_over_cells_is_refused(sooner, mission):
    ended = sooner("simulate", mission, "--strategy", "random")
    assert ended.status == 2
    assert "--planner" in ended.err


def test_a_mission_over_waypoints_is_not_planned(sooner, city):
    ended = sooner("plan", city)
    assert ended.status == 2
    assert "sooner simulate" in ended.err


def test_a_plan_over_cells_is_flown_beside_its_promise(sooner, mission):
    ended = sooner("simulate", mission, "--trials", "400", "--seconds", "0.3")
    assert ended.status == 0
    assert "the judge promised" in ended.out
    folder = mission.parent / "mission-simulation"
    told = json.loads((folder / "simulation.json").read_text())
    assert told["unit"] == "probability"
    assert abs(told["value"]["off_by_errors"]) < 4.0
    scored = sooner("evaluate", mission, folder / "plan.csv", "--json").json
    assert scored["value"] == told["value"]["promised"]
    rows = [line.split(",") for line in (folder / "trials.csv").read_text().splitlines()]
    assert np.mean([float(row[1]) for row in rows[1:]]) == pytest.approx(told["value"]["mean"])


@pytest.fixture
def evidence(tmp_path):
    text = '[area]\nevidence = "theta.csv"\ncell_m = 10.0\n[sensor]\ndetect = 0.8\nfalse_alarm = 0.2\n'
    text += "[[searcher]]\nstart = [1, 1]\nspeed_mps = 5.0\n[budget]\nseconds = 60\n"
    (tmp_path / "theta.csv").write_text("\n".join(",".join(f"{0.1 * (r + c):.1f}" for c in range(5)) for r in range(4)))
    path = tmp_path / "mission.toml"
    path.write_text(text)
    return path


def test_a_plan_is_made_anew_on_the_way(sooner, evidence):
    ended = sooner("simulate", evidence, "--trials", "3", "--seconds", "0.2", "--replan", "20", "--planner", "greedy")
    assert ended.status == 0
    assert "without replans, as promised" in ended.out
    assert "false alarms" in ended.out
    told = json.loads((evidence.parent / "mission-simulation" / "simulation.json").read_text())
    assert (told["replan"], told["planner"], told["unit"], told["time_unit"]) == (20.0, "greedy", "targets", "steps")


@pytest.mark.parametrize("every", ["1.0", "nan", "inf", "-5", "60", "1e6"])
def test_a_replan_that_cannot_be_is_refused(sooner, evidence, every):
    ended = sooner("simulate", evidence, "--trials", "3", "--seconds", "0.2", "--replan", every)
    assert ended.status == 2
    told = "came, and the search lasts 60 s; expected less than that, and at least one step, which takes 2 s"
    assert f"--replan: {float(every):g} {told}" in ended.err


def test_a_replan_in_steps_is_refused_in_steps(sooner, evidence):
    text = evidence.read_text().replace("speed_mps = 5.0\n", "").replace("seconds = 60", "steps = 30")
    evidence.write_text(text)
    ended = sooner("simulate", evidence, "--replan", "30")
    assert ended.status == 2
    assert "--replan: 30 came, and the search lasts 30 steps; expected less than that" in ended.err


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "inf"])
@pytest.mark.parametrize("command", ["simulate", "plan"])
def test_a_planning_time_that_cannot_be_is_refused_by_its_option(sooner, mission, command, seconds):
    ended = sooner(command, mission, "--seconds", seconds)
    assert ended.status == 2
    assert f"--seconds: {seconds} came; expected a finite number above 0" in ended.err


@pytest.mark.parametrize("replan", [(), ("--replan", "20")], ids=["once", "anew"])
def test_a_plan_that_came_is_flown_and_one_seed_is_one_answer(sooner, evidence, replan):
    assert sooner("plan", evidence, "--seconds", "0.2", "--planner", "greedy").status == 0
    came = evidence.parent / "mission-plan" / "plan.csv"
    first, again = (
        sooner("simulate", evidence, "--plan", came, "--trials", "5", "--json", "-q", *replan) for _ in range(2)
    )
    assert first.status == 0
    assert first.json == again.json
    assert (first.json["plan"], first.json["planner"]) == (str(came), None)
    folder = evidence.parent / "mission-simulation"
    assert (folder / "plan.csv").read_bytes() == came.read_bytes()
    assert first.json["value"]["promised"] == sooner("evaluate", evidence, came, "--json").json["value"]
    episode = load_plan_episode(folder / "episode.npz")
    assert plan_episode_npz(replayed_plan(episode, read_mission(evidence))) == (folder / "episode.npz").read_bytes()


@pytest.mark.parametrize("beside", [("--seconds", "3"), ("--planner", "greedy")])
def test_a_plan_that_came_is_not_made(sooner, evidence, tmp_path, beside):
    ended = sooner("simulate", evidence, "--plan", tmp_path / "plan.csv", *beside)
    assert ended.status == 2
    assert f"{beside[0]}: " in ended.err
    assert "beside --plan" in ended.err


def test_a_plan_that_cannot_be_flown_is_refused_by_the_judge(sooner, evidence, tmp_path):
    (tmp_path / "wrong.csv").write_text("row,col\n1,1\n3,3\n")
    ended = sooner("simulate", evidence, "--plan", tmp_path / "wrong.csv")
    assert ended.status == 2
    assert "wrong.csv" in ended.err
    assert not (evidence.parent / "mission-simulation").exists()


def test_help_names_every_strategy_and_the_default(sooner):
    told = " ".join(sooner("simulate", "--help").out.replace("│", " ").split())
    names = ", ".join(name for name in STRATEGIES if name != DEFAULT_STRATEGY)
    assert f"{names}, or {DEFAULT_STRATEGY}, which it is if left out" in told


def test_a_replan_for_a_person_is_refused_with_the_reason(sooner, mission):
    ended = sooner("simulate", mission, "--replan", "20")
    assert ended.status == 2
    assert "every look says no, which the plan counts on already" in ended.err


@pytest.mark.parametrize("replan", [(), ("--replan", "20")], ids=["once", "anew"])
def test_the_first_flight_of_a_plan_is_kept_drawn_and_animated(sooner, evidence, replan):
    options = ("--trials", "3", "--seed", "5", "--seconds", "0.2", "--planner", "greedy", "--animate", *replan)
    ended = sooner("simulate", evidence, *options)
    assert ended.status == 0
    assert "episode.png, episode.gif\n" in ended.out
    folder = evidence.parent / "mission-simulation"
    assert (folder / "episode.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "episode.gif").read_bytes().startswith(b"GIF")
    episode = load_plan_episode(folder / "episode.npz")
    row = (folder / "trials.csv").read_text().splitlines()[1].split(",")
    assert [episode.flown.seed, np.isfinite(episode.found).sum()] == [int(row[0]), int(row[2])]
    again = replayed_plan(episode, read_mission(evidence))
    assert plan_episode_npz(again) == (folder / "episode.npz").read_bytes()


def test_a_team_over_streets_is_animated_where_asked(sooner, city):
    ended = sooner("simulate", city, "--trials", "1", "--strategy", "lawnmower", "--animate")
    assert ended.status == 0
    assert "episode.png, episode.gif\n" in ended.out
    assert (city.parent / "mission-simulation" / "episode.gif").read_bytes().startswith(b"GIF")


def interrupted_after(count):
    """Trials until somebody presses Ctrl-C."""

    def flown(work, seeds, workers):
        for number, seed in enumerate(seeds):
            if number == count:
                raise KeyboardInterrupt
            yield work(seed)

    return flown


@pytest.mark.parametrize("count", [0, 3])
@pytest.mark.parametrize("over", ["streets", "cells", "cells, planned anew"])
def test_an_interrupted_simulation_keeps_its_flights(sooner, request, monkeypatch, over, count):
    path = request.getfixturevalue("city" if over == "streets" else "evidence")
    module = {"streets": "street_trials", "cells": "plan_trials", "cells, planned anew": "replanned"}[over]
    monkeypatch.setattr(f"sooner.missions.{module}.for_each_seed", interrupted_after(count))
    options = ("--strategy", "random") if over == "streets" else ("--seconds", "0.2", "--planner", "greedy")
    ended = sooner("simulate", path, "--trials", "9", *options, *(("--replan", "20") if "anew" in over else ()))
    assert ended.status == 130
    folder = path.parent / "mission-simulation"
    if not count:
        assert "nothing was written" in ended.err
        assert not folder.exists()
        return
    assert "interrupted; 3 of 9 flights are written" in ended.err
    assert len((folder / "trials.csv").read_text().splitlines()) == 4
    told = json.loads((folder / "simulation.json").read_text())
    assert told["trials"] == 3
    assert told["interrupted"]
    assert (folder / "episode.npz").exists()
