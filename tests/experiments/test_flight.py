"""The trial that a study flies if it names no other."""

import json

import numpy as np
import pytest

from sooner.campaigns.study import read_study
from sooner.campaigns.trial import Case, Place, Trial
from sooner.errors import DataFormatError, UnsupportedProblemError
from sooner.experiments.flight import check, cpu_seconds, fly, made, stopping
from sooner.missions import read_mission
from sooner.planners.greedy import Greedy
from sooner.planners.mode_goodness import ModeGoodness
from sooner.planners.topn import TopN
from sooner.problem import evaluate

MISSION = """
[area]
poc = "poc.csv"
[sensor]
glimpse = 0.5
[[searcher]]
start = [0, 0]
[[searcher]]
start = [3, 4]
[budget]
steps = 6
"""
SMALL = {"scenario": "bimodal", "size": 16}


@pytest.fixture
def folder(tmp_path):
    np.savetxt(tmp_path / "poc.csv", np.arange(20.0).reshape(4, 5), delimiter=",")
    (tmp_path / "m.toml").write_text(MISSION, encoding="utf-8")
    return tmp_path


def flown(planner, instance=SMALL, budget=12, seed=0, folder=""):
    settings = json.dumps({"instance": dict(instance), "planner": planner})
    return fly(Trial(Case("here", "mine", budget, settings), seed), Place("", str(folder)))


def test_a_scenario_is_planned_and_the_judge_says_what_the_plan_is_worth():
    found = flown({"name": "greedy"})
    assert set(found) == {"value", "bound", "gap", "efficiency", "status", "timing"}
    assert 0 < found["efficiency"] <= 1
    assert (found["bound"], found["gap"], found["status"]) == (None, None, "finished")
    json.dumps(found, allow_nan=False)


def test_ticks_and_a_seed_give_the_same_plan_every_time():
    first, again, other = (flown({"name": "anneal", "ticks": 3}, budget=40, seed=seed) for seed in (1, 1, 2))
    assert first["value"] == again["value"] != other["value"]
    assert first["status"] == "stopped"


def test_an_instance_may_take_its_seed_from_the_trial_and_is_then_another_search_for_each_seed():
    for seed in (1, 2):
        drawn = flown({"name": "greedy"}, {**SMALL, "seed": "trial"}, seed=seed)
        assert drawn["value"] == flown({"name": "greedy"}, {**SMALL, "seed": seed})["value"]
    one, other = (flown({"name": "greedy"}, {**SMALL, "seed": "trial"}, seed=seed)["value"] for seed in (1, 2))
    assert one != other


def test_an_instance_whose_seed_is_the_trials_is_not_refused(folder):
    here = 'here = { scenario = "bimodal", seed = "trial" }'
    text = f'title = "S"\n[instances]\n{here}\n[planners]\nmine = {{ name = "greedy" }}\n'
    (folder / "study.toml").write_text(text, encoding="utf-8")
    check(read_study(folder))


def test_a_mission_for_two_stands_beside_the_study_and_a_budget_replaces_its_steps(folder):
    instance = {"mission": "m.toml"}
    own = flown({"name": "greedy"}, instance, None, folder=folder)
    longer = flown({"name": "greedy"}, instance, 15, folder=folder)
    assert longer["value"] > own["value"]
    assert read_mission(folder / "m.toml").problem.searchers[0].budget == 6


def test_a_bound_is_proved_beside_it_where_the_study_says_so():
    found = flown({"name": "anneal", "ticks": 20, "proved": True})
    assert found["value"] <= found["bound"]
    assert found["gap"] == pytest.approx(max(found["bound"] - found["value"], 0) / found["bound"])


def test_a_value_that_is_not_there_is_null(folder):
    (folder / "m.toml").write_text(
        MISSION.replace("[[searcher]]\nstart = [3, 4]\n", "") + "[objective]\ndetection_target = 0.99\n",
        encoding="utf-8",
    )
    found = flown({"name": "greedy"}, {"mission": "m.toml"}, None, folder=folder)
    assert (found["value"], found["efficiency"]) == (None, None)


def test_a_planner_that_cannot_plan_it_says_why(folder):
    with pytest.raises(UnsupportedProblemError, match="searcher"):
        flown({"make": "sooner.planners.greedy:Greedy"}, {"mission": "m.toml"}, None, folder=folder)


# What a study says of planners ---------------------------------------------------------------------------------------


def test_made_makes_planners_and_what_their_settings_name():
    assert made({"name": "greedy"}).cells == Greedy()
    goodness = {"make": "sooner.planners.mode_goodness:ModeGoodness", "exponent": 2.0}
    found = made({"make": "sooner.planners.topn:TopN", "layers": [[5, 3]], "goodness": goodness})
    assert found == TopN(layers=((5, 3),), goodness=ModeGoodness(exponent=2.0))


def test_a_table_of_settings_that_names_nothing_is_refused():
    with pytest.raises(DataFormatError, match=r"expected \{ name = NAME \} or"):
        made({"make": "sooner.planners.topn:TopN", "goodness": {"exponent": 2.0}})


def test_the_stop_rule_is_taken_out_of_the_settings():
    said = {"name": "anneal", "ticks": 5}
    assert stopping(said) is not None
    assert said == {"name": "anneal"}
    assert stopping(said) is None


def test_cpu_seconds_count_from_when_the_rule_is_made():
    rule = cpu_seconds(1e9)
    assert not rule.met(None)
    assert 0 <= rule.share(None) < 1
    assert cpu_seconds(1e-9).met(None)


# What is refused before anything is flown ----------------------------------------------------------------------------


def refused(folder, instance='{ scenario = "bimodal" }', planner='{ name = "greedy" }', budgets="[40]"):
    text = f'title = "S"\nbudgets = {budgets}\n[instances]\nhere = {instance}\n[planners]\nmine = {planner}\n'
    (folder / "study.toml").write_text(text, encoding="utf-8")
    with pytest.raises(DataFormatError) as raised:
        check(read_study(folder))
    return str(raised.value)


@pytest.mark.parametrize(
    ("instance", "told"),
    [
        ("{ place = 3 }", "instances.here: {'place': 3} came; expected mission = FILE or scenario = NAME"),
        ('{ mission = "m.toml", scenario = "bimodal" }', "expected mission = FILE or scenario = NAME"),
        ('{ scenario = "moon" }', "instances.here.scenario: 'moon' came; expected many-hills"),
        ('{ scenario = "bimodal", width = 3 }', "instances.here.width: there is no such key; expected seed or size"),
        ('{ scenario = "bimodal", seed = 1.5 }', "instances.here.seed: 1.5 came; expected a whole number"),
        ('{ scenario = "bimodal", seed = "trail" }', "'trail' came; expected a whole number or \"trial\""),
        ('{ scenario = "bimodal", size = "trial" }', "instances.here.size: 'trial' came; expected a whole number"),
        ('{ mission = "m.toml", seed = "trial" }', "instances.here.seed: there is no such key; expected mission alone"),
        ('{ mission = "m.toml", seed = 3 }', "instances.here.seed: there is no such key; expected mission alone"),
        ('{ mission = "none.toml" }', "none.toml"),
    ],
)
def test_an_instance_that_cannot_be_flown_is_refused(folder, instance, told):
    assert told in refused(folder, instance)


def test_every_fault_of_a_mission_is_told(folder):
    (folder / "m.toml").write_text(MISSION.replace("steps = 6", "steps = 0").replace("0.5", "2.0"), encoding="utf-8")
    told = refused(folder, '{ mission = "m.toml" }')
    assert "budget.steps" in told
    assert "sensor.glimpse" in told


@pytest.mark.parametrize(
    ("planner", "told"),
    [
        ("{ width = 3 }", 'expected name = NAME or make = "module:Class"'),
        ('{ name = "greedy", make = "a:B" }', 'expected name = NAME or make = "module:Class"'),
        ('{ name = "clever" }', "planners.mine: planner 'clever' came; expected one of anneal"),
        ('{ name = "greedy", width = 3 }', "unexpected keyword argument 'width'"),
        ('{ make = "my_planner" }', "planners.mine: 'my_planner' came; expected \"module:Class\""),
        ('{ make = "sooner.planners.topn:Topm" }', "no attribute 'Topm'"),
        ('{ make = "sooner.planners.topm:TopN" }', "No module named"),
        ('{ name = "anneal", ticks = 3, seconds = 3 }', "ticks and seconds came; expected one of them"),
        ('{ name = "anneal", ticks = 3.5 }', "ticks = 3.5 came; expected a whole number above 0"),
        ('{ name = "anneal", seconds = 0 }', "seconds = 0 came; expected a number above 0"),
        ('{ name = "anneal", seconds = true }', "seconds = True came"),
        ('{ name = "anneal", proved = 1 }', "proved = 1 came; expected true or false"),
    ],
)
def test_a_planner_that_cannot_be_made_is_refused(folder, planner, told):
    assert told in refused(folder, planner=planner)


@pytest.mark.parametrize("budget", ["0", "-3", "2.5"])
def test_a_budget_that_is_no_number_of_steps_is_refused(folder, budget):
    assert f"budgets: {budget} came; expected steps" in refused(folder, budgets=f"[{budget}]")


def test_all_faults_are_told_at_once(folder):
    told = refused(folder, "{}", "{}", "[0]")
    assert [line.split(": ")[1] for line in told.splitlines()] == ["instances.here", "budgets", "planners.mine"]


def test_a_planner_of_the_users_own_is_not_loaded_to_be_checked(folder):
    text = (
        'title = "S"\n[instances]\nhere = { scenario = "bimodal" }\n[planners]\nmine = { make = "my_planner:Mine" }\n'
    )
    (folder / "my_planner.py").write_text("raise SystemExit", encoding="utf-8")
    (folder / "study.toml").write_text(text, encoding="utf-8")
    check(read_study(folder))


def test_a_plan_of_a_trial_is_worth_what_the_judge_says():
    from sooner.planners import solve
    from sooner.scenarios import bimodal

    problem = bimodal(size=16).problem(12)
    assert flown({"name": "greedy"})["value"] == evaluate(problem, solve(problem, Greedy()).best.plan).value
